#!/usr/bin/env bash
# SciPy: a Sobol sequence of more than 32 bits cannot be fast-forwarded.
#
# One would guess: `scipy.stats.qmc.Sobol(d, bits=64).fast_forward(n)` skips n points, as it does with the default of
#   30 bits: "bits" is documented up to 64, for more than 2**30 points and for numbers of full resolution.
# What happens: any engine of more than 32 bits raises "ValueError: Buffer dtype mismatch, expected 'const uint32_t' but
#   got 'unsigned long'", from the first point or later on; drawing works. Only fast_forward(1) after random(1), which
#   skips one point by another way, does not fail.
# Why it matters: shares of one design for several workers, or a run that goes on after a break, need a place in the
#   middle of the sequence. A program that draws all its points in one block works in its tests, and fails at the
#   second block of the first large analysis. What helps: point i is the first one with the directions of the Gray code
#   of i, so that any place is reached in as many steps as it has bits (fast_forward() takes one a point); or 32 bits.
# Seen with: scipy 1.17.1, numpy 2.4.6.
# Source: https://docs.scipy.org/doc/scipy/reference/generated/scipy.stats.qmc.Sobol.html ("bits"); 64 bits came with
#   https://github.com/scipy/scipy/pull/15712.
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check scipy==1.17.1 numpy==2.4.6

"$work/venv/bin/python" - <<'PYTHON'
import numpy as np
from scipy.stats import qmc

POINTS, SKIPPED = 64, 16


def engine(bits):
    return qmc.Sobol(3, bits=bits, rng=np.random.default_rng(1))


def after_skipping(bits, drawn):
    """Return whether the points behind the skipped ones are those of the whole sequence; or what is raised."""
    one = engine(bits)
    try:
        if drawn:
            one.random(drawn)
        one.fast_forward(SKIPPED - drawn)
        return bool((one.random(POINTS - SKIPPED) == engine(bits).random(POINTS)[SKIPPED:]).all())
    except ValueError as error:
        return str(error)


print(f"{SKIPPED} of {POINTS} points skipped:")
replies = {}
for bits in (30, 32, 33, 53, 64):
    for drawn in (0, 4):
        replies[bits, drawn] = after_skipping(bits, drawn)
        print(f"  {bits} bits, {drawn} points drawn before: {replies[bits, drawn]}")
for (bits, _), reply in replies.items():
    if bits <= 32:
        assert reply is True, "up to 32 bits it no longer works"
    else:
        assert "Buffer dtype mismatch" in str(reply), "more than 32 bits no longer fail"
PYTHON
