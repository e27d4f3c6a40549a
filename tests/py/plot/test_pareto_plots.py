"""Figures of Pareto fronts show the points that the result has."""

from itertools import combinations

import matplotlib.pyplot as plt
import nfopidn
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from nfopidn import Scenario, plot

NAMES = ("position_rms", "heading_rms", "torque_variation")


def front_of(names):
    """A small front."""
    return nfopidn.tune(
        Scenario.published(period=100.0, rng=0),
        objectives=names,
        structure="decoupled",
        robustness=None,
        rng=1,
        maxfev=300,
        population=30,
    )


@pytest.fixture(scope="module", autouse=True)
def _closed():
    yield
    plt.close("all")


@pytest.fixture(scope="module")
def two():
    """Of two objectives."""
    return front_of(NAMES[::2])


@pytest.fixture(scope="module")
def three():
    """Of three."""
    return front_of(NAMES)


def places(ax):
    """The points of each scatter by its label."""
    return {one.get_label(): np.asarray(one.get_offsets()) for one in ax.collections}


def test_a_front_of_two_shows_its_points_its_knee_and_a_choice(two):
    ax = plot.pareto_front(two, chosen=1)
    assert isinstance(ax, Axes)
    shown = places(ax)
    np.testing.assert_array_equal(shown[f"front, {len(two)} points"], two.objectives)
    np.testing.assert_array_equal(shown["knee"], two.objectives[[two.choose()]])
    np.testing.assert_array_equal(shown["point 1"], two.objectives[[1]])
    assert ax.get_xlabel() == "position rms [m]"
    assert ax.get_ylabel() == "torque variation [N m]"
    (steps,) = ax.lines
    assert steps.get_drawstyle() == "steps-post"  # what no point of the front dominates lies left
    assert two.plot().get_xlabel() == ax.get_xlabel()


def test_a_front_of_three_has_a_panel_for_each_pair(three):
    panels = plot.pareto_front(three)
    assert len(panels) == 3
    for panel, (a, b) in zip(panels, combinations(range(3), 2), strict=True):
        shown = places(panel)[f"front, {len(three)} points"]
        np.testing.assert_array_equal(shown, three.objectives[:, [a, b]])
        assert not panel.lines
        assert panel.get_xlabel().startswith(NAMES[a].replace("_", " "))
    own = plt.figure().subplots(1, 3)
    assert list(plot.pareto_front(three, own)) == list(own)


def test_it_draws_into_the_axes_it_is_given(two):
    ax = plt.figure().add_subplot()
    assert plot.pareto_front(two, ax) is ax
    assert plot.hypervolume(two, ax) is ax


def test_the_hypervolume_is_that_of_the_history(two):
    (line,) = plot.hypervolume(two).lines
    np.testing.assert_array_equal(line.get_xdata(), two.history["nfev"])
    np.testing.assert_array_equal(line.get_ydata(), two.history["hypervolume"])


@pytest.mark.parametrize("ground", ["default", "dark_background"])
def test_its_colours_stand_out_from_the_ground(two, ground):
    def luminance(colour):
        return float(np.dot([0.2126, 0.7152, 0.0722], np.array(to_rgb(colour)) ** 2.2))

    with plt.style.context(ground):
        ax = plot.pareto_front(two, chosen=0)
        behind = luminance(ax.get_facecolor()[:3])
        for one in ax.collections:
            own = luminance(one.get_facecolor()[0][:3])
            low, high = sorted((own, behind))
            assert (high + 0.05) / (low + 0.05) > 2.4


def test_what_cannot_be_drawn_is_refused(two, three):
    with pytest.raises(ValueError, match="chosen is 999"):
        plot.pareto_front(two, chosen=999)
    with pytest.raises(ValueError, match="ax has 1 Axes; must have 3"):
        plot.pareto_front(three, plt.figure().add_subplot())
    empty = nfopidn.ParetoResult(two, controllers=[])
    with pytest.raises(ValueError, match="the front is empty"):
        plot.pareto_front(empty)
