"""Passino's bacterial foraging in plain Python, for comparison with the core's.

It shares the core's random draws and their order, and nothing else. Run as a program it prints
tests/golden/bfoa.csv.
"""

import math
from dataclasses import dataclass, field

BITS = 2**64 - 1


class Mt19937x64:
    """Matsumoto's and Nishimura's 64-bit Mersenne Twister."""

    def __init__(self, seed):
        self.state = [seed & BITS]
        for i in range(1, 312):
            last = self.state[-1]
            self.state.append((6364136223846793005 * (last ^ (last >> 62)) + i) & BITS)
        self.place = 312

    def twist(self):
        s = self.state
        for i in range(312):
            word = (s[i] & 0xFFFFFFFF80000000) | (s[(i + 1) % 312] & 0x7FFFFFFF)
            s[i] = s[(i + 156) % 312] ^ (word >> 1) ^ (0xB5026F5AA96619E9 if word & 1 else 0)
        self.place = 0

    def word(self):
        if self.place == 312:
            self.twist()
        x = self.state[self.place]
        self.place += 1
        x ^= (x >> 29) & 0x5555555555555555
        x ^= (x << 17) & 0x71D67FFFEDA60000
        x ^= (x << 37) & 0xFFF7EEE000000000
        return x ^ (x >> 43)

    def uniform(self):
        """Give a multiple of 2^-53 in [0, 1)."""
        return (self.word() >> 11) * 2.0**-53


@dataclass
class Run:
    """What the reference did: all points and costs in their order, a history row a step."""

    points: list = field(default_factory=list)
    costs: list = field(default_factory=list)
    history: list = field(default_factory=list)  # l, k, j, nfev, best, mean
    population: list = field(default_factory=list)
    population_costs: list = field(default_factory=list)


def forage(
    func,
    bounds,
    seed,
    cells=10,
    chemotactic_steps=14,
    swims=5,
    reproductions=4,
    dispersals=3,
    dispersal_probability=0.25,
    step=0.05,
    attractant_depth=0.1,
    attractant_width=0.2,
    repellent_height=0.1,
    repellent_width=10.0,
):
    draw = Mt19937x64(seed).uniform
    run = Run()

    def cost_of(place):
        point = [low + (high - low) * u for u, (low, high) in zip(place, bounds, strict=True)]
        run.points.append(point)
        run.costs.append(func(point))
        return run.costs[-1]

    def anywhere():
        return [draw() for _ in bounds]

    def heading():
        direction = [2 * draw() - 1 for _ in bounds]
        length = math.sqrt(sum(d * d for d in direction))
        return [d / length for d in direction]

    def ahead(place, direction):
        return [min(1.0, max(0.0, u + step * d)) for u, d in zip(place, direction, strict=True)]

    def signal(place, others):  # J_cc
        total = 0.0
        for other in others:
            square = sum((a - b) ** 2 for a, b in zip(place, other, strict=True))
            total -= attractant_depth * math.exp(-attractant_width * square)
            total += repellent_height * math.exp(-repellent_width * square)
        return total

    def felt():
        return [j + signal(place, places) for j, place in zip(costs, places, strict=True)]

    def chemotaxis():
        seen = list(places)
        directions = [heading() for _ in places]
        last = felt()
        moving = list(range(cells))
        for _ in range(1 + swims):  # the tumble and the swims
            for i in moving:
                places[i] = ahead(places[i], directions[i])
                costs[i] = cost_of(places[i])
            now = {i: costs[i] + signal(places[i], seen) for i in moving}
            moving = [i for i in moving if now[i] < last[i]]
            for i in moving:
                last[i] = now[i]

    places = [anywhere() for _ in range(cells)]
    costs = [cost_of(place) for place in places]
    for ell in range(dispersals):
        for k in range(reproductions):
            health = felt()
            for j in range(chemotactic_steps):
                chemotaxis()
                health = [sum(pair) for pair in zip(health, felt(), strict=True)]
                mean = sum(costs) / cells
                run.history.append((ell, k, j, len(run.costs), min(run.costs), mean))
                run.population, run.population_costs = list(places), list(costs)
            fittest = sorted(range(cells), key=lambda i: health[i])[: cells // 2]
            places = [places[i] for i in fittest + fittest]
            costs = [costs[i] for i in fittest + fittest]
        scattered = []
        for i in range(cells):
            if draw() < dispersal_probability:
                places[i] = anywhere()
                scattered.append(i)
        for i in scattered:
            costs[i] = cost_of(places[i])
    return run


def hills(x):
    """Many minima; the least is at (0.3, 0.6, 0.9, ...)."""
    return sum((u - 0.3 * i) ** 2 + 0.1 * math.cos(9 * u) for i, u in enumerate(x, 1))


# Of the golden file, in its order; tests/cpp/search/test_bfoa.cpp has the same.
SHORT = {"chemotactic_steps": 6, "reproductions": 2, "dispersals": 3}
SIGNALS = {
    "attractant_depth": 2.5,
    "attractant_width": 3,
    "repellent_height": 1.5,
    "repellent_width": 40,
}
GOLDEN = [
    (1, 2, SHORT),
    (6, 4, SHORT | SIGNALS),
    (16, 3, SHORT | {"dispersal_probability": 0.5, "cells": 6}),
    (17, 3, SHORT | {"step": 0.4}),
    (10, 2, SHORT | {"swims": 12, "step": 0.01, "attractant_depth": 0, "repellent_height": 1}),
    (4, 2, SHORT | {"attractant_depth": 1, "repellent_height": 0}),
]


def print_golden():
    print("case,l,k,j,nfev,best,mean")
    for case, (seed, p, options) in enumerate(GOLDEN):
        bounds = [(-1.0 - i, 2.0 + 3 * i) for i in range(p)]
        for row in forage(hills, bounds, seed, **options).history:
            print(case, *map(repr, row), sep=",")


if __name__ == "__main__":
    print_golden()
