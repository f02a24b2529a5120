"""Which runs there are, where they are computed, recorded, resumed: the only place that sees all three packages."""
