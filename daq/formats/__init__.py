"""Files of other tools: records written for them, and theirs read."""
