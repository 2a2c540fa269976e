"""Shapes and places; knows no forces."""
