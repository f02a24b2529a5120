"""The experiment as data: its typed fields, reading and checking a protocol, the grid of conditions."""
