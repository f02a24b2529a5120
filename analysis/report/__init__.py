"""The report in its forms: sentences, tables, figures and files, all made from one Report."""
