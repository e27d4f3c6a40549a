#!/usr/bin/env bash
# SciPy, python-control: a filter taken to state space and back is another filter, wrong by any factor.
#
# One would guess: an FIR filter with a few hundred taps survives tf -> ss -> tf with rounding errors of 1e-12, since
#   its state space is a chain of delays with the taps as the output row.
# What happens: the way back runs through the characteristic polynomials of two matrices, from their eigenvalues. All
#   poles of an FIR filter lie at zero and are as ill-conditioned as they can be. For the taps of a half derivative
#   the response is off by 6e-6 with 51 taps, by twice itself with 101, by a factor of 1e19 with 201. No
#   warning, no NaN. The matrices are right to 1e-15, but scipy.signal.dfreqresp of the state space gives the same
#   wrong response, as it takes that way inside. python-control without slycot gives SciPy's numbers.
# Why it matters: fractional controllers are such filters. Whoever loads one into state space and looks at
#   its Bode plot, or reads the transfer function back, sees and stores another controller.
# Seen with: scipy 1.17.1, control 0.10.2.
# Source: https://github.com/scipy/scipy/issues/5914 and https://github.com/scipy/scipy/issues/3560 (conversions
#   through polynomials lose all accuracy), https://github.com/scipy/scipy/issues/17405 (ss2tf invents a zero).
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check control==0.10.2 numpy==2.4.6 scipy==1.17.1

"$work/venv/bin/python" -W ignore - <<'PYTHON'
import control
import numpy as np
import scipy.signal


def half_derivative(memory):
    """Return the first taps of (1 - 1/z)^0.5, by their recursion."""
    taps = np.ones(memory + 1)
    for j in range(1, memory + 1):
        taps[j] = taps[j - 1] * (1.0 - 1.5 / j)
    return taps


ANGLE = 0.3  # [rad/sample]
Z = np.exp(1j * ANGLE)
errors = {}
print("relative error of the response at 0.3 rad/sample:")
for memory in (20, 50, 100, 200):
    taps = half_derivative(memory)
    delays = np.r_[1.0, np.zeros(memory)]
    exact = np.polyval(taps, Z) / Z**memory

    state_space = scipy.signal.dlti(taps, delays, dt=0.1).to_ss()
    a, b, c, d = state_space.A, state_space.B, state_space.C, state_space.D
    solved = (c @ np.linalg.solve(Z * np.eye(memory) - a, b) + d)[0, 0]
    plotted = scipy.signal.dfreqresp(state_space, w=[ANGLE])[1][0]
    back = scipy.signal.dfreqresp(state_space.to_tf(), w=[ANGLE])[1][0]
    other = control.tf(control.ss(control.tf(taps, delays, 0.1)))(Z)
    errors[memory] = [abs(value / exact - 1.0) for value in (solved, plotted, back, other)]
    print("  {:3d} taps: matrices {:.0e}; dfreqresp of them {:.0e}; back as tf, SciPy {:.0e}, control {:.0e}".format(
        memory + 1, *errors[memory]))

assert all(found[0] < 1e-12 for found in errors.values()), "the matrices themselves are no longer right"
assert min(errors[100][1:]) > 0.1 and min(errors[200][1:]) > 1e6, "the way back no longer loses the filter"
PYTHON
