"""Motions of machines from files, solved, and written as trajectories."""
