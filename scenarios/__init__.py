"""Scenarios that ship with gm_ompl, as YAML files in folders."""
