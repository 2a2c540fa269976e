"""Scenario files: read, checked, resolved, and made into a Problem."""
