"""What holds where: sets of placements, tables by arc, bounds, and what was decided of each set.

Exact and sampled search both drive it; neither is known here.
"""
