"""What a plan tolerates: how far the world may be off before its modes and forces no longer hold.

Works on finished plans with the reference's programs alone; it plans nothing.
"""
