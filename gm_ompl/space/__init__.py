"""The same configurations for OMPL: state space, validity, motions, objective and goal."""
