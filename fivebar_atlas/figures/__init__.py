"""Figures: one look, one file for each kind of map; the only place that uses matplotlib."""
