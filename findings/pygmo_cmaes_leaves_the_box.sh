#!/usr/bin/env bash
# pygmo: cmaes and xnes search outside the bounds of the problem and return a champion from there.
#
# One would guess: get_bounds() limits the search, as it does for other algorithms of the library (de, sade, pso),
#   whose evaluations all lie within.
# What happens: cmaes and xnes take the bounds only to scale the first step. For a parabola with its minimum at -0.5 in
#   the box [0, 1]^3 more than nine tenths of their evaluations lie outside, and the population's champion is -0.5, with
#   a better fitness than anything allowed. force_bounds=True keeps them inside; it is False by default.
# Why it matters: gains that must be positive come back negative, fractional orders above their range, from the
#   algorithm that is the first choice for such searches. Compared by fitness it beats all honest ones.
# Seen with: pygmo 2.20.0.
# Source: https://github.com/esa/pagmo2/blob/master/include/pagmo/algorithms/cmaes.hpp (force_bounds, false by default:
#   only then is the fitness never called outside).
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check pygmo==2.20.0 numpy==2.4.6

"$work/venv/bin/python" - <<'PYTHON'
import numpy as np
import pygmo


class Parabola:
    """Three parameters in [0, 1]; the minimum, at -0.5 each, is outside, the best allowed is 0.75 at 0."""

    evaluated: list = []

    def fitness(self, x):
        Parabola.evaluated.append(np.array(x))
        return [float(np.sum((x + 0.5) ** 2))]

    def get_bounds(self):
        return [0.0] * 3, [1.0] * 3


def search(name, algorithm):
    Parabola.evaluated = []
    population = pygmo.population(pygmo.problem(Parabola()), 20, seed=1)
    population = pygmo.algorithm(algorithm).evolve(population)
    points = np.array(Parabola.evaluated)
    outside = np.mean(np.any((points < 0.0) | (points > 1.0), axis=1))
    print(f"{name:26s} {outside:5.1%} of {len(points)} evaluations outside, champion "
          f"{np.round(population.champion_x, 3)}, fitness {population.champion_f[0]:.3f}")
    return outside, population.champion_f[0]


free = [search(name, getattr(pygmo, name)(gen=50, seed=1)) for name in ("cmaes", "xnes")]
kept = [search(f"{name}, force_bounds", getattr(pygmo, name)(gen=50, seed=1, force_bounds=True))
        for name in ("cmaes", "xnes")]
kept += [search(name, getattr(pygmo, name)(gen=50, seed=1)) for name in ("de", "sade", "pso")]
assert all(outside > 0.5 and fitness < 0.1 for outside, fitness in free), "the two algorithms now keep the bounds"
assert all(outside == 0.0 and fitness >= 0.75 for outside, fitness in kept), "another algorithm leaves the box now"
PYTHON
