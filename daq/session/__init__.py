"""Session files: written by one writer, read by anybody, validated, copied."""
