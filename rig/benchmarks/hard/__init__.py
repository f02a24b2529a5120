"""Hard cases: each provokes a failure, says what is required, and measures it against something independent."""
