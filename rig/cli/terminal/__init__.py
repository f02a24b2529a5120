"""Terminal output shared by the commands: tables, live view, files."""
