"""The published scenario's closed loop, written plainly five times: rivals for the C++ core.

Each function takes the reference table (Scenario.reference) and the taps (Controller.taps) and
returns the cost of eq. 41. They know the published structure only: positional, paper allocation,
sigmoid, robot frame, one semi-implicit Euler step a sample.
"""

import math

import numpy as np

DT = 0.2
DRIVE = DT / (11.5 * 0.076)
STEER = DT * 0.452 / (2 * 0.5873 * 0.076)
LIMIT = 3.078
START = (4.0, 0.0, 1.0472)

# For the length of a cycle: so many products, each waiting for the one before it.
PRODUCTS = 100_000
PRODUCT_CYCLES = 4  # on Intel's processors since 2015


def dependent_products(factor):
    """A chain of products, for numba to compile."""
    product = 1.0
    for _ in range(PRODUCTS):
        product *= factor
    return product


def plain_python(reference, taps):
    """Python floats and lists alone."""
    (tx, ty, tt) = taps
    count = len(tx)
    ex, ey, et = [0.0] * count, [0.0] * count, [0.0] * count
    x, y, theta = START
    v = omega = total = 0.0
    sin, cos, tanh, pi = math.sin, math.cos, math.tanh, math.pi
    for xr, yr, thr, _, _, rl, rr, _ in reference:
        c, s = cos(theta), sin(theta)
        dx, dy = xr - x, yr - y
        e = (thr - theta + pi) % (2 * pi) - pi
        ex.insert(0, c * dx + s * dy)
        ey.insert(0, c * dy - s * dx)
        et.insert(0, e)
        del ex[count], ey[count], et[count]
        nx = ny = nt = 0.0
        for j in range(count):
            nx += tx[j] * ex[j]
            ny += ty[j] * ey[j]
            nt += tt[j] * et[j]
        ox, oy, ot = tanh(nx / 2), tanh(ny / 2), tanh(nt / 2)
        left = min(max(rl + oy + ot, -LIMIT), LIMIT)
        right = min(max(rr + ox + oy, -LIMIT), LIMIT)
        total += dx * dx + dy * dy + e * e + (rl - left) ** 2 + (rr - right) ** 2
        v += DRIVE * (left + right)
        omega += STEER * (left - right)
        x += DT * v * c
        y += DT * v * s
        theta += DT * omega
    return total / len(reference)


def fused_numpy(reference, taps):
    """One array operation for the three channels' filters and one for the neurons."""
    count = taps.shape[1]
    errors = np.zeros((3, count))
    world = np.empty(2)
    matrix = np.empty((2, 2))
    allocation = np.array([[0.0, 1.0, 1.0], [1.0, 1.0, 0.0]])
    gain = np.array([[DRIVE, DRIVE], [STEER, -STEER]])
    pose = np.array(START)
    speed = np.zeros(2)
    total = 0.0
    for row in reference:
        c, s = np.cos(pose[2]), np.sin(pose[2])
        matrix[0, 0], matrix[0, 1], matrix[1, 0], matrix[1, 1] = c, s, -s, c
        np.subtract(row[:2], pose[:2], out=world)
        e = (row[2] - pose[2] + np.pi) % (2 * np.pi) - np.pi
        errors[:, 1:] = errors[:, :-1]
        errors[:2, 0] = matrix @ world
        errors[2, 0] = e
        neuron = np.tanh(0.5 * np.einsum("ij,ij->i", taps, errors))
        torque = np.clip(row[5:7] + allocation @ neuron, -LIMIT, LIMIT)
        deviation = row[5:7] - torque
        total += world @ world + e * e + deviation @ deviation
        speed += gain @ torque
        pose[0] += DT * speed[0] * c
        pose[1] += DT * speed[0] * s
        pose[2] += DT * speed[1]
    return total / len(reference)


def compiled_loop(reference, taps):
    """The same with scalars, for numba to compile."""
    count = taps.shape[1]
    errors = np.zeros((3, count))
    x, y, theta = START
    v = omega = total = 0.0
    for k in range(reference.shape[0]):
        c, s = math.cos(theta), math.sin(theta)
        dx, dy = reference[k, 0] - x, reference[k, 1] - y
        e = reference[k, 2] - theta
        e -= 2 * math.pi * math.floor(e / (2 * math.pi) + 0.5)
        for j in range(count - 1, 0, -1):
            errors[0, j] = errors[0, j - 1]
            errors[1, j] = errors[1, j - 1]
            errors[2, j] = errors[2, j - 1]
        errors[0, 0] = c * dx + s * dy
        errors[1, 0] = c * dy - s * dx
        errors[2, 0] = e
        nx = ny = nt = 0.0
        for j in range(count):
            nx += taps[0, j] * errors[0, j]
            ny += taps[1, j] * errors[1, j]
            nt += taps[2, j] * errors[2, j]
        ox, oy, ot = math.tanh(nx / 2), math.tanh(ny / 2), math.tanh(nt / 2)
        rl, rr = reference[k, 5], reference[k, 6]
        left = min(max(rl + oy + ot, -LIMIT), LIMIT)
        right = min(max(rr + ox + oy, -LIMIT), LIMIT)
        total += dx * dx + dy * dy + e * e + (rl - left) ** 2 + (rr - right) ** 2
        v += DRIVE * (left + right)
        omega += STEER * (left - right)
        x += DT * v * c
        y += DT * v * s
        theta += DT * omega
    return total / reference.shape[0]


def python_control(reference, taps):
    """A discrete-time nonlinear system of python-control, run by input_output_response."""
    import control

    count = taps.shape[1]
    gain = np.array([[DRIVE, DRIVE], [STEER, -STEER]])
    allocation = np.array([[0.0, 1.0, 1.0], [1.0, 1.0, 0.0]])

    def parts(state, row):
        c, s = np.cos(state[2]), np.sin(state[2])
        dx, dy = row[0] - state[0], row[1] - state[1]
        e = (row[2] - state[2] + np.pi) % (2 * np.pi) - np.pi
        errors = np.empty((3, count))
        errors[:, 1:] = state[5:].reshape(3, count - 1)
        errors[:, 0] = c * dx + s * dy, c * dy - s * dx, e
        neuron = np.tanh(0.5 * (taps * errors).sum(axis=1))
        torque = np.clip(row[5:7] + allocation @ neuron, -LIMIT, LIMIT)
        deviation = row[5:7] - torque
        return c, s, errors, torque, dx * dx + dy * dy + e * e + deviation @ deviation

    def update(_t, state, row, _params):
        c, s, errors, torque, _ = parts(state, row)
        v, omega = state[3:5] + gain @ torque
        pose = state[0] + DT * v * c, state[1] + DT * v * s, state[2] + DT * omega
        return np.concatenate([pose, (v, omega), errors[:, :-1].ravel()])

    def output(_t, state, row, _params):
        return [parts(state, row)[4]]

    size = 5 + 3 * (count - 1)
    system = control.nlsys(update, output, inputs=8, outputs=1, states=size, dt=DT)
    times = DT * np.arange(len(reference))
    start = np.concatenate([START, np.zeros(size - 3)])
    response = control.input_output_response(system, times, reference.T, start)
    return float(np.mean(response.outputs))


def jax_loop():
    """A function of the same arguments, compiled by JAX; None without JAX."""
    try:
        import jax
    except ImportError:
        return None
    jax.config.update("jax_enable_x64", True)
    jnp = jax.numpy
    gain = jnp.array([[DRIVE, DRIVE], [STEER, -STEER]])
    allocation = jnp.array([[0.0, 1.0, 1.0], [1.0, 1.0, 0.0]])

    @jax.jit
    def run(reference, taps):
        def step(carry, row):
            pose, speed, past = carry
            c, s = jnp.cos(pose[2]), jnp.sin(pose[2])
            dx, dy = row[0] - pose[0], row[1] - pose[1]
            e = (row[2] - pose[2] + jnp.pi) % (2 * jnp.pi) - jnp.pi
            newest = jnp.stack([c * dx + s * dy, c * dy - s * dx, e])
            errors = jnp.concatenate([newest[:, None], past[:, :-1]], axis=1)
            neuron = jnp.tanh(0.5 * (taps * errors).sum(axis=1))
            torque = jnp.clip(row[5:7] + allocation @ neuron, -LIMIT, LIMIT)
            deviation = row[5:7] - torque
            term = dx * dx + dy * dy + e * e + deviation @ deviation
            speed = speed + gain @ torque
            pose = pose + DT * jnp.stack([speed[0] * c, speed[0] * s, speed[1]])
            return (pose, speed, errors), term

        begin = (jnp.array(START), jnp.zeros(2), jnp.zeros(taps.shape))
        return jnp.mean(jax.lax.scan(step, begin, reference)[1])

    return lambda reference, taps: float(run(reference, taps))
