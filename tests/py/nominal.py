"""Searches over scenarios as they are: what most tests of searches are about."""

from nfopidn import tune as robust_tune


def tune(*scenario, **arguments):
    """Tune without variations, unless robustness is asked for."""
    return robust_tune(*scenario, **({"robustness": None} | arguments))
