#!/usr/bin/env bash
# IPOPT through CasADi: an optimal torque is larger than its bound, and the solver reports success.
#
# One would guess: an interior-point method approaches bounds from inside, so the result of lbx <= x <= ubx
#   satisfies them, if anything with some distance.
# What happens: IPOPT widens every bound by 1e-8 of its size before it starts and stops at the widened one. The
#   minimiser of (x - 2)^2 over [-1, 1] is returned as 1.0000000087. For a bound of zero the widening is absolute, so that a
#   quantity that must not be negative (a speed, a variable under a square root) comes back as -1e-8: its root is NaN
#   afterwards. honor_original_bounds and bound_relax_factor=0 cure both.
# Why it matters: an optimal open loop replayed through a check of the torque limit is refused at its first saturated
#   sample; the limit has to be tested with a tolerance, or the result clipped before use.
# Seen with: casadi 3.8.2.
# Source: https://github.com/coin-or/Ipopt/issues/603 and https://github.com/coin-or/Ipopt/issues/619 (the maintainers:
#   bound_relax_factor), https://github.com/IDAES/idaes-pse/issues/1567 (1e-8 by default; roots and logarithms fail).
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check casadi==3.8.2 numpy==2.4.6

"$work/venv/bin/python" - <<'PYTHON'
import casadi


def solve(target, lower, upper, **options):
    """Minimise (x - target)^2 in a box; return x and whether IPOPT says that it succeeded."""
    x = casadi.SX.sym("x")
    quiet = {"print_time": 0, "ipopt": {"print_level": 0, "sb": "yes", **options}}
    solver = casadi.nlpsol("solver", "ipopt", {"x": x, "f": (x - target) ** 2}, quiet)
    found = float(solver(x0=0.5, lbx=lower, ubx=upper)["x"])
    print(f"  x in [{lower:g}, {upper:g}], {options or 'defaults'}: x = {found:.12g}, success {solver.stats()['success']}")
    return found, solver.stats()["success"]


print("the least of (x - 2)^2, then of (x + 2)^2:")
torque = solve(2.0, -1.0, 1.0)
speed = solve(-2.0, 0.0, 1.0)
honoured = solve(2.0, -1.0, 1.0, honor_original_bounds="yes")
exact = solve(2.0, -1.0, 1.0, bound_relax_factor=0.0)
assert torque[1] and 1e-10 < torque[0] - 1.0 < 2e-8, "the upper bound is kept now"
assert speed[1] and -2e-8 < speed[0] < -1e-10, "the bound of zero is kept now"
assert honoured[0] <= 1.0 and exact[0] <= 1.0, "the remedies no longer work"
PYTHON
