"""Why there is no plan, or none with given placements."""
