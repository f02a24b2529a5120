"""What is needed of a record: its interface, its settings, its documents."""
