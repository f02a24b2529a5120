"""What stands in the laboratory: the box in prescribed motion or on a shaker, its ledger, its channels."""
