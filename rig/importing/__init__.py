"""Records of others: mapping, checking, to a session."""
