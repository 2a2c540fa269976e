"""The manipulation-feasibility graph of Sec. 4: nodes, arcs, costs, heuristics. No OMPL."""
