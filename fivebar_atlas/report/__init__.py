"""Reports: one self-contained HTML page of a run. Knows no figures, only their SVG."""
