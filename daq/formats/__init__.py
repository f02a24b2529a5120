"""Files of other tools: records written for them, and their records read."""
