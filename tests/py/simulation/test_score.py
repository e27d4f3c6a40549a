"""score(): eq. 41 and the metrics of runs that were recorded elsewhere."""

import warnings

import numpy as np
import pytest
from nfopidn import Controller, Rival, Scenario, score, simulate

SCENARIO = Scenario.published(heading="continuous", period=50.0, rng=0)


@pytest.fixture(scope="module")
def run():
    return simulate(SCENARIO, Controller.recommended())


def plain(run):
    return {name: np.array(column) for name, column in run.columns.items()}


def by_hand(log, scenario):
    """Eq. 41 in NumPy, from the columns and the reference."""
    r = scenario.reference
    angle = (r[:, 2] - log["theta"] + np.pi) % (2 * np.pi) - np.pi
    terms = [r[:, 0] - log["x"], r[:, 1] - log["y"], angle]
    terms += [r[:, 5] - log["tau_left"], r[:, 6] - log["tau_right"]]
    return float(np.mean(sum(np.square(term) for term in terms)))


@pytest.mark.parametrize(
    "scenario",
    [
        SCENARIO,
        SCENARIO.replace(cost_weights=(2.0, 0.5, 3.0)),
        SCENARIO.replace(feedforward=False),
        SCENARIO.replace(delay=2, pose_noise=(0.01, 0.01)),
    ],
)
def test_a_simulated_run_scores_as_it_did(scenario):
    for driver in (Controller.published(), Rival("samson"), Controller.recommended()):
        simulated = simulate(scenario, driver)
        lost = simulated.diverged_at is not None
        scored = score(simulated.columns, scenario, controller=driver, lost=lost)
        assert scored.cost == simulated.cost
        assert scored.metrics == simulated.metrics
        assert scored.controller == simulated.controller
        for name, column in simulated.columns.items():
            np.testing.assert_array_equal(scored.columns[name], column)


def test_the_cost_is_eq_41(run):
    log = plain(run)
    rng = np.random.default_rng(1)
    for name in ("x", "y", "theta", "tau_left", "tau_right"):
        log[name] = log[name] + rng.normal(0, 0.1, len(log["t"]))
    assert score(log, SCENARIO).cost == pytest.approx(by_hand(log, SCENARIO), rel=1e-12)


def test_whole_turns_do_not_count(run):
    log = plain(run)
    log["theta"] = np.mod(log["theta"] + 7.0, 2 * np.pi) - 7.0
    assert score(log, SCENARIO).cost == pytest.approx(run.cost, rel=1e-12)


def test_a_run_that_was_lost_costs_what_a_diverged_one_does():
    wild = simulate(SCENARIO.replace(delay=6), Controller.published())
    assert wild.diverged_at is not None
    scenario = wild.scenario
    scored = score(wild.columns, scenario, lost=True)
    assert scored.cost == wild.cost
    assert scored.diverged_at == wild.diverged_at
    with pytest.raises(ValueError, match=r"log ends at t = .* lost=True"):
        score(wild.columns, scenario)


def test_beyond_the_divergence_distance_the_rest_does_not_count(run):
    log = plain(run)
    log["x"][100:] += 50.0
    scored = score(log, SCENARIO)
    assert scored.diverged_at == pytest.approx(20.0)
    assert len(scored) == 100
    left = len(log["t"]) - 100
    before = sum(
        np.sum((SCENARIO.reference[:100, i] - log[name][:100]) ** 2)
        for i, name in ((0, "x"), (1, "y"), (5, "tau_left"), (6, "tau_right"))
    )
    angle = scored.columns["e_theta"]
    expected = (before + np.sum(angle**2) + left * 100.0) / len(log["t"])
    assert scored.cost == pytest.approx(expected, rel=1e-12)


def test_rows_of_another_clock_are_resampled_and_that_is_said(run):
    fine = np.arange(0, run.t[-1] + 0.05, 0.05)
    held = np.searchsorted(run.t, fine + 1e-9, side="right") - 1
    log = {"t": fine}
    for name in ("x", "y", "theta", "v", "omega"):
        log[name] = np.interp(fine, run.t, run.columns[name])
    for name in ("tau_left", "tau_right"):
        log[name] = run.columns[name][held]
    late = {name: column[1:] for name, column in log.items()}
    late["t"] = late["t"] - 0.05
    with pytest.warns(UserWarning, match=r"are not at the scenario's samples .* resampled to 251"):
        scored = score(log, SCENARIO)
    assert scored.cost == pytest.approx(run.cost, rel=1e-9)
    assert scored.metrics["energy"] == pytest.approx(run.metrics["energy"], rel=1e-9)
    shifted = log | {"t": fine - 0.02}
    log_end = np.append(shifted["t"], shifted["t"][-1] + 0.05)
    shifted = {name: np.append(column, column[-1]) for name, column in shifted.items()}
    shifted["t"] = log_end
    with pytest.warns(UserWarning, match=r"up to 0.02 s beside"):
        moved = score(shifted, SCENARIO)
    assert 0 < abs(moved.pose[50, 0] - run.pose[50, 0]) < 0.02


def test_speeds_that_are_missing_are_derived_and_that_is_said(run):
    log = {name: column for name, column in plain(run).items() if name not in ("v", "omega")}
    with pytest.warns(UserWarning, match="no v and omega"):
        scored = score(log, SCENARIO)
    assert scored.cost == run.cost
    assert scored.metrics["energy"] == pytest.approx(run.metrics["energy"], rel=0.1)


def test_a_real_robot_s_left_is_the_paper_s_right(run):
    log = plain(run)
    for name in ("tau_", "tau_fb_"):
        log[name + "left"], log[name + "right"] = log[name + "right"], log[name + "left"]
    assert score(log, SCENARIO, rep103=True).metrics == run.metrics
    # The path turns at a constant rate: its torques, and so the cost, do not tell the wheels apart.
    energy = score(log, SCENARIO).metrics["energy"]
    assert abs(energy / run.metrics["energy"] - 1) > 1e-3


def test_feedback_is_what_is_not_fed_forward(run):
    log = {n: c for n, c in plain(run).items() if not n.startswith("tau_fb")}
    scored = score(log, SCENARIO)
    np.testing.assert_allclose(
        scored.columns["tau_fb_left"], run.columns["tau_fb_left"], atol=1e-12
    )


def broken(**changes):
    def make(log):
        return log | {name: change(log[name]) for name, change in changes.items()}

    return make


def poked(column, place, value):
    column = np.array(column)
    column[place] = value
    return column


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda log: {n: c for n, c in log.items() if n != "tau_left"}, "no column tau_left"),
        (lambda log: {n: c for n, c in log.items() if n != "omega"}, "has v and not the other"),
        (lambda log: [1, 2], "must be a mapping"),
        (broken(x=lambda c: c[:-1]), r"log\['x'\] has the shape"),
        (broken(y=lambda c: poked(c, 7, np.nan)), r"log\['y'\]\[7\] is nan"),
        (broken(t=lambda c: poked(c, 7, c[6])), "does not rise.* in row 7"),
        (broken(t=lambda c: c + 5.0), "log starts at t = 5 s"),
        (broken(t=lambda c: 0.5 * c), "log ends at t = 25 s"),
        (broken(theta=lambda c: ["a"] * len(c)), "real numbers"),
        (lambda log: {n: c[:1] for n, c in log.items()}, "has 1 rows"),
        (
            lambda log: {n: np.delete(c, slice(50, 60)) for n, c in log.items()},
            "nothing between 9.8 and 12 s: a gap of 11",
        ),
    ],
)
def test_bad_logs_are_refused(run, change, message):
    with warnings.catch_warnings(), pytest.raises(ValueError, match=message):
        score(change(plain(run)), SCENARIO)


def test_other_things_are_refused(run):
    with pytest.raises(ValueError, match="scenario is None"):
        score(run.columns, None)
    with pytest.raises(ValueError, match="controller is 3"):
        score(run.columns, SCENARIO, controller=3)
