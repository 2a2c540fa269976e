"""The paper's search and the contact lattice stated plainly: a second pair of eyes on planners."""
