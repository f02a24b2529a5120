"""The report: one dict in, sentences, tables, figures and files out."""
