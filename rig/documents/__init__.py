"""Strict YAML in and out, any document: every mistake at once, with its line and the nearest name.
It knows no physics."""
