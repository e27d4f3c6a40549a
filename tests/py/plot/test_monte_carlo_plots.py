"""Figures of many runs: what they draw, read back from the axes."""

import numpy as np
import pytest
from nfopidn import plot

COSTS = np.geomspace(0.01, 1, 101)


def test_a_histogram_counts_every_run_and_those_beyond_the_limit():
    ax = plot.cost_histogram(COSTS, limit=0.1)
    assert sum(patch.get_height() for patch in ax.patches) == 101
    assert ax.get_xscale() == "log"
    (line,) = ax.lines
    assert line.get_xdata()[0] == 0.1
    beyond = (COSTS > 0.1).mean()
    assert f"{beyond:.2%} beyond" in line.get_label()
    assert plot.cost_histogram(COSTS).lines[:] == []


def test_a_tornado_has_the_strongest_on_top():
    ax = plot.tornado(["a", "b", "c"], [0.1, -0.8, 0.4], standard_error=0.01)
    assert [label.get_text() for label in ax.get_yticklabels()] == ["a", "c", "b"]
    widths = [bar.get_width() for bar in ax.containers[0]]
    assert widths == [0.1, 0.4, -0.8]


def test_failures_are_dots_of_their_own():
    parameters = {"mass": np.arange(10.0), "inertia": np.arange(10.0) ** 2, "delay": np.zeros(10)}
    failed = np.arange(10) > 6
    ax = plot.failures(parameters, failed, y="inertia")
    good, bad = ax.collections
    assert good.get_offsets().tolist() == [[k, k**2] for k in range(7)]
    assert bad.get_offsets().tolist() == [[k, k**2] for k in range(7, 10)]
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("mass", "inertia")
    assert (
        len(plot.failures(parameters, failed, x="delay", most=4).collections[0].get_offsets()) == 4
    )


def test_bands_are_the_runs_quantiles():
    t = np.array([0.0, 0.2])
    values = np.column_stack([np.arange(101.0), np.arange(101.0) * 2])
    values[100] = np.inf
    ax = plot.quantile_bands(t, values)
    assert ax.lines[0].get_ydata().tolist() == [50, 100]
    ends = [path.vertices[:, 1] for band in ax.collections for path in band.get_paths()]
    assert (ends[0].min(), ends[0].max()) == (5, 190)
    assert (ends[1].min(), ends[1].max()) == (25, 150)


def test_a_band_that_ends_in_lost_runs_goes_to_the_top_and_says_so():
    values = np.column_stack([np.arange(101.0), np.arange(101.0)])
    values[90:, 1] = np.inf
    ax = plot.quantile_bands([0.0, 0.2], values)
    ends = [path.vertices[:, 1] for band in ax.collections for path in band.get_paths()]
    assert ends[0].max() > 95
    names = [text.get_text() for text in ax.get_legend().get_texts()]
    assert "5% to 95%, open where more runs have diverged" in names
    assert "open" not in ax.collections[1].get_label()


@pytest.mark.parametrize(
    ("draw", "says"),
    [
        (lambda: plot.cost_histogram([]), "at least one"),
        (lambda: plot.cost_histogram([0.0]), "positive"),
        (lambda: plot.tornado(["a"], [1, 2]), r"correlations has the shape \(2,\)"),
        (lambda: plot.failures({"a": [1]}, [True]), "must have at least 2"),
        (lambda: plot.failures({"a": [1], "b": [1]}, [True], x="c"), "x is 'c'; known: a, b"),
        (lambda: plot.quantile_bands([0], [[1, 2]]), r"values has the shape \(1, 2\)"),
        (lambda: plot.quantile_bands([0], [[1]], shares=(0.1, 0.9)), "an odd number"),
    ],
)
def test_bad_input_is_refused(draw, says):
    with pytest.raises(ValueError, match=says):
        draw()
