"""What the grains do to the box: one small module a bed, one registry."""
