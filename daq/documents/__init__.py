"""Strict reading of plain data, without YAML: the documents in a session."""
