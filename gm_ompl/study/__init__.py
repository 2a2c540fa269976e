"""Measurements whose tables stand in the documentation."""
