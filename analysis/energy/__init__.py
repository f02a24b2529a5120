"""Energy per cycle from force and acceleration."""
