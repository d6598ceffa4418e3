"""Numerical tools that know no mechanism: quadrature rules, root brackets, circle arcs."""
