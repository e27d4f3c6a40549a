"""Logs of a robot that an integrator of its own moves, which knows nothing of the package."""

import numpy as np

MASS, INERTIA, COULOMB, VISCOUS = 9.3, 0.33, 0.15, 0.03
TRACK, RADIUS = 0.452, 0.076
DT = 0.05


def steps(samples, seed=0, swing=1.0):
    """Sums and differences of torques that change in steps of 0.5 to 1.5 s."""
    rng = np.random.default_rng(seed)
    waves = []
    for strength in (1.0, 0.45 * swing):
        wave = np.concatenate(
            [np.full(rng.integers(10, 30), rng.uniform(-1, 1)) for _ in range(samples // 10 + 1)]
        )[:samples]
        waves.append(strength * wave)
    return np.column_stack([waves[0] + waves[1], waves[0] - waves[1]])


def drive(torque, delay=0, fine=25):
    """Poses, speeds (n, 5) under torques (n, 2) in the paper's sign, with wheels that may stick."""
    state = np.zeros(5)
    rows = [state.copy()]
    late = np.vstack([np.zeros((delay, 2)), torque])[: len(torque)]
    h = DT / fine
    inverse = np.array(
        [
            [1 / MASS + TRACK**2 / 4 / INERTIA, 1 / MASS - TRACK**2 / 4 / INERTIA],
            [1 / MASS - TRACK**2 / 4 / INERTIA, 1 / MASS + TRACK**2 / 4 / INERTIA],
        ]
    )  # speeds of the wheels' rims by forces there
    rim = np.zeros(2)
    for pair in late[:-1]:
        for _ in range(fine):
            pushed = rim + h * inverse @ (pair / RADIUS - VISCOUS * rim / RADIUS**2)
            # Friction within its limits that stops the rims, or as near as it can.
            force = np.zeros(2)
            for _sweep in range(6):
                for i in (0, 1):
                    rest = pushed + h * inverse @ force
                    force[i] -= rest[i] / (h * inverse[i, i])
                    force[i] = np.clip(force[i], -COULOMB / RADIUS, COULOMB / RADIUS)
            before, rim = rim, pushed + h * inverse @ force
            mean = 0.5 * (before + rim)
            v, omega = mean.mean(), (mean[0] - mean[1]) / TRACK
            middle = state[2] + 0.5 * h * omega
            state[:3] += h * np.array([v * np.cos(middle), v * np.sin(middle), omega])
            state[3:] = rim.mean(), (rim[0] - rim[1]) / TRACK
        rows.append(state.copy())
    return np.array(rows)


def log_of(torque, rows, noise=0.01, seed=1):
    """Columns as identify() takes them."""
    rng = np.random.default_rng(seed)
    pose = rows[:, :3] + rng.normal(0, noise, (len(rows), 3))
    return {
        "t": DT * np.arange(len(rows)),
        **dict(zip(("x", "y", "theta"), pose.T, strict=True)),
        "tau_left": torque[:, 0],
        "tau_right": torque[:, 1],
    }
