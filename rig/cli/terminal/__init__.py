"""What commands share on the terminal: tables, live view, files."""
