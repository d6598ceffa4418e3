"""The 2-DOF manipulator with two RRR legs and a passive RP leg (Nam and Park 2006)."""
