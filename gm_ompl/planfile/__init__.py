"""Plan values, plan files, and the assembly of plans from a planner's moves."""
