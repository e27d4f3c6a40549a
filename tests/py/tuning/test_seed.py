"""Random draws: what a seed may be, and that it alone decides a run."""

import concurrent.futures

import nfopidn
import numpy as np
import pytest
from nfopidn import Scenario


def noisy(rng):
    return Scenario.published(pose_noise=(0.01, 0.02), rng=rng)


def poses(rng):
    return nfopidn.simulate(noisy(rng)).pose


def test_none_draws_a_seed_and_records_it():
    first, second = noisy(None), noisy(None)
    assert first.seed != second.seed
    assert noisy(first.seed) == first
    assert np.array_equal(nfopidn.simulate(first).pose, poses(first.seed))


@pytest.mark.parametrize("seed", [0, 1, 12345, 2**53 - 1, np.int64(7), np.uint8(7)])
def test_a_number_is_the_seed(seed):
    assert noisy(seed).seed == seed


def test_a_generator_draws_the_seed():
    seeds = {noisy(np.random.default_rng(state)).seed for state in range(5)}
    assert len(seeds) == 5
    assert noisy(np.random.default_rng(3)) == noisy(np.random.default_rng(3))
    generator = np.random.default_rng(3)
    assert noisy(generator).seed != noisy(generator).seed


def test_same_seed_same_run_other_seed_other_run():
    assert np.array_equal(poses(1), poses(1))
    assert not np.array_equal(poses(1), poses(2))


def test_runs_in_threads_are_the_runs_in_turn():
    seeds = range(16)
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        together = list(pool.map(poses, seeds))
    for seed, pose in zip(seeds, together, strict=True):
        assert np.array_equal(pose, poses(seed))


def test_replace_takes_a_seed_and_keeps_it_otherwise():
    scenario = noisy(4)
    assert scenario.replace(rng=9).seed == 9
    assert scenario.replace(delay=1).seed == 4
    assert scenario.replace(rng=None).seed != 4


def test_without_noise_the_seed_changes_nothing(published):
    assert np.array_equal(nfopidn.simulate(Scenario.published(rng=99)).pose, published.pose)


def test_noise_has_the_given_standard_deviations():
    """Read back from a controller that passes one channel through: tau_fb = measured error."""
    gains = np.zeros((3, 3))
    deviations = {}
    for channel, row in enumerate(([1, 0, 0], [0, 1, 0], [0, 0, 1])):
        gains[:] = 0
        gains[channel, 2] = 1.0  # with order 0 and memory 0 the derivative tap is e_k - e_{k-1}
        controller = nfopidn.Controller(
            gains, 0, 1, memory=0, activation="linear", frame="world", allocation=[row, row]
        )
        line = nfopidn.Trajectory.line(period=1000, dt=0.1)
        scenario = Scenario(
            line,
            initial_velocity="reference",
            pose_noise=(0.3, 0.2),
            torque_limit=1e-6,
            divergence_distance=1e3,
            rng=1,
        )
        differences = nfopidn.simulate(scenario, controller).columns["tau_fb_left"][1:]
        deviations[channel] = differences.std() / np.sqrt(2)
        assert abs(differences.mean()) < 0.01
    assert deviations == pytest.approx({0: 0.3, 1: 0.3, 2: 0.2}, rel=0.03)
