"""The figures of stability: what they draw, and that they say the verdict."""

import matplotlib as mpl
import numpy as np
import pytest
from nfopidn import Controller, Scenario, plot, stability
from refusal import refused


def texts(ax):
    return [one.get_text() for one in ax.findobj(mpl.text.Text) if one.get_text()]


def data(ax, label):
    (line,) = (one for one in ax.get_lines() if one.get_label() == label)
    x, y = line.get_data()
    return np.asarray(x) + 1j * np.asarray(y)


def test_the_z_plane_has_the_verdict_and_the_pole_at_one():
    ax = plot.z_plane(Controller.published(form="incremental"), "y")
    assert "channel $y$; critically stable: poles on, zeros inside" in texts(ax)
    assert np.count_nonzero(data(ax, "poles") == 1) == 1
    assert "5 poles" in texts(ax)


def test_the_operators_zeros_are_drawn():
    ax = plot.operator_z_plane(-0.8161, 4)
    plane = stability.operator(-0.8161, 4)
    np.testing.assert_allclose(data(ax, "zeros"), plane.zeros)
    assert data(ax, "poles").size == 4
    assert "$s^{-0.8161}$, $M$ = 4; stable: poles inside, zeros outside" in texts(ax)
    with refused("order is 3", "in [-2, 2]"):
        plot.operator_z_plane(3)


def test_multipliers_within_twice_the_circle_are_where_they_are():
    found = stability.loop()
    ax = plot.multipliers(found)
    drawn = data(ax, "multipliers of a period")
    assert drawn[0] == pytest.approx(found.multipliers[0])
    # What rounding leaves no digit of is not drawn.
    assert np.all(np.abs(drawn) >= 1e-12 * found.spectral_radius)
    assert drawn.size < found.multipliers.size
    assert "stable" in texts(ax)
    assert "largest, modulus 0.09112" in texts(ax)


def test_multipliers_far_outside_are_on_a_logarithmic_radius():
    found = stability.loop(controller=Controller.published(form="incremental"))
    ax = plot.multipliers(found)
    drawn = data(ax, "multipliers of a period")
    decades = np.log10(found.spectral_radius)
    assert abs(drawn[0]) == pytest.approx(1 + 0.5 * decades / 75)
    assert np.angle(drawn[0]) == pytest.approx(np.angle(found.multipliers[0]))
    assert "$10^{75}$" in texts(ax)
    assert any("logarithmic" in text for text in texts(ax))


def test_multipliers_need_an_orbit_and_doubles():
    with refused("no orbit"):
        plot.multipliers(stability.loop(controller=Controller.published(frame="world")))
    settings = {"period": 330, "heading": "continuous"}
    huge = stability.loop(Scenario.published(**settings), Controller.published(form="incremental"))
    assert huge.spectral_radius == np.inf
    text = str(huge).split("spectral radius ")[1].split()[0]
    mantissa, exponent = text.split("e+")
    assert np.log(float(mantissa)) + int(exponent) * np.log(10) == pytest.approx(
        huge.log_radius, rel=1e-5
    )
    with refused("log_radius", "at most 709"):
        plot.multipliers(huge)


def test_a_basin_is_drawn_with_its_edge_and_the_path():
    axis = np.linspace(1, 5, 9)
    found = stability.basin(x=axis, y=axis - 3)
    ax = plot.basin(found)
    (image,) = ax.get_images()
    np.testing.assert_allclose(image.get_extent(), [0.75, 5.25, -2.25, 2.25])
    drawn = image.get_array()
    assert np.array_equal(np.ma.getmaskarray(drawn), np.isinf(found.position_error))
    kept = ~np.ma.getmaskarray(drawn)
    np.testing.assert_allclose(drawn[kept], np.maximum(found.position_error[kept], 0.01))
    assert image.origin == "lower"
    assert ax.get_xlim() == (0.75, 5.25)
    assert ax.get_xlabel() == "initial x [m]"
    assert len([one for one in ax.collections if isinstance(one, mpl.contour.ContourSet)]) == 1
    assert any(f"{found.share:.1%} end within 0.3 m" in text for text in texts(ax))


def test_a_basin_of_one_pose_is_drawn_without_an_edge():
    ax = plot.basin(stability.basin(x=3.0, y=0.0))
    assert len(ax.get_images()) == 1
    assert not [one for one in ax.collections if isinstance(one, mpl.contour.ContourSet)]
