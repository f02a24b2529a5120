"""The paper's equations after the errata of docs/model.md: plain numbers in, plain numbers out."""
