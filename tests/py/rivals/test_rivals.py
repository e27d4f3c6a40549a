"""The rivals: their laws against outside implementations, and their place in the package."""

import copy
import json
import pickle

import nfopidn
import nominal
import numpy as np
import pytest
from nfopidn import Controller, Rival, Robot, Scenario, Trajectory
from wpimath.controller import LTVUnicycleController, RamseteController
from wpimath.geometry import Pose2d, Rotation2d


def random_scenario(seed, **changes):
    """A wandering path, a start beside it and noisy poses: every sample is a random input."""
    rng = np.random.default_rng(seed)
    steps = rng.uniform(0.01, 0.08, 60)
    turns = np.cumsum(rng.normal(0, 0.15, 60))
    x, y = np.cumsum(steps * np.cos(turns)), np.cumsum(steps * np.sin(turns))
    trajectory = Trajectory.from_samples(x, y, dt=0.2)
    start = (x[0] + rng.normal(0, 0.2), y[0] + rng.normal(0, 0.2), rng.uniform(-3, 3))
    settings = {"torque_limit": 1e5, "initial_pose": start, "divergence_distance": 1e6}
    return Scenario(trajectory, **(settings | changes))


def commands(run, k_v, k_omega):
    """The velocities that a kinematic law has asked for, from the torques of its loop."""
    c, robot = run.columns, run.scenario.robot
    force = (c["tau_fb_left"] + c["tau_fb_right"]) / (robot.mass * robot.wheel_radius)
    moment = (c["tau_fb_left"] - c["tau_fb_right"]) * robot.track_width
    moment /= 2 * robot.inertia * robot.wheel_radius
    return c["v"] + force / k_v, c["omega"] + moment / k_omega


def outside(controller, run):
    """The same from a controller of WPILib."""
    c, t = run.columns, run.scenario.trajectory
    found = []
    for k in range(len(run)):
        pose = Pose2d(c["x"][k], c["y"][k], Rotation2d(c["theta"][k]))
        wanted = Pose2d(c["x_ref"][k], c["y_ref"][k], Rotation2d(c["theta_ref"][k]))
        speeds = controller.calculate(pose, wanted, t.v[k], t.omega[k])
        found.append((speeds.vx, speeds.omega))
    return np.array(found).T


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_ramsete_asks_for_what_wpilib_asks_for(seed):
    b, zeta = np.random.default_rng(seed).uniform([0.5, 0.1], [5, 0.9])
    run = nfopidn.simulate(
        random_scenario(seed), Rival("ramsete", b=b, zeta=zeta, k_v=0.5, k_omega=0.5)
    )
    expected = outside(RamseteController(b, zeta), run)
    np.testing.assert_allclose(commands(run, 0.5, 0.5), expected, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_lqr_asks_for_what_wpilib_asks_for(seed):
    x, y, theta, omega = np.random.default_rng(seed).uniform(
        [0.05, 0.05, 0.1, 0.5], [0.5, 0.5, 2, 3]
    )
    rival = Rival(
        "lqr",
        tolerance_x=x,
        tolerance_y=y,
        tolerance_theta=theta,
        tolerance_omega=omega,
        k_v=0.5,
        k_omega=0.5,
    )
    run = nfopidn.simulate(random_scenario(seed), rival)
    expected = outside(LTVUnicycleController((x, y, theta), (1, omega), 0.2, 1.0), run)
    assert np.ptp(run.scenario.trajectory.v) > 0.2
    np.testing.assert_allclose(commands(run, 0.5, 0.5), expected, rtol=1e-6, atol=1e-7)


def test_takagi_sugeno_with_one_law_in_all_rules_is_samsons():
    rules = [f"{speed}_{angle}" for speed in ("slow", "fast") for angle in ("aligned", "askew")]
    gains = {"k_x": 1.5, "k_y": 20.0, "k_theta": 3.0}
    loops = {"k_v": 1.0, "k_omega": 1.2}
    alike = {f"{name}_{rule}": value for name, value in gains.items() for rule in rules}
    fuzzy = nfopidn.simulate(None, Rival("takagi-sugeno", **alike, **loops))
    plain = nfopidn.simulate(None, Rival("samson", **gains, **loops))
    np.testing.assert_allclose(fuzzy.pose, plain.pose, rtol=0, atol=1e-9)


@pytest.mark.parametrize("law", Rival.laws())
def test_a_rival_at_rest_on_its_reference_stays_there(law):
    """Exact start on a line, whose samples the sampled robot can follow exactly."""
    scenario = Scenario(Trajectory.line(period=20, dt=0.2), initial_velocity="reference")
    run = nfopidn.simulate(scenario, Rival(law))
    assert run.cost < 1e-20
    assert np.abs(run.columns["tau_fb_left"]).max() < 1e-10


@pytest.mark.parametrize("law", Rival.laws())
def test_the_defaults_are_what_the_search_finds(law):
    default = nfopidn.simulate(None, Rival(law)).cost
    found = nominal.tune(structure=law, rng=1, maxfev=300, start=Rival(law))
    assert found.fun > default * (1 - 2e-3)
    assert found.controller.law == law


@pytest.mark.parametrize("law", Rival.laws())
def test_without_noise_speeds_from_poses_do_as_well(law):
    """On average: they are of the last interval, along its mean heading."""
    measured = nfopidn.simulate(None, Rival(law))
    differenced = nfopidn.simulate(None, Rival(law, speeds="differenced"))
    assert differenced.cost == pytest.approx(measured.cost, rel=0.25)
    assert differenced.cost != measured.cost


def test_differenced_speeds_are_ways_along_the_mean_heading():
    scenario = random_scenario(7, integrator="exact")
    rival = Rival("samson", speeds="differenced", k_x=0, k_y=0, k_theta=0, k_v=0.4, k_omega=0.5)
    run = nfopidn.simulate(scenario, rival)
    c = run.columns
    x, y, theta = (np.diff(c[name]) / 0.2 for name in ("x", "y", "theta"))
    mean = c["theta"][:-1] + 0.1 * theta
    v = np.concatenate([[0], x * np.cos(mean) + y * np.sin(mean)])
    omega = np.concatenate([[0], theta])
    # commands() adds the true speeds, which the law has not seen.
    asked_v, asked_omega = commands(run, 0.4, 0.5)
    reference = scenario.trajectory
    turned = np.cos(c["theta_ref"] - c["theta"])
    np.testing.assert_allclose(asked_v - c["v"] + v, reference.v * turned, atol=1e-9)
    np.testing.assert_allclose(asked_omega - c["omega"] + omega, reference.omega, atol=1e-9)


def test_the_model_behind_the_torques_is_the_rivals_own():
    heavy = Robot(mass=23)
    light = nfopidn.simulate(None, Rival("samson"))
    run = nfopidn.simulate(None, Rival("samson", robot=heavy))
    sums = [r.columns["tau_fb_left"][0] + r.columns["tau_fb_right"][0] for r in (light, run)]
    assert sums[1] == pytest.approx(2 * sums[0])
    found = nominal.tune(Scenario.published(robot=heavy), structure="samson", maxfev=20, rng=0)
    assert found.controller.robot == heavy


@pytest.mark.parametrize("law", Rival.laws())
def test_a_rival_survives_every_way_of_copying_it(law, tmp_path):
    rng = np.random.default_rng(3)
    drawn = {name: rng.uniform(low, high) for name, _, low, high, _ in Rival.describe(law)}
    rival = Rival(law, speeds="differenced", robot=Robot.eddie_datasheet(), **drawn)
    rival.save(tmp_path / "rival.json")
    for other in (
        Rival.load(tmp_path / "rival.json"),
        Rival.from_json(rival.to_json()),
        pickle.loads(pickle.dumps(rival)),
        copy.copy(rival),
        copy.deepcopy(rival),
        rival.replace(),
    ):
        assert other == rival
        assert hash(other) == hash(rival)
        assert other.parameters == drawn
    assert rival != rival.replace(speeds="measured")
    run = nfopidn.simulate(None, rival)
    again = pickle.loads(pickle.dumps(run))
    assert again.controller == rival
    assert again.metrics == run.metrics


@pytest.mark.parametrize("law", Rival.laws())
def test_every_parameter_changes_the_run(law):
    cost = nfopidn.simulate(None, Rival(law)).cost
    for name, _, low, high, _ in Rival.describe(law):
        own = Rival(law).parameters[name]
        # Nine tenths of its own, or a twentieth of the way up from zero.
        other = own * 0.9 if own > low else low + 0.05 * (high - low)
        assert nfopidn.simulate(None, Rival(law, **{name: other})).cost != cost, name


def test_tuning_a_rival_is_as_tuning_a_controller(tmp_path):
    found = nominal.tune(structure="samson", rng=4, maxfev=500, frozen={"k_v": 1.0})
    assert found.controller.parameters["k_v"] == 1.0
    assert "k_v" not in found.parameters
    # The lanes of the search round otherwise.
    cost = nfopidn.simulate(None, found.controller).cost
    assert cost == pytest.approx(found.fun, rel=1e-12)
    twice = nominal.tune(structure="samson", rng=4, maxfev=500, frozen={"k_v": 1.0}, workers=2)
    np.testing.assert_array_equal(twice.x, found.x)
    found.to_json(tmp_path / "result.json")
    assert nfopidn.TuneResult.from_json(tmp_path / "result.json").controller == found.controller
    tied = nominal.tune(structure="samson", rng=4, maxfev=100, tied={"k_omega": "k_v"})
    assert tied.controller.parameters["k_omega"] == tied.controller.parameters["k_v"]
    start = nominal.tune(structure="samson", rng=4, maxfev=1, start=found.controller)
    assert start.fun <= found.fun * (1 + 1e-12)


def test_several_scenarios_and_the_worst_of_them():
    scenarios = [Scenario.published(), Scenario.published(period=100)]
    both = nominal.tune(scenarios, structure="samson", rng=1, maxfev=200)
    costs = [nfopidn.simulate(one, both.controller).cost for one in scenarios]
    assert both.fun == pytest.approx(np.mean(costs), rel=1e-12)
    worst = nominal.tune(scenarios, structure="samson", rng=1, maxfev=200, worst_share=0)
    costs = [nfopidn.simulate(one, worst.controller).cost for one in scenarios]
    assert worst.fun == pytest.approx(max(costs), rel=1e-12)


def test_differenced_speeds_can_be_tuned_with():
    found = nominal.tune(structure={"law": "samson", "speeds": "differenced"}, rng=1, maxfev=100)
    assert found.controller.speeds == "differenced"


REFUSED = [
    (lambda: Rival("pure-pursuit"), 'law is "pure-pursuit"; must be one of samson'),
    (lambda: Rival("samson", k_x=-1), r"k_x is -1; must be in \[0, 10\] 1/s"),
    (lambda: Rival("samson", k_x=float("nan")), "k_x is nan"),
    (lambda: Rival("samson", speeds="guessed"), "speeds"),
    (lambda: Rival.from_json("[1]"), "must be an object"),
    (lambda: Rival.from_json('{"format": "nfopidn-rival", "version": 1}'), "law is null"),
    (lambda: Rival.from_json(Controller.published().to_json()), "format"),
    (lambda: nominal.tune(structure="samson", bounds={"k_x": (-1, 3)}), "k_x is -1"),
    (lambda: nominal.tune(structure="samson", start=Controller.published()), "must be a Rival"),
    (lambda: nominal.tune(structure="samson", start=Rival("lqr")), "of the law 'samson'"),
    (lambda: nominal.tune(structure="paper", start=Rival("lqr")), "must be a Controller"),
    (lambda: nfopidn.Objective(structure="samson"), "must be one of a Controller"),
]


@pytest.mark.parametrize(("call", "text"), REFUSED)
def test_bad_input_is_named(call, text):
    with pytest.raises(ValueError, match=text):
        call()


def test_wrong_types_are_named():
    with pytest.raises(TypeError, match="no argument 'k_z'"):
        Rival("samson", k_z=1)
    with pytest.raises(TypeError, match="robot must be a Robot"):
        Rival("samson", robot=3)
    with pytest.raises(TypeError, match="must be a Controller or a Rival"):
        nfopidn.simulate(None, "samson")


@pytest.mark.parametrize(
    "call",
    [
        lambda rival: nfopidn.stability.loop(None, rival),
        lambda rival: nfopidn.stability.margins(rival, speed=0.3),
        lambda rival: nfopidn.stability.basin(controller=rival),
        nfopidn.stability.controller,
        lambda rival: nfopidn.fractional.truncation_report(rival, 0.2),
        lambda rival: nfopidn.fractional.retune(rival, dt=0.2, new_dt=0.1),
        lambda rival: nfopidn.export_c(rival, "nowhere"),
        lambda rival: nfopidn.export_cpp(rival, "nowhere"),
        nfopidn.plot.weights,
        nfopidn.plot.z_plane,
    ],
)
def test_what_is_for_nfopidn_alone_says_so(call):
    with pytest.raises(ValueError, match=r"controller is the rival 'lqr'; must be a Controller"):
        call(Rival("lqr"))


def test_a_rivals_run_has_an_overview():
    figure = nfopidn.plot.overview(nfopidn.simulate(None, Rival("lqr")))
    assert figure.get_suptitle().startswith("lqr on ranunculoid")
    texts = [text.get_text() for ax in figure.axes for text in ax.texts]
    assert {"tolerance x", "0.7431", "speeds", "measured"} <= set(texts)


def test_a_later_version_is_refused():
    document = json.loads(Rival("lqr").to_json())
    document["version"] = 99
    with pytest.raises(ValueError, match="version"):
        Rival.from_json(json.dumps(document))


def test_integral_action_has_gains_of_its_own():
    plain = Rival("lqr", tolerance_x=0.5)
    rival = plain.replace(integral=True, k_i_v=0.2)
    assert rival.integral
    assert not plain.integral
    assert rival.parameters == plain.parameters | {"k_i_v": 0.2, "k_i_omega": 0.0}
    assert Rival.from_json(rival.to_json()) == rival
    assert rival.replace(integral=False) == plain
    assert "integral" not in json.loads(plain.to_json())  # documents without are as before
    assert [row[0] for row in Rival.describe("lqr", True)][-2:] == ["k_i_v", "k_i_omega"]
    with pytest.raises(TypeError, match="k_i_v"):
        plain.replace(k_i_v=0.2)  # it has no integral action
    with pytest.raises(ValueError, match="k_i_v"):
        rival.replace(k_i_v=-1)


def test_integral_action_is_tuned():
    structure = {"law": "samson", "integral": True}
    result = nominal.tune(structure=structure, rng=1, maxfev=300)
    assert result.parameters[-2:] == ["k_i_v", "k_i_omega"]
    assert result.controller.integral
    assert result.fun == pytest.approx(nfopidn.simulate(None, result.controller).cost, rel=1e-9)
