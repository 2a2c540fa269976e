"""OMPL's planners, and for them the problem as a space with validity, motions, costs and a goal.

The only import of OMPL; only ``table`` can be read without loading it.
"""
