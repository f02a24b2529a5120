"""`fidelity: auto`: the rows, settling and record that a tolerance of W requires, measured on the
scene itself.
"""
