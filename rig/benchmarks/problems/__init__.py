"""What is measured: one module a problem, and the references that answers are compared with."""
