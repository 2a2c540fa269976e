"""Why there is no plan on the lattice, or none with given placements, and what would help."""
