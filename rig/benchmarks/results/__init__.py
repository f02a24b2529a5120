"""The results of the measurements: curves, claims, tables, figures, a page."""
