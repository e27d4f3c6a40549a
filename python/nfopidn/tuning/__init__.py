"""Tuning of controllers: what is searched for, its cost, the search, its result."""
