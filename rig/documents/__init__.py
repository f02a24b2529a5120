"""Read any YAML document strictly, and write it: every mistake at once, with its line and the most
similar name. No physics."""
