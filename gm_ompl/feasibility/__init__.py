"""The acceptance tests of Sec. 4.2: is a node valid, is an arc feasible, may a finger be lifted."""
