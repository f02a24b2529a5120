"""The problems measured, one module each, and the references for their answers."""
