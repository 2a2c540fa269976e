"""Randomised planning between the lattice's nodes; no OMPL and no planner here."""
