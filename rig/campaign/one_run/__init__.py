"""The road of one run: how it starts, what is recorded, what is deliberately done wrong."""
