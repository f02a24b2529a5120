"""Bed models: the reaction of the grains on the box. One small module a bed, one registry."""
