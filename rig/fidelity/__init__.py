"""`fidelity: auto`: the rows, settling and record that a tolerance of W needs, measured on the scene itself."""
