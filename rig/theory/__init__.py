"""The paper's equations with the errata of docs/model.md applied: plain numbers in, plain numbers
out.
"""
