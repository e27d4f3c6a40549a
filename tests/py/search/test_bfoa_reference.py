"""Passino's algorithm in the core, move by move against a plain one in Python."""

import math

import nfopidn
import numpy as np
import pytest
import reference_bfoa
from numpy.testing import assert_allclose, assert_array_equal
from reference_bfoa import hills

EXACT = {"rtol": 1e-12, "atol": 1e-12}
NO_SWARMING = {"attractant_depth": 0, "repellent_height": 0}


def slope(x):
    """Least at a corner, so that cells run along the walls."""
    return sum(x)


def cliff(x):
    """No cost on the left."""
    return math.inf if x[0] < 0 else hills(x)


CASES = {
    "defaults": (1, 2, hills, {}),
    "another seed": (2**53, 2, hills, {}),
    "without swarming": (3, 3, hills, NO_SWARMING),
    "without repellent": (4, 2, hills, {"repellent_height": 0}),
    "without attractant": (5, 2, hills, {"attractant_depth": 0}),
    "strong, wide signals": (
        6,
        4,
        hills,
        {
            "attractant_depth": 2.5,
            "attractant_width": 3,
            "repellent_height": 1.5,
            "repellent_width": 40,
        },
    ),
    "one coordinate": (7, 1, hills, {}),
    "eleven coordinates": (8, 11, hills, {"cells": 6, "dispersals": 2}),
    "no swims": (9, 2, hills, {"swims": 0}),
    "long swims": (10, 3, hills, {"swims": 40, "step": 0.01}),
    "two cells": (11, 2, hills, {"cells": 2}),
    "many cells": (12, 2, hills, {"cells": 26, "chemotactic_steps": 3}),
    "one lifetime": (13, 2, hills, {"reproductions": 1, "dispersals": 1}),
    "all dispersed": (14, 2, hills, {"dispersal_probability": 1}),
    "none dispersed": (15, 2, hills, {"dispersal_probability": 0}),
    "half dispersed": (
        16,
        3,
        hills,
        {"dispersal_probability": 0.5, "dispersals": 12, "reproductions": 1},
    ),
    "against the walls": (17, 3, slope, {"step": 0.4}),
    "infinite costs": (20, 2, cliff, {"step": 0.1}),
    "wide, then not at all": (18, 2, hills, {"step": 2}),
    "at rest": (19, 2, hills, {"step": 0}),
}


@pytest.mark.parametrize(("seed", "p", "func", "options"), CASES.values(), ids=CASES.keys())
def test_moves_are_the_reference_s(seed, p, func, options):
    bounds = [(-1.0 - i, 2.0 + 3 * i) for i in range(p)]
    reference = reference_bfoa.forage(func, bounds, seed, **options)
    points = []

    def recorded(x):
        points.append(x.copy())
        return func(x)

    result = nfopidn.bfoa(recorded, bounds, method="bfoa", rng=seed, options=options)
    assert len(points) == len(reference.points)
    assert_allclose(points, reference.points, **EXACT)
    best = int(np.argmin(reference.costs))
    assert result.nfev == len(points)
    assert_allclose(result.x, reference.points[best], **EXACT)
    assert_allclose(result.fun, reference.costs[best], **EXACT)
    history = np.array(reference.history)
    for column, name in enumerate(("l", "k", "j", "nfev")):
        assert_array_equal(result.history[name], history[:, column])
    assert_allclose(result.history["best"], history[:, 4], **EXACT)
    assert_allclose(result.history["mean"], history[:, 5], **EXACT)
    assert_array_equal(result.history["step"], options.get("step", 0.05))
    low, high = np.array(bounds).T
    assert_allclose(result.population, low + (high - low) * reference.population, **EXACT)
    assert_allclose(result.population_energies, reference.population_costs, **EXACT)
    assert result.message == "The schedule is complete."


def test_the_generator_is_the_standard_s():
    """C++ fixes the ten thousandth word of std::mt19937_64."""
    engine = reference_bfoa.Mt19937x64(5489)
    assert [engine.word() for _ in range(10000)][-1] == 9981545732273789042


def test_a_swim_ends_where_the_last_place_was_no_worse():
    """The tumble lowers every cost by the same; only a swim compared with the last one ends."""
    calls = []

    def falling_once(x):
        calls.append(len(calls))
        return 1.0 if len(calls) <= 2 else 0.0

    options = {**NO_SWARMING, "cells": 2, "reproductions": 1, "dispersals": 1}
    options |= {"chemotactic_steps": 1, "dispersal_probability": 0}
    result = nfopidn.bfoa(falling_once, [(0, 1)] * 2, method="bfoa", rng=1, options=options)
    assert result.nfev == 2 + 2 + 2  # the start, the tumble, one swim that improves nothing
