"""Families: variations of a scenario, benchmarks, and runs over all of a family."""

import json

import nfopidn
import numpy as np
import pytest
from nfopidn import Controller, Family, Rival, Robot, Scenario, Trajectory, families, simulate

BASE = Scenario(
    Trajectory.circle(period=10, dt=0.1),
    Robot(5.0, 0.08, 0.3, 0.033),
    torque_limit=0.6,
    coulomb_friction=0.01,
    pose_noise=(0.003, 0.004),
    disturbance=(0.1, 0.02),
    integrator="exact",
    rng=3,
)
GOLDEN = {"sub4": "substeps-4", "m+20": "mass-13.8", "m-20": "mass-9.2"} | {
    "I.294": "inertia-0.294",
    "L.39": "track-0.39",
    "nom": "nominal",
    "delay": "delay",
}
GOLDEN_PATHS = {
    **{"R:P": "published", "R:C": "continuous", "R:F": "continuous-fast"},
    **{"G:ran": "ranunculoid", "G:ranc": "ranunculoid-continuous", "G:five": "five-cusps"},
    **{"G:lemn": "lemniscate", "G:square": "rounded-square"},
}


def golden_name(name):
    path, condition = name.split("/")
    pace = "-fast" if path.endswith("-fast") else ""
    path = path.removesuffix("-fast")
    return f"{GOLDEN_PATHS.get(path, path[2:])}{pace}/{GOLDEN[condition]}"


def golden_controller(p):
    return Controller(
        [[p["kp_x"], 0, 0], [p["kp_y"], 0, 0], [p["kp_theta"], 0, 0]],
        *(0.5, 0.5),
        allocation="decoupled",
        lateral="scheduled",
        net="speed-errors",
        speed_gain_x=p["kd_x"],
        speed_gain_theta=p["kd_theta"],
        speed_order_x=p["alpha_x"],
        speed_order_theta=p["alpha_theta"],
        integral_retention=p["leak"],
        **{
            name: p[name]
            for name in p
            if name.startswith(("amplitude", "pole", "integral", "lateral"))
        },
    )


def test_benchmarks_have_the_costs_of_an_independent_implementation(repository):
    golden = json.loads((repository / "tests/golden/tracking_costs.json").read_text())
    family = families.benchmark("J")
    for kind, costs in golden["costs"].items():
        own = Family.of((name, family[golden_name(name)], "") for name in costs)
        runs = nfopidn.simulate_many(own, golden_controller(golden["parameters"][kind]))
        assert np.allclose(runs.costs, list(costs.values()), rtol=1e-8, atol=0)


def test_benchmarks_have_the_sizes_and_conditions_of_the_law():
    sizes = {name: len(families.benchmark(name)) for name in ("R", "G", "J", "J++")}
    assert sizes == {"R": 36, "G": 54, "J": 90, "J++": 132}
    full = families.benchmark("J++")
    assert full[:90] == families.benchmark("J")
    assert {one.integrator for one in full} == {"semi-implicit-euler"}
    assert {one.model for one in full} == {None}
    assert full["published/coulomb-0.2"].coulomb_friction == 0.2
    assert full["continuous/disturbance"].disturbance == (2.0, 0.2)
    assert full["continuous-fast/noise"].pose_noise == (0.005, 0.005)
    assert full["published/substeps-20"].substeps == 20
    corner = full["eight-fast/delay,substeps-4,inertia-0.294,track-0.39"]
    assert (corner.delay, corner.substeps) == (1, 4)
    assert (corner.robot.inertia, corner.robot.track_width) == (0.294, 0.39)
    assert corner.trajectory.period == 20
    with pytest.raises(ValueError, match=r"benchmark is 'K'; must be one of R, G, J, J\+\+"):
        families.benchmark("K")


def test_standard_variations_are_relative_and_leave_the_model():
    family = BASE.variations("standard")
    assert family.scenarios[0] == BASE
    assert len(family) == 14
    assert family["mass x1.2"].robot.mass == 6.0
    assert family["mass x0.8"].robot == BASE.robot.replace(mass=4.0)
    assert family["inertia x0.5"].robot.inertia == 0.04
    assert family["track x0.863"].robot.track_width == pytest.approx(0.863 * 0.3)
    assert family["friction 3 %"].coulomb_friction == pytest.approx(0.01 + 0.018)
    assert family["friction 6 %"].coulomb_friction == pytest.approx(0.01 + 0.036)
    force = 0.02 * 5 * 9.81
    expected = (0.1 + force, 0.02 + force * 0.15)
    assert family["disturbance 2 %"].disturbance == pytest.approx(expected)
    noise = family["noise 5 mm"].pose_noise
    assert noise == pytest.approx((np.hypot(0.003, 0.005), np.hypot(0.004, 0.005)))
    assert family["delay +1"].delay == 1
    corner = family["delay +1, inertia x0.5, track x0.863"]
    assert (corner.delay, corner.robot) == (
        1,
        BASE.robot.replace(inertia=0.04, track_width=0.863 * 0.3),
    )
    other = family["delay +1, friction 6 %"]
    assert (other.delay, other.coulomb_friction) == (1, pytest.approx(0.046))
    changed = [one for one in family if one.robot != BASE.robot]
    assert len(changed) == 5
    assert all(one.model == BASE.robot for one in changed)
    assert all(np.array_equal(one.reference, BASE.reference) for one in family)


@pytest.mark.parametrize("pose", [None, (1.02, 0.03, 1.5)])
def test_starts_beside_the_path_are_to_the_left_and_right_of_it(pose):
    scenario = BASE.replace(initial_pose=pose)
    path = scenario.trajectory
    own = np.array(pose or (path.x[0], path.y[0], path.theta[0]))
    family = scenario.variations("standard")
    left, right = (family[f"start {side}0.45 track"] for side in "+-")
    ahead = np.array([np.cos(path.theta[0]), np.sin(path.theta[0])])
    for one, distance in ((left, 0.135), (right, -0.135)):
        moved = np.array(one.initial_pose) - own
        assert moved[:2] @ ahead == pytest.approx(0, abs=1e-12)
        assert ahead[0] * moved[1] - ahead[1] * moved[0] == pytest.approx(distance)
        assert moved[2] == 0
        assert one.replace(initial_pose=pose) == scenario
    place = family.names.index("start -0.45 track")
    assert family.changes[place] == "starts 0.135 m further to the right"


def test_starts_where_a_run_has_diverged_are_not_standard():
    near = BASE.replace(initial_pose=None, divergence_distance=0.13)
    assert not [name for name in near.variations("standard").names if name.startswith("start")]
    with pytest.raises(ValueError, match=r"variations: start \+0.5 track: .*initial_pose is 0.1"):
        near.variations(start=0.5)
    # One side may be within, the other not.
    path = near.trajectory
    aside = near.replace(initial_pose=(path.x[0] + 0.1, path.y[0], path.theta[0]))
    names = [name for name in aside.variations("standard").names if name.startswith("start")]
    assert names == ["start +0.45 track"]


def test_a_model_of_one_s_own_stays():
    model = Robot(4.0, 0.07, 0.3, 0.033)
    family = BASE.replace(model=model).variations("standard")
    assert {one.model for one in family} == {model}


def test_euler_scenarios_are_also_integrated_finer():
    euler = BASE.replace(integrator="semi-implicit-euler", substeps=2).variations("standard")
    assert len(euler) == 17
    assert euler["substeps x4"].substeps == 8
    assert euler["substeps x20"].substeps == 40
    corner = euler["delay +1, substeps x4"]
    assert (corner.delay, corner.substeps) == (1, 8)


def test_variations_of_one_s_own():
    family = BASE.variations(
        mass=(0.9, 1.1),
        wheel_radius=1.02,
        viscous_friction=0.001,
        delay=np.array([1, 2]),
        corners=[{"mass": 1.1, "delay": 2}],
    )
    assert family.names == (
        *("nominal", "mass x0.9", "mass x1.1", "wheel radius x1.02", "viscous 0.001"),
        *("delay +1", "delay +2", "mass x1.1, delay +2"),
    )
    assert family.changes[-1] == "mass 5.5 kg, 2 samples (200 ms) of delay"
    assert family["mass x1.1, delay +2"].robot.mass == pytest.approx(5.5)
    assert family["viscous 0.001"].viscous_friction == 0.001
    both = BASE.variations("standard", delay=3)
    assert both[:-1] == BASE.variations("standard")
    assert both.scenarios[-1].delay == 3


def test_scrub_is_a_share_of_the_moment_of_both_torques():
    base = BASE.replace(coulomb_scrub=0.01)
    family = base.variations(scrub=0.05, corners=[{"scrub": 0.1, "mass": 1.1}])
    assert family.names == ("nominal", "scrub 5 %", "scrub 10 %, mass x1.1")
    most = BASE.torque_limit * BASE.robot.track_width / BASE.robot.wheel_radius
    scrubs = [one.coulomb_scrub for one in family]
    assert scrubs == pytest.approx([0.01, 0.01 + 0.05 * most, 0.01 + 0.1 * most])
    assert family.changes[1] == f"Coulomb scrub {0.01 + 0.05 * most:.4g} N m"
    assert not any("scrub" in name for name in base.variations("standard").names)


EULER = BASE.replace(integrator="semi-implicit-euler", substeps=1000)
BAD = [
    (BASE, {}, "the family is empty; give 'standard' or one of mass, inertia"),
    (BASE, {"which": "usual"}, "which is 'usual'; must be 'standard' or None"),
    (BASE, {"mass": ()}, "mass is empty; must have at least one number"),
    (BASE, {"mass": 0}, r"mass is 0; must be in \[0.01, 100\] \(a factor of the robot's mass\)"),
    (BASE, {"mass": "big"}, "mass is 'big'; must be in"),
    (BASE, {"mass": 1}, "mass is 1, which changes nothing"),
    (BASE, {"mass": (1.2, 1.2)}, "two scenarios named 'mass x1.2'"),
    (BASE, {"which": "standard", "mass": 1.2}, "two scenarios named 'mass x1.2'"),
    (BASE, {"delay": 1.5}, "delay is 1.5; must be a whole number"),
    (BASE, {"delay": 0}, r"delay is 0; must be in \[1, 64\] \(samples\)"),
    (BASE.replace(delay=60), {"delay": 5}, "delay [+]5: .*delay is 65; must be in"),
    (BASE, {"coulomb_friction": 0.99}, "friction is 0.604 N m a wheel; must be under the torque"),
    (BASE, {"scrub": 1}, "Coulomb scrub is [0-9.]+ N m; must be under the moment of both torques"),
    (BASE, {"scrub": -0.1}, r"scrub is -0.1; must be in \[0, 1\] \(a share of the moment"),
    (BASE, {"substeps": 4}, "substeps x4: contradicts the integrator 'exact'"),
    (EULER, {"substeps": 20}, r"substeps x20: .*substeps is 20000; must be in \[1, 10000\]"),
    (BASE, {"weight": 2}, "'weight' is unknown; known: mass, inertia"),
    (BASE, {"corners": {"mass": 2}}, "corners is {'mass': 2}; must be a list of mappings"),
    (BASE, {"corners": [{}]}, r"corners\[0\] is {}; must map names to one number each"),
    (BASE, {"corners": [{"mass": (1, 2)}]}, r"mass is \(1, 2\); must be in"),
]


@pytest.mark.parametrize(("scenario", "given", "message"), BAD, ids=lambda one: str(one)[:40])
def test_bad_variations_are_refused(scenario, given, message):
    with pytest.raises(ValueError, match=message):
        scenario.variations(**given)


def test_random_families_are_the_seed_s():
    family = families.random_variations(BASE, 20, rng=5, mass=(0.5, 0.6), delay=(2, 3))
    assert family == families.random_variations(BASE, 20, rng=5, mass=(0.5, 0.6), delay=(2, 3))
    assert family != families.random_variations(BASE, 20, rng=6, mass=(0.5, 0.6), delay=(2, 3))
    drawn = family[1:]
    assert drawn.names[0] == "random 1"
    factors = np.array([one.robot.mass / 5 for one in drawn])
    assert ((factors >= 0.5) & (factors <= 0.6)).all()
    assert len(set(factors)) == 20
    assert {one.delay for one in drawn} == {2, 3}
    assert all(one.model == BASE.robot for one in drawn)
    with pytest.raises(ValueError, match=r"mass is \(2, 1\); must be \(low, high\) in"):
        families.random_variations(BASE, 2, mass=(2, 1))
    with pytest.raises(ValueError, match="count is 0; must be a whole number"):
        families.random_variations(BASE, 0)


def test_families_over_paths_start_alike():
    start = (BASE.trajectory.x[0] + 0.1, BASE.trajectory.y[0] - 0.2, BASE.trajectory.theta[0] + 0.3)
    scenario = BASE.replace(initial_pose=start)
    paths = {"eight": Trajectory.eight(dt=0.1), "same": BASE.trajectory}
    family = families.over_paths(scenario, paths)
    assert family["same"] == scenario
    eight = family["eight"]
    assert eight.trajectory == paths["eight"]
    first = [simulate(one).columns for one in (scenario, eight)]
    for name in ("e_x", "e_y", "e_theta"):
        assert first[0][name][0] == pytest.approx(first[1][name][0], abs=1e-12)
    assert families.over_paths(BASE, paths)["eight"].initial_pose is None
    for bad, message in (({}, "the family is empty"), ({"a": 3}, r"paths\['a'\] is 3")):
        with pytest.raises(ValueError, match=message):
            families.over_paths(BASE, bad)


def test_a_family_is_a_sequence_with_names():
    family = BASE.variations(mass=(0.9, 1.1))
    assert list(family) == [family[0], family["mass x0.9"], family[-1]]
    assert isinstance(family[1:], Family)
    assert str(family).splitlines()[1] == "mass x0.9  mass 4.5 kg"
    joined = family + family.renamed("again")
    assert joined.names[-1] == "again/mass x1.1"
    with pytest.raises(ValueError, match="the family is empty"):
        family[3:]
    with pytest.raises(ValueError, match="two scenarios named 'nominal'"):
        family + family
    with pytest.raises(KeyError, match="no scenario is named 'x'; known: nominal"):
        family["x"]
    with pytest.raises(ValueError, match="2 names, 1 scenarios and 1 changes"):
        Family(("a", "b"), (BASE,), ("",))


def test_simulate_many_measures_each_run():
    family = Scenario.published(rng=0).variations("standard")
    runs = nfopidn.simulate_many(family, Controller.published(), workers=2)
    alone = [simulate(one) for one in family]
    assert runs.names == family.names
    assert runs.costs.tolist() == [one.cost for one in alone]
    for name, values in runs.metrics.items():
        assert values.tolist() == [one.metrics[name] for one in alone]
    at = [np.nan if one.diverged_at is None else one.diverged_at for one in alone]
    assert np.array_equal(runs.diverged_at, at, equal_nan=True)
    assert runs.diverged.sum() == 2
    assert runs.mean_cost == np.mean(np.minimum(runs.costs, 1))
    assert runs.worst_cost == 1
    assert runs.worst in ("delay +1, inertia x0.5, track x0.863", "delay +1, substeps x4")
    assert "diverges at 29.6 s" in str(runs)
    rival = nfopidn.simulate_many({"a": family[0]}, Rival("samson"))
    assert rival.costs[0] == simulate(family[0], Rival("samson")).cost


def test_simulate_many_refuses_what_is_no_family():
    for scenarios in ([], {}, Family):
        with pytest.raises(ValueError, match=r"the family is empty|must be a Family or Scenarios"):
            nfopidn.simulate_many(scenarios, Controller.published())
    with pytest.raises(ValueError, match="controller is 3; must be a Controller or a Rival"):
        nfopidn.simulate_many([BASE], 3)
    with pytest.raises(ValueError, match=r"nominal: .*sample_time of the controller is 0.2 s"):
        nfopidn.simulate_many(BASE.variations(mass=2), Controller.tuned_nominal())


def test_families_are_compared_and_tuned_on():
    family = Scenario.published(rng=0).variations(mass=(0.8, 1.2))
    compared = nfopidn.compare({"published": Controller.published()}, family)
    assert compared.scenarios == family.names
    runs = nfopidn.simulate_many(family, Controller.published())
    assert compared.values["cost"][0, :, 0].tolist() == runs.costs.tolist()
    objective = nfopidn.Objective(family, structure="paper")
    x = objective.parameters_of(Controller.published())
    assert objective(x) == pytest.approx(runs.costs.mean(), rel=1e-10)
