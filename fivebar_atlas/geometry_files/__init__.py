"""The geometry of one design as files for other programs: tables, drawings, CAD."""
