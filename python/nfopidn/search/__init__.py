"""Searches for the minimum of any function."""
