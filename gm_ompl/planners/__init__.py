"""Planners: from a Problem to a Plan."""
