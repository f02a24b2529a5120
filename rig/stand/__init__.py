"""The test stand: the box in prescribed motion or on a shaker, its energy ledger, its channels."""
