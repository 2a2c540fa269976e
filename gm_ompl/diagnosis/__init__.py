"""Why there is no plan on the lattice, or none with given placements, and what would help."""

SECONDS = 30.0
"""What an explanation may take, its searches included."""
