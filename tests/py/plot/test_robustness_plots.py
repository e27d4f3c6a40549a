"""Figures of robustness: what they draw equals what was run and judged."""

import dataclasses

import matplotlib.pyplot as plt
import nfopidn
import numpy as np
import pytest
from matplotlib.colors import to_hex
from nfopidn import Controller, Rival, Scenario, plot, simulate, simulate_many
from nfopidn.families import Family
from nfopidn.plot.robustness import VERDICT_COLOURS
from numpy.testing import assert_allclose

SCENARIO = Scenario.published(period=30, rng=0)
FAMILY = SCENARIO.variations(mass=(0.8, 1.2), delay=(1, 3))
RED = VERDICT_COLOURS["red"]


@pytest.fixture(autouse=True)
def closed():
    yield
    plt.close("all")


@pytest.fixture(scope="module")
def runs():
    controllers = {"published": Controller.published(), "LQR": Rival("lqr")}
    return {name: simulate_many(FAMILY, one) for name, one in controllers.items()}


@pytest.fixture(scope="module")
def verdicts():
    recommended = Controller.recommended(robot=SCENARIO.robot, sample_time=0.2)
    scenario = Scenario.published(rng=0)
    return {
        "recommended": nfopidn.verdict(recommended, scenario),
        "LQR": nfopidn.verdict(Rival("lqr"), scenario),
        "unstable": nfopidn.verdict(Controller.published(form="incremental"), scenario),
    }


def texts(ax):
    return [text.get_text() for text in ax.texts]


def test_costs_stand_in_the_row_of_their_variation(runs):
    assert runs["LQR"].diverged.any()  # else the crosses have no test
    ax = plot.variation_costs(runs)
    assert ax.get_xscale() == "log"
    labels = [label.get_text() for label in ax.get_yticklabels()]
    assert labels == list(FAMILY.names)
    drawn = {line.get_label(): line for line in ax.lines if not line.get_label().startswith("_")}
    assert list(drawn) == list(runs)
    for name, one in runs.items():
        kept = ~one.diverged
        assert_allclose(drawn[name].get_xdata(), one.costs[kept])
        rows = ax.get_yticks()[kept]
        assert np.abs(drawn[name].get_ydata() - rows).max() < 0.3


def test_runs_that_diverge_are_a_red_cross_with_the_words(runs):
    both = {**runs, "other": runs["LQR"]}
    ax = plot.variation_costs(both)
    words = {
        (True, False): "published diverges",
        (False, True): "LQR, other diverge",
        (True, True): "published, LQR, other diverge",
    }
    pairs = list(zip(runs["published"].diverged, runs["LQR"].diverged, strict=True))
    lost = [row for row, pair in enumerate(pairs) if any(pair)]
    assert len({pairs[row] for row in lost}) > 1
    assert texts(ax) == [words[pairs[row]] for row in lost]
    crosses = [line for line in ax.lines if line.get_marker() == "x"]
    assert len(crosses) == len(lost)
    for cross, text, row in zip(crosses, ax.texts, lost, strict=True):
        assert to_hex(cross.get_color()) == to_hex(text.get_color()) == RED
        assert cross.get_ydata()[0] == text.get_position()[1] == ax.get_yticks()[row]


def test_runs_of_other_families_are_refused(runs):
    other = {**runs, "other": simulate_many(FAMILY[:2], Rival("lqr"))}
    with pytest.raises(ValueError, match="runs of 'other' are of another family"):
        plot.variation_costs(other)
    with pytest.raises(ValueError, match="runs is empty"):
        plot.variation_costs({})


def test_a_bundle_has_each_run_and_names_those_that_diverge():
    ax = plot.path_bundle(FAMILY, Rival("lqr"))
    reference, *lines = ax.lines
    assert_allclose(reference.get_xdata(), SCENARIO.trajectory.x)
    assert len(lines) == len(FAMILY)
    named = [text.get_text() for text in ax.get_legend().get_texts()]
    for line, (name, scenario) in zip(lines, FAMILY.items(), strict=True):
        run = simulate(scenario, Rival("lqr"))
        assert_allclose(line.get_xydata(), run.pose[:, :2])
        assert (f"{name}: diverges" in named) == (run.diverged_at is not None)
        assert (to_hex(line.get_color()) == RED) == (run.diverged_at is not None)
    assert named[:2] == ["reference", f"runs of {len(FAMILY)} scenarios"]
    size = max(np.ptp(SCENARIO.trajectory.x), np.ptp(SCENARIO.trajectory.y))
    assert ax.get_xlim()[1] - SCENARIO.trajectory.x.max() < 0.6 * size


def test_a_bundle_draws_each_reference_once():
    eight = Scenario(nfopidn.Trajectory.eight(period=30, dt=0.2), rng=0)
    members = [("a", SCENARIO), ("b", SCENARIO.replace(delay=1)), ("c", eight)]
    two = Family.of((name, scenario, "") for name, scenario in members)
    ax = plot.path_bundle(two, Rival("samson"))
    assert sum(line.get_color() == "#a3a3a3" for line in ax.lines) == 2


def test_bars_are_the_margins_of_the_verdicts(verdicts):
    good = verdicts["recommended"]
    assert good.colour == "green"
    gain, phase, delay = plot.margin_bars(verdicts)
    widths = [[bar.get_width() for bar in ax.patches] for ax in (gain, phase, delay)]
    margin, limits = good.margin, good.limits
    assert widths[0][0] == pytest.approx(margin.decibels)
    assert widths[1][0] == pytest.approx(np.degrees(margin.phase))
    assert widths[2][0] == limits.extra_delay
    assert [width[2] for width in widths] == [0, 0, 0]
    assert [ax.lines[0].get_xdata()[0] for ax in (gain, delay)] == [6, 1]
    assert not phase.lines
    assert [ax.get_xlabel() for ax in (gain, phase, delay)] == [
        *("gain margin [dB]", "phase margin [degrees]", "delay margin [samples]")
    ]


def test_bars_under_their_threshold_have_its_colour_and_the_word(verdicts):
    lqr = verdicts["LQR"]
    weak = dataclasses.replace(lqr, margin=dataclasses.replace(lqr.margin, gain=(0.5, 1.5)))
    gain, phase, delay = plot.margin_bars({**verdicts, "weak": weak})
    assert texts(gain)[2:] == ["red: not stable", "3.52 dB, amber: under 6 dB"]
    assert texts(phase)[1] == "not known"
    assert verdicts["recommended"].limits.extra_delay == 1  # just what is asked for
    assert texts(delay)[:2] == ["1 sample", "0 samples, red: under 1 sample"]
    colours = [to_hex(bar.get_facecolor()) for bar in gain.patches]
    assert colours == [VERDICT_COLOURS[c] for c in ("green", "green", "red", "amber")]
    names = [label.get_text() for label in gain.get_yticklabels()]
    assert names == ["recommended\ngreen", "LQR\nred", "unstable\nred", "weak\nred"]
    assert to_hex(gain.get_yticklabels()[1].get_color()) == RED


def test_bars_of_nothing_and_other_axes_are_refused(verdicts):
    with pytest.raises(ValueError, match="verdicts is empty"):
        plot.margin_bars({})
    with pytest.raises(ValueError, match="must have 3"):
        plot.margin_bars(verdicts, plt.figure().subplots(1, 2))


def test_a_controller_that_always_diverges_has_crosses_alone():
    runs = simulate_many(FAMILY, Controller.published(form="incremental"))
    assert runs.diverged.all()
    ax = plot.variation_costs({"unstable": runs})
    assert texts(ax) == ["unstable diverges"] * len(FAMILY)
    ax.figure.canvas.draw()
