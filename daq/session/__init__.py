"""Session files: written by one writer, readable by anybody, validated, copied."""
