"""Turning knobs: what can be turned, the runs that plan anew, the site that serves them.

How a plan looks lives in ``viz``; ``app`` brings both together.
"""
