"""The report page: its figures against the library, its text, its safety, in a browser."""

import base64
import gzip
import html
import json
import os
import re
import resource
import shutil
import subprocess
import sys
from html.parser import HTMLParser

import nfopidn
import numpy as np
import pytest
from nfopidn import (
    Controller,
    Rival,
    Scenario,
    Trajectory,
    TuneResult,
    commands,
    simulate,
    simulate_many,
    stability,
)
from nfopidn.reporting import page as page_module
from nfopidn.reporting.numbers import readable, readable_power
from nfopidn.reporting.settings import scenario_groups, value_text
from nfopidn.reporting.words import CHOICES, CONTROLLER, METRICS, SCENARIO
from nominal import tune
from numpy.testing import assert_allclose

LARGEST = 1_600_000  # bytes
DIGITS = {"rtol": 6e-6, "atol": 1e-12}
RUN = (
    *("t", "x_ref", "y_ref", "theta_ref", "x", "y", "theta", "v", "omega"),
    *("e_x", "e_y", "e_theta", "tau_ref_left", "tau_ref_right"),
    *("tau_fb_left", "tau_fb_right", "tau_left", "tau_right"),
)


class Parsed(HTMLParser):
    """What a page has: elements with their attributes, scripts, text outside of them."""

    def __init__(self, text):
        super().__init__()
        self.elements, self.scripts, self.styles, self.words = [], [], [], []
        self._within = None
        self.feed(text)
        packed = next(s for a, s in self.scripts if a.get("id") == "report-data")
        self.data = json.loads(gzip.decompress(base64.b64decode(packed)))
        self.text = re.sub(r"\s+", " ", " ".join(self.words))

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        self._within = tag if tag in ("script", "style") else None
        if tag == "script":
            self.scripts.append((dict(attrs), ""))

    def handle_endtag(self, tag):
        self._within = None

    def handle_data(self, data):
        if self._within == "script":
            attributes, before = self.scripts[-1]
            self.scripts[-1] = (attributes, before + data)
        elif self._within == "style":
            self.styles.append(data)
        else:
            self.words.append(data)


def traces(figure, columns):
    """Give a figure's lines by panel and name, as x and y."""
    found = {}
    columns = figure.get("columns", columns)
    for trace in figure["traces"]:
        x, y = (
            columns[trace[k][1:]] if isinstance(trace[k], str) else trace[k] for k in ("x", "y")
        )
        found[trace["panel"], trace["name"]] = (x, y)
    return found


def numbers(values):
    return np.array(values, dtype=float)  # None becomes nan


@pytest.fixture(scope="module")
def result():
    return tune(Scenario.published(period=30, rng=0), structure="extended", rng=2, maxfev=300)


@pytest.fixture(scope="module")
def path(result, tmp_path_factory):
    """The page of a result, by way of its file and the command."""
    folder = tmp_path_factory.mktemp("report")
    result.to_json(folder / "result.json")
    path = folder / "report.html"
    assert commands.main(["report", str(folder / "result.json"), "-o", str(path)]) == 0
    return path


@pytest.fixture(scope="module")
def page(path):
    return Parsed(path.read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def run(result):
    return simulate(result.scenario, result.controller)


@pytest.fixture
def plain(monkeypatch):
    """Pages without BokehJS, which has its test."""
    monkeypatch.setattr(page_module, "bokeh_script", str)


def parsed(result):
    return Parsed(page_module.page(result))


# The figures


def test_the_run_is_that_of_simulate(page, run):
    (scenario,) = page.data["scenarios"]
    assert scenario["diverged_at"] is None
    for name in RUN:
        assert_allclose(numbers(scenario["columns"][name]), run.columns[name], **DIGITS)


@pytest.mark.parametrize(
    ("figure", "panel", "name", "column"),
    [
        ("torques", 0, "total, limited", "tau_left"),
        ("torques", 1, "total, limited", "tau_right"),
        ("torques", 0, "feedforward", "tau_ref_left"),
        ("torques", 1, "feedforward", "tau_ref_right"),
        ("torques", 0, "feedback", "tau_fb_left"),
        ("torques", 1, "feedback", "tau_fb_right"),
        ("velocities", 0, "robot", "v"),
        ("velocities", 1, "robot", "omega"),
        ("errors", 0, "forward", "e_x"),
        ("errors", 0, "lateral", "e_y"),
        ("errors", 1, "heading", "e_theta"),
    ],
)
def test_a_line_shows_its_column_against_time(figure, panel, name, column, page, run):
    (scenario,) = page.data["scenarios"]
    x, y = traces(scenario["figures"][figure], scenario["columns"])[panel, name]
    assert_allclose(numbers(x), run.t, **DIGITS)
    assert_allclose(numbers(y), run.columns[column], **DIGITS)


def test_references_and_limits_are_drawn(page, result):
    (scenario,) = page.data["scenarios"]
    trajectory = result.scenario.trajectory
    lines = traces(scenario["figures"]["velocities"], scenario["columns"])
    assert_allclose(numbers(lines[0, "reference"][1]), trajectory.v, **DIGITS)
    assert_allclose(numbers(lines[1, "reference"][1]), trajectory.omega, **DIGITS)
    for panel in (0, 1):
        lines = traces(scenario["figures"]["torques"], scenario["columns"])
        limit = next(y for (at, name), (_, y) in lines.items() if at == panel and "limit ±" in name)
        assert limit == [3.078, 3.078, None, -3.078, -3.078]
    lines = traces(scenario["figures"]["path"], scenario["columns"])
    assert_allclose(numbers(lines[0, "reference"]), [trajectory.x, trajectory.y], **DIGITS)


@pytest.mark.usefixtures("plain")
@pytest.mark.parametrize(("limit", "beyond"), [(3.078, False), (300.0, True)])
def test_a_limit_far_away_does_not_flatten_the_torques(limit, beyond, result):
    scenario = result.scenario.replace(torque_limit=limit)
    run = simulate(scenario, result.controller)
    (shown,) = parsed(TuneResult({**result, "scenario": scenario})).data["scenarios"]
    figure = shown["figures"]["torques"]
    names = {trace["name"] for trace in figure["traces"]}
    assert (f"limit ±{limit:g} N m, beyond the scale" in names) == beyond
    assert (f"limit ±{limit:g} N m" in names) != beyond
    feedback = np.abs([run.columns[f"tau_fb_{side}"] for side in ("left", "right")]).max()
    reaches = [panel.get("range", [-9, 9])[1] for panel in figure["panels"]]
    assert min(reaches) > max(feedback, run.metrics["torque_peak"])
    assert not beyond or max(reaches) < limit


def test_the_path_has_equal_scales_and_outlines_of_the_robot(page, run):
    (scenario,) = page.data["scenarios"]
    assert scenario["figures"]["path"]["equal"]
    lines = traces(scenario["figures"]["path"], scenario["columns"])
    assert_allclose(numbers(lines[0, "robot"]), run.pose[:, :2].T, **DIGITS)
    outlines = numbers(lines[0, "robot along the way"])
    gaps = np.flatnonzero(np.isnan(outlines[0]))
    for outline in np.split(outlines, gaps + 1, axis=1)[:-1]:
        centre, circle = outline[:, 0], outline[:, 1:-1]
        nearest = np.hypot(*(run.pose[:, :2].T - centre[:, None])).argmin()
        assert_allclose(run.pose[nearest, :2], centre, atol=1e-3)
        reach = circle - centre[:, None]
        assert_allclose(np.hypot(*reach), scenario["robot_radius"], rtol=1e-3)
        heading = np.arctan2(reach[1, 0], reach[0, 0]) - run.pose[nearest, 2]
        assert abs(np.sin(heading / 2)) < 1e-3
    assert len(gaps) > 5


def test_every_axis_has_a_title_with_its_unit(page):
    (scenario,) = page.data["scenarios"]
    figures = page.data["figures"] | scenario["figures"]
    assert len(figures) == 9
    for name, figure in figures.items():
        for axis in [figure["x"], *figure["panels"]]:
            title = axis["title"]
            assert title in ("evaluations of the cost", "") or re.search(r"\[.+\]", title), (
                name,
                axis,
            )


def test_the_convergence_is_the_history(page, result):
    lines = traces(page.data["figures"]["convergence"], {})
    for name, column in (("best so far", "best"), ("mean of the cells", "mean")):
        x, y = lines[0, name]
        assert_allclose(numbers(x), result.history["nfev"])
        finite = np.isfinite(result.history[column])
        assert_allclose(numbers(y)[finite], result.history[column][finite], **DIGITS)
        assert np.isnan(numbers(y)[~finite]).all()


def test_stability_is_that_of_the_library(page, result):
    found = stability.loop(result.scenario, result.controller)
    (scenario,) = page.data["scenarios"]
    drawn = []
    for (_, name), (x, y) in traces(scenario["figures"]["multipliers"], {}).items():
        if name in ("largest", "others"):
            drawn += list(numbers(x) + 1j * numbers(y))
    assert found.spectral_radius < 2  # beyond, the radius is logarithmic
    expected = found.multipliers[np.abs(found.multipliers) >= 1e-12 * found.spectral_radius]
    assert_allclose(np.sort_complex(drawn), np.sort_complex(expected), rtol=1e-5, atol=1e-11)
    assert f"Spectral radius {readable(found.spectral_radius)} " in page.text
    assert f"{found.period} samples, 30 s" in page.text
    assert str(found.simulated) in page.text
    assert found.verdict.capitalize() in page.text


@pytest.mark.usefixtures("plain")
def test_the_basin_is_that_of_the_library(result):
    scenario, controller = Scenario.published(rng=0), Controller.published()
    page = parsed(TuneResult({**result, "scenario": scenario, "controller": controller}))
    heat, *others = page.data["scenarios"][0]["figures"]["basin"]["traces"]
    assert heat["kind"] == "map"
    found = stability.basin(scenario, controller, x=heat["x"], y=heat["y"])
    finite = np.isfinite(found.position_error)
    assert 0 < finite.sum() < finite.size == 41 * 41
    shown = numbers(heat["z"])
    assert np.array_equal(np.isfinite(shown), finite)
    assert_allclose(shown[finite], found.position_error[finite], rtol=1e-3)
    lines = {trace["name"]: trace for trace in others}
    assert len(lines["diverges"]["x"]) == (~finite).sum()
    sides = [np.diff(found.converged.astype(int), axis=axis) for axis in (0, 1)]
    edge = lines["0.3 m from the path"]
    assert edge["x"].count(None) == sum(np.count_nonzero(side) for side in sides)
    cell = found.x[1] - found.x[0]
    ends = np.array([edge["x"], edge["y"]], dtype=float).T.reshape(-1, 3, 2)[:, :2]
    for start, end in ends:  # between a start that converges and one that does not
        across = (end - start)[::-1] / 2
        assert_allclose(np.hypot(*across), cell / 2, rtol=1e-4)
        columns, rows = (
            np.abs(axis - at[:, None]).argmin(axis=1)
            for axis, at in zip(
                (found.x, found.y), ((start + end) / 2 + [across, -across]).T, strict=True
            )
        )
        assert np.unique(found.converged[rows, columns]).size == 2
    assert f"{found.share:.1%} end within 0.3 m" in page.text


def judged(result):
    """A result's family, and what the page's figure shows of it by name."""
    page = parsed(result)
    figures = page.data["figures"]
    by_name = {}
    for trace in figures["variations"]["traces"]:
        by_name.setdefault(trace["name"], trace)
    return page, figures, by_name


@pytest.mark.usefixtures("plain")
def test_the_costs_are_those_of_the_verdict_and_of_lqr(result):
    _, figures, shown = judged(result)
    family = result.scenario.variations("standard")
    labels = [label.replace("\n", " ") for label in figures["variations"]["panels"][0]["labels"]]
    assert labels == list(family.names)
    lqr = simulate_many(family, Rival("lqr"))
    assert lqr.diverged.any()
    for name, runs in (("tuned", result.verdict.runs), ("LQR", lqr)):
        kept = ~runs.diverged
        assert_allclose(shown[name]["x"], runs.costs[kept], **DIGITS)
        rows = np.arange(len(family))[::-1][kept]
        assert np.abs(np.array(shown[name]["y"]) - rows).max() < 0.3
        names = np.array(family.names)[kept]
        assert shown[name]["columns"]["name"] == names.tolist()
    assert figures["variations"]["x"]["log"]


@pytest.mark.usefixtures("plain")
def test_what_diverges_is_red_and_has_the_word(result):
    controller = Controller.published(form="incremental")
    page, figures, shown = judged(TuneResult({**result, "controller": controller}))
    family = result.scenario.variations("standard")
    lost = simulate_many(family, controller).diverged
    assert lost.all()
    assert shown["tuned"]["x"] == []
    words = shown[""]["columns"]["text"]
    lqr = simulate_many(family, Rival("lqr")).diverged
    assert words == ["tuned, LQR diverge" if one else "tuned diverges" for one in lqr]
    assert shown["diverges"]["y"] == list(range(len(family)))[::-1]
    assert shown["diverges"]["colour"] == shown[""]["colour"] == "bad"
    bundle = [trace for trace in figures["bundle"]["traces"] if trace["name"] != "reference"]
    assert [trace["name"] for trace in bundle] == [f"{name}: diverges" for name in family.names]
    assert {trace["colour"] for trace in bundle} == {"bad"}
    for title in ("Gain", "Phase", "Delay"):
        assert re.search(rf"{title} +red: not stable", page.text)


@pytest.mark.usefixtures("plain")
def test_the_bundle_has_the_path_of_each_variation(result):
    _, figures, _ = judged(result)
    family = result.scenario.variations("standard")
    reference, *lines = figures["bundle"]["traces"]
    path = result.scenario.trajectory
    assert_allclose([reference["x"], reference["y"]], [path.x, path.y], **DIGITS)
    assert len(lines) == len(family)
    for trace in lines:
        (name,) = set(trace["columns"]["name"])
        run = simulate(family[name], result.controller)
        assert_allclose(np.transpose([trace["x"], trace["y"]]), run.pose[:, :2], atol=1e-3)
    assert {name for trace in lines for name in trace["columns"]["name"]} == set(family.names)


def test_the_margins_are_those_of_the_verdict(page, result):
    margin, limits = result.verdict.margin, result.verdict.limits
    assert f"Gain {margin.decibels:.3g} dB" in page.text
    assert margin.source == "simulated"  # of which there is no phase
    assert "Phase not known" in page.text
    assert limits.extra_delay == 0
    assert "Delay 0 samples, red: under 1 sample" in page.text
    kinds = [a["class"] for _, a in page.elements if a.get("class", "").startswith("margin")]
    assert kinds[0] in ("margin green", "margin amber")
    assert kinds[1:] == ["margin green", "margin red"]
    for name, text in result.verdict.rows():
        assert f"{name.capitalize()} {text}" in page.text


@pytest.mark.usefixtures("plain")
def test_a_reference_that_never_moves_has_no_robustness(result):
    still = Scenario(Trajectory.from_samples([0, 0, 0, 0], [0, 0, 0, 0], dt=0.2), rng=0)
    page = parsed(TuneResult({**result, "scenario": still}))
    assert set(page.data["figures"]) == {"convergence"}
    assert not any(a.get("id") == "robustness" for _, a in page.elements)


# The text


def test_the_gains_and_orders_are_written(page, result):
    controller = result.controller
    text = re.sub(r" +", " ", page.text)
    columns = (*controller.gains.T, controller.alpha, controller.sigma)
    names = ("k p", "k i", "k d", "\N{GREEK SMALL LETTER ALPHA}", "\N{GREEK SMALL LETTER SIGMA}")
    for name, row in zip(names, columns, strict=True):
        assert f"{name} " + " ".join(readable(value, 6) for value in row) in text


def test_the_metrics_are_written_with_units(page, run):
    assert set(METRICS) == set(run.metrics)
    for name, value in run.metrics.items():
        assert f"{METRICS[name][0]} {readable(value)}" in page.text or name == "share_at_limit"
    share = readable(100 * run.metrics["share_at_limit"])
    assert f"{METRICS['share_at_limit'][0]} {share} %" in page.text
    assert re.search(r"Torque, largest \S+ N m", page.text)
    assert re.search(r"ISE \S+ m² s", page.text)


def test_every_setting_has_words_and_is_written(page, result):
    scenario, text = json.loads(result.scenario.to_json()), page.text
    known = {key for words in SCENARIO.values() for key in words}
    sampled = Scenario(Trajectory.from_samples([0, 1, 2], [0, 0, 0], dt=0.1), rng=0)
    for document in (scenario, json.loads(sampled.to_json())):
        for key, value in document.items():
            parts = [f"{key}.{part}" for part in value] if isinstance(value, dict) else [key]
            assert set(parts) <= known | {"format", "version"}
    controller = json.loads(result.controller.to_json())
    elsewhere = {"format", "version", "gains", "alpha", "sigma"}
    assert set(controller) - elsewhere <= set(CONTROLLER)
    for words in ("Lap time 30 s", "Torque limit 3.078 N m", "Inertia 0.5873 kg m²"):
        assert words in text
    for words in ("Initial pose 4 m, 0 m, 1.0472 rad", "Feedforward yes", "Delay 0 samples"):
        assert words in text


def test_a_setting_without_words_is_shown_by_its_key(monkeypatch):
    words = {group: dict(listed) for group, listed in SCENARIO.items()}
    del words["Run"]["delay"]
    monkeypatch.setattr("nfopidn.reporting.settings.SCENARIO", words)
    rows = scenario_groups(Scenario.published(rng=0, delay=2))["Run"]
    assert ("delay", "2") in [(row.label, row.value) for row in rows]


def test_values_are_written_in_words():
    assert value_text("initial_pose", None, "m,m,rad") == CHOICES["initial_pose", "none"]
    assert value_text("feedforward", False, "") == "no"
    assert value_text("disturbance", [[0, 1]] * 5, "N,N m") == "5 values, one a sample"
    assert value_text("disturbance", [-1.5, 0.0], "N,N m") == "\N{MINUS SIGN}1.5 N, 0 N m"
    assert readable(7.37e-6) == "7.37\u202f\N{MULTIPLICATION SIGN}\u202f10⁻⁶"
    assert readable_power(-2000 * np.log(10)) == "1\u202f\N{MULTIPLICATION SIGN}\u202f10⁻²⁰⁰⁰"
    assert readable_power(-np.inf) == "0"


@pytest.mark.usefixtures("plain")
def test_free_taps_have_a_table():
    scenario = Scenario.published(period=30, rng=0)
    result = tune(scenario, structure="taps", rng=2, maxfev=100)
    page = parsed(result)
    for i, taps in enumerate(result.controller.taps.T):
        row = " ".join([str(i), *(readable(tap, 6) for tap in taps)])
        assert re.sub(r"\s+", " ", row) in page.text


@pytest.mark.usefixtures("plain")
def test_a_rival_has_a_table_and_no_analysis():
    scenario = Scenario.published(period=30, rng=0)
    result = tune(scenario, structure="samson", rng=1, maxfev=100)
    page = parsed(result)
    for name, value in result.controller.parameters.items():
        assert f"{name} {readable(value, 6)} " in page.text
    assert "Law samson" in page.text
    assert "NFOPIDN controllers alone, not of samson." in page.text
    assert sorted(page.data["scenarios"][0]["figures"]) == [
        *["errors", "path", "torques", "velocities"]
    ]
    run = simulate(scenario, result.controller)
    assert_allclose(numbers(page.data["scenarios"][0]["columns"]["x"]), run.columns["x"], **DIGITS)
    assert not any(attributes.get("id") == "basin-1" for _, attributes in page.elements)


@pytest.mark.usefixtures("plain")
@pytest.mark.filterwarnings("ignore:tune. the reference torques reach 2.11 N m")
def test_each_scenario_has_a_section_and_what_cannot_be_said_is_said():
    x = np.linspace(0, 6, 60)
    scenarios = [
        Scenario.published(period=30, rng=0),
        Scenario.published(period=30, rng=0, delay=1, torque_limit=0.9),
        Scenario(Trajectory.from_samples(x, np.sin(x), dt=0.1), rng=0),
        Scenario.published(period=30, rng=0, initial_pose=(12, 0, 0)),
    ]
    result = tune(scenarios, rng=1, maxfev=50)
    page = parsed(result)
    assert len(page.data["scenarios"]) == 4
    for i, (scenario, shown) in enumerate(zip(scenarios, page.data["scenarios"], strict=True)):
        assert ("section", {"class": "scenario", "id": f"scenario-{i + 1}"}) in page.elements
        run = simulate(scenario, result.controller)
        assert_allclose(numbers(shown["columns"]["x"]), run.columns["x"], **DIGITS)
        if run.diverged_at is not None:
            assert f"diverges at {readable(run.diverged_at)} s" in page.text
    assert "Other than the first: torque limit 0.9 N m, delay 1 sample." in page.text
    with pytest.raises(ValueError, match=r"stability\.loop") as refusal:
        stability.loop(scenarios[2], result.controller)
    assert f"There is no verdict. {refusal.value}." in page.text
    assert "multipliers" not in page.data["scenarios"][2]["figures"]


@pytest.mark.usefixtures("plain")
@pytest.mark.parametrize(
    ("controller", "words"),
    [
        (Controller.published(form="incremental"), "Unstable. "),
        (Controller.published(frame="world"), "No periodic orbit was found"),
    ],
)
def test_a_diverging_loop_is_shown_until_it_diverges(controller, words, result):
    page = parsed(TuneResult({**result, "controller": controller}))
    run = simulate(result.scenario, controller)
    (scenario,) = page.data["scenarios"]
    assert scenario["diverged_at"] == run.diverged_at is not None
    assert len(scenario["columns"]["t"]) == len(run)
    assert len(scenario["columns"]["path_x"]) == len(run.scenario.trajectory)
    assert words in page.text
    assert f"The search reported E = {readable(result.fun, 7)}" in page.text


@pytest.mark.usefixtures("plain")
def test_long_runs_are_thinned_and_the_page_says_so(result, run, monkeypatch):
    monkeypatch.setattr("nfopidn.reporting.run_figures._MOST_ROWS", 100)
    monkeypatch.setattr("nfopidn.reporting.run_figures._FEWEST_ROWS", 10)
    page = parsed(result)
    kept = [*range(0, len(run), 2)]
    assert len(run) == 151
    columns = page.data["scenarios"][0]["columns"]
    assert_allclose(numbers(columns["y"]), run.columns["y"][kept], **DIGITS)
    assert columns["t"][-1] == 30
    assert "One sample in 2 is drawn." in page.text


# The page by itself


def test_the_page_loads_nothing(page):
    for tag, attributes in page.elements:
        for name in ("src", "href", "srcset", "action", "data", "poster"):
            assert attributes.get(name, "#").startswith("#"), (tag, attributes)
        assert tag not in ("link", "iframe", "object", "embed", "img", "base")
    assert not re.search(r"url\(|@import", "".join(page.styles))
    policy = next(a["content"] for _, a in page.elements if "http-equiv" in a)
    assert policy.startswith("default-src 'none';")
    assert "http" not in policy


def test_the_page_is_small_and_the_same_each_time(path, result, tmp_path):
    assert 400_000 < path.stat().st_size < LARGEST
    again = nfopidn.report(TuneResult.from_json(path.parent / "result.json"), tmp_path / "a.html")
    assert again == tmp_path / "a.html"
    assert again.read_bytes() == path.read_bytes()


HOSTILE = '</script><script>alert(1)</script><!-- & "quoted" \u2028'


@pytest.mark.usefixtures("plain")
@pytest.mark.parametrize("field", ["structure", "method", "message", "parameters", "options"])
def test_text_from_the_file_stays_text(field, result, tmp_path):
    result.to_json(tmp_path / "result.json")
    document = json.loads((tmp_path / "result.json").read_text())
    count = len(document["parameters"])
    document[field] = {"parameters": [HOSTILE] * count, "options": {HOSTILE: HOSTILE}}.get(
        field, HOSTILE
    )
    (tmp_path / "result.json").write_text(json.dumps(document))
    nfopidn.report(tmp_path / "result.json", tmp_path / "report.html")
    page = Parsed((tmp_path / "report.html").read_text(encoding="utf-8"))
    assert len(page.scripts) == 4
    assert re.sub(r"\s+", " ", HOSTILE).strip() in page.text


def test_what_is_packed_cannot_end_its_script():
    text = page_module.packed("</script><!--&>\u2028")
    assert re.fullmatch(r"[A-Za-z0-9+/=]+", text)
    assert gzip.decompress(base64.b64decode(text)).decode() == "</script><!--&>\u2028"
    with pytest.raises(ValueError, match="JSON"):
        page_module.packed_json([float("nan")])


# What is refused


def changed(**changes):
    return lambda document: json.dumps(document | changes)


FAULTS = {
    "no JSON": (lambda _: "{", ["not a tuning result"]),
    "no text": (lambda _: b"\xff\xfe\x00", ["not a tuning result"]),
    "deep": (lambda _: "[" * 200_000, ["not a tuning result"]),
    "a list": (lambda _: "[]", ["not a tuning result"]),
    "a controller": (lambda document: json.dumps(document["controller"]), ["nfopidn-tuning"]),
    "another version": (changed(version=2), ["version 1"]),
    "cost": (changed(fun="low"), ["fun must be a number"]),
    "message": (changed(message=3), ["message must be a text"]),
    "structure": (changed(structure=[1]), ["structure must be a name or settings"]),
    "options": (changed(options=[1]), ["options must be settings"]),
    "elapsed": (changed(elapsed="long"), ["elapsed must be a number"]),
    "parameters": (changed(parameters="kp"), ["parameters must be a list of names"]),
    "names": (changed(parameters=[1] * 15), ["parameters must be a list of names"]),
    "x": (changed(parameters=["kp_x"]), ["x must have 1 numbers"]),
    "scenario": (changed(scenario=[]), ["scenario is empty"]),
    "history": (changed(history=[[1, 2]]), ["not a tuning result"]),
}


@pytest.mark.parametrize(("change", "parts"), FAULTS.values(), ids=FAULTS.keys())
def test_the_command_refuses_a_file(change, parts, path, tmp_path, capsys):
    document = json.loads((path.parent / "result.json").read_text())
    content = change(document)
    source = tmp_path / "result.json"
    source.write_bytes(content if isinstance(content, bytes) else content.encode())
    code = commands.main(["report", str(source), "-o", str(tmp_path / "report.html")])
    out, err = capsys.readouterr()
    assert (code, out) == (2, "")
    assert err.startswith(f"nfopidn: {source}: not a tuning result")
    assert err.count("\n") == 1
    assert all(part in err for part in parts), err
    assert os.listdir(tmp_path) == ["result.json"]


@pytest.mark.usefixtures("plain")
@pytest.mark.parametrize(
    ("source", "target", "words"),
    [
        ("none.json", "report.html", "No such file"),
        (None, "none/report.html", "No such directory"),
        (None, ".", "is no regular file"),
        (None, "/dev/null", "is no regular file"),
    ],
)
def test_the_command_refuses_places(source, target, words, path, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    code = commands.main(["report", source or str(path.parent / "result.json"), "-o", target])
    out, err = capsys.readouterr()
    assert (code, out) == (2, "")
    assert err.startswith("nfopidn: ")
    assert err.count("\n") == 1
    assert words in err
    assert os.listdir(tmp_path) == []


def test_a_page_is_not_written_over_its_result(path, tmp_path, capsys):
    source = tmp_path / "result.json"
    shutil.copy(path.parent / "result.json", source)
    (tmp_path / "link.html").symlink_to(source)
    before = source.read_bytes()
    for target in (source, tmp_path / "link.html"):
        assert commands.main(["report", str(source), "-o", str(target)]) == 2
        assert "is the result itself" in capsys.readouterr().err
    assert source.read_bytes() == before


@pytest.mark.usefixtures("plain")
def test_a_failed_write_leaves_the_old_page(path, tmp_path, capsys):
    target = tmp_path / "report.html"
    target.write_text("precious")
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (5000, limits[1]))
    try:
        assert commands.main(["report", str(path.parent / "result.json"), "-o", str(target)]) == 2
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert "File too large" in capsys.readouterr().err
    assert target.read_bytes() == b"precious"
    assert os.listdir(tmp_path) == ["report.html"]


@pytest.mark.parametrize("missing", ["jinja2", "bokeh.resources"])
def test_a_missing_extra_is_named(missing, path, tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, missing, None)
    target = tmp_path / "report.html"
    assert commands.main(["report", str(path.parent / "result.json"), "-o", str(target)]) == 2
    expected = "nfopidn: a report needs Bokeh: pip install 'nfopidn[report]'\n"
    assert capsys.readouterr().err == expected
    assert not target.exists()


@pytest.mark.parametrize("wrong", [None, 3, {"fun": 1.0}, nfopidn.OptimizeResult(fun=1.0)])
def test_what_is_no_result_is_refused(wrong, tmp_path):
    with pytest.raises(ValueError, match=r"result is a .*; must be a TuneResult"):
        nfopidn.report(wrong, tmp_path / "report.html")
    with pytest.raises(ValueError, match="result: has no scenario"):
        nfopidn.report(TuneResult(fun=1.0), tmp_path / "report.html")


def test_importing_the_library_brings_neither_jinja_nor_bokeh():
    code = "import sys, nfopidn, nfopidn.commands; print({'jinja2', 'bokeh'} & set(sys.modules))"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout == "set()\n"


# In a browser

PROBE = """
<script>
const seen = {};
const after = (time) => new Promise((done) => setTimeout(done, time));
// Elements within shadow roots, too.
const within = (root, selector) => [
  ...root.querySelectorAll(selector),
  ...[...root.querySelectorAll("*")]
    .flatMap((e) => e.shadowRoot ? within(e.shadowRoot, selector) : []),
];
const colours = (place) => Math.max(...within(place, "canvas").map((canvas) => {
  if (canvas.width === 0 || canvas.height === 0) return 0;
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  return new Set(new Uint32Array(data.buffer)).size;
}));
// The browser knows no pointer of these events.
Element.prototype.setPointerCapture = Element.prototype.releasePointerCapture = () => {};
const mouse = (place, kind, x, y) => place.dispatchEvent(new PointerEvent(kind, {
  bubbles: true, composed: true, cancelable: true, pointerId: 1, pointerType: "mouse",
  isPrimary: true, button: kind === "pointermove" ? -1 : 0, buttons: kind === "pointerup" ? 0 : 1,
  clientX: x, clientY: y, view: window,
}));
const watch = async () => {
  const { overview, drawn: [drawn] } = await window.report;
  await after(500);
  const look = (name) => {
    const [reference, body] = drawn.path.moving;
    seen[name] = {
      now: document.getElementById("now-1").textContent,
      slider: Number(document.getElementById("slider-1").value),
      button: document.getElementById("play-1").textContent,
      x: Array.from(body.data.x), y: Array.from(body.data.y),
      marks: drawn.errors.marks.map((mark) => mark.location),
    };
  };
  look("opened");
  seen.colours = {};
  for (const place of document.querySelectorAll(".plot")) seen.colours[place.id] = colours(place);
  const { x_range: across, y_range: up, inner_width, inner_height } = drawn.path.plots[0];
  seen.scales = [(across.end - across.start) / inner_width, (up.end - up.start) / inner_height];

  // A name in the legend hides its lines in both panels.
  const name = within(document.getElementById("torques-1"), "*")
    .filter((e) => e.textContent.trim() === "feedback").at(-1);
  const hidden = () => drawn.torques.renderers.filter((r) => !r.visible).map((r) => r.name);
  seen.hidden = [hidden()];
  mouse(name, "pointerdown", 0, 0);
  seen.hidden.push(hidden());
  mouse(name, "pointerdown", 0, 0);
  seen.hidden.push(hidden());

  // The values at a point, and a part drawn larger.
  const place = document.getElementById("torques-1");
  place.scrollIntoView({ block: "center", behavior: "instant" });
  await after(200);
  const events = within(place, ".bk-events")[0];
  const box = events.getBoundingClientRect();
  const [x, y] = [box.left + 0.5 * box.width, box.top + 0.6 * box.height];
  mouse(events, "pointerover", x, y);
  mouse(events, "pointermove", x, y);
  await after(300);
  seen.tip = within(document, ".bk-tooltip-content").map((e) => e.textContent).join(" ");
  const time = drawn.torques.plots[0].x_range;
  seen.zoom = [[time.start, time.end]];
  mouse(events, "pointerdown", x, y);
  for (let i = 1; i <= 10; ++i) mouse(events, "pointermove", x + 15 * i, y + 3 * i);
  mouse(events, "pointerup", x + 150, y + 30);
  await after(300);
  seen.zoom.push([time.start, time.end]);

  const slider = document.getElementById("slider-1");
  slider.value = 50;
  slider.dispatchEvent(new Event("input"));
  await after(500);
  look("moved");
  document.getElementById("play-1").click();
  await after(2000);
  look("playing");
  document.getElementById("play-1").click();
  seen.outside = performance.getEntriesByType("resource").map((entry) => entry.name);
};
watch().catch((error) => { seen.error = String(error.stack); })
  .finally(() => { document.body.dataset.seen = JSON.stringify(seen); });
</script>
</body>"""


#: A mouse, which a browser without a window does not have.
MOUSE = (
    "--blink-settings=primaryHoverType=2,availableHoverTypes=2,"
    "primaryPointerType=4,availablePointerTypes=4"
)
DARK = "--blink-settings=preferredColorScheme=0"


@pytest.fixture(scope="module")
def browser():
    """Open a page without a network at a time [s]; give its DOM and what it said."""
    program = shutil.which("chromium")
    if program is None:
        pytest.fail("no chromium: install it (Debian: apt-get install chromium; ./dev does)")

    def opened(path, profile, *flags):
        command = [
            *(program, "--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars"),
            *("--disable-background-networking", "--host-resolver-rules=MAP * ~NOTFOUND"),
            *("--proxy-server=127.0.0.1:9", "--enable-logging=stderr", "--window-size=1280,2000"),
            *flags,
            *("--virtual-time-budget=12000", f"--user-data-dir={profile}", "--dump-dom"),
            f"file://{path}",
        ]
        done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
        assert done.returncode == 0, done.stderr
        return done.stdout, [line for line in done.stderr.splitlines() if "CONSOLE" in line]

    return opened


@pytest.fixture(scope="module")
def opened(path, browser, tmp_path_factory):
    folder = tmp_path_factory.mktemp("browser")
    probed = path.read_text(encoding="utf-8").replace("</body>", PROBE)
    (folder / "probed.html").write_text(probed, encoding="utf-8")
    dom, console = browser(f"{folder / 'probed.html'}#t=12.1", folder / "profile", MOUSE)
    assert console == []
    attribute = re.search(r'data-seen="([^"]*)"', dom)
    assert attribute, "the page was not drawn"
    seen = json.loads(html.unescape(attribute[1]))
    assert "error" not in seen, seen["error"]
    return seen


def test_a_browser_draws_every_figure(opened, page):
    figures = [*page.data["figures"], *(f"{n}-1" for n in page.data["scenarios"][0]["figures"])]
    assert set(opened["colours"]) == set(figures)
    assert len(figures) == 9
    assert min(opened["colours"].values()) > 100  # an empty canvas has one
    assert 'id="no-figures" hidden' in page_module._resource("page.html")


def test_a_browser_loads_nothing(opened):
    assert opened["outside"] == []


def test_the_browser_s_path_has_equal_scales(opened):
    across, up = opened["scales"]
    assert across == pytest.approx(up, rel=1e-12)


def test_a_name_in_the_legend_toggles_its_lines_in_both_panels(opened):
    assert opened["hidden"] == [[], ["feedback", "feedback"], []]


def test_a_pointer_shows_the_values_at_its_time(opened, run):
    time = float(re.match(r"time([0-9.]+) s", opened["tip"])[1])
    (k,) = np.flatnonzero(np.isclose(run.t, time))
    for name, column in (("feedforward", "tau_ref"), ("feedback", "tau_fb"), ("limited", "tau")):
        value = float(run.columns[f"{column}_left"][k])
        shown = re.search(rf"{name}(\S+?) N m", opened["tip"])[1]
        assert float(shown.replace("\N{MINUS SIGN}", "-")) == pytest.approx(value, rel=1e-3)


def test_a_drag_draws_a_part_larger(opened, run):
    (whole, part) = opened["zoom"]
    assert whole == [0, pytest.approx(run.t[-1], abs=0.3)]
    assert 0 < part[0] < part[1] < whole[1]
    assert part[1] - part[0] < 0.25 * whole[1]


@pytest.mark.parametrize(("step", "least", "most"), [("opened", 60, 61), ("moved", 50, 50)])
def test_the_slider_moves_the_robot(step, least, most, opened, page, run):
    seen = opened[step]
    k = seen["slider"]
    assert least <= k <= most
    x, y, theta = run.pose[k]
    body = np.array([seen["x"][:-1], seen["y"][:-1]], dtype=float)
    assert_allclose(body[:, :-1].mean(axis=1), [x, y], atol=1e-4)
    front = body[:, 0] - [x, y]
    assert_allclose(np.hypot(*front), page.data["scenarios"][0]["robot_radius"], rtol=1e-3)
    assert abs(np.sin((np.arctan2(*front[::-1]) - theta) / 2)) < 1e-3
    assert seen["marks"] == pytest.approx([run.t[k]] * 2)
    assert seen["now"].startswith(f"t {run.t[k]:.4g} s")
    assert seen["button"] == "Play"


def test_the_button_plays(opened):
    before, playing = opened["moved"], opened["playing"]
    assert playing["button"] == "Pause"
    assert before["slider"] < playing["slider"]
    assert min(playing["marks"]) > max(before["marks"])


# A window is 500 pixels wide at least; a frame in it may be as narrow as a phone.
FRAME = """<iframe src="page.html" style="width: 360px; height: 900px"></iframe>
<script>
window.onmessage = ({ data }) => { document.body.dataset.seen = JSON.stringify(data); };
</script>"""
IN_FRAME = """
<script>
window.report.then(async ({ drawn: [drawn] }) => {
  await new Promise((done) => setTimeout(done, 500));
  const wide = (e) => e.getBoundingClientRect().right > innerWidth || e.scrollWidth > e.clientWidth;
  const parts = [...document.querySelectorAll("table, .scroll, .cards, .margin, .plot, .now")];
  const [plot] = drawn.path.plots;
  parent.postMessage({
    width: innerWidth,
    page: document.documentElement.scrollWidth,
    parts: parts.length,
    wide: parts.filter(wide).map((e) => `${e.id} ${e.className} ${e.textContent.slice(0, 40)}`),
    paper: getComputedStyle(document.body).backgroundColor,
    plot: [plot.background_fill_color, plot.border_fill_color],
    frame: plot.inner_width,
  }, "*");
});
</script>
</body>"""


@pytest.mark.parametrize(
    ("flags", "paper", "plot"),
    [([], "rgb(255, 255, 255)", "#ffffff"), ([DARK], "rgb(22, 24, 28)", "#16181c")],
    ids=["light", "dark"],
)
def test_a_phone_shows_every_column_in_the_colours_of_its_theme(
    flags, paper, plot, path, browser, tmp_path
):
    text = path.read_text(encoding="utf-8").replace("</body>", IN_FRAME)
    (tmp_path / "page.html").write_text(text, encoding="utf-8")
    (tmp_path / "frame.html").write_text(FRAME)
    dom, console = browser(tmp_path / "frame.html", tmp_path / "profile", *flags)
    assert console == []
    seen = json.loads(html.unescape(re.search(r'data-seen="([^"]*)"', dom)[1]))
    assert (seen["width"], seen["page"], seen["wide"]) == (360, 360, [])
    assert seen["parts"] > 15
    assert 200 < seen["frame"] < 360
    assert (seen["paper"], seen["plot"]) == (paper, [plot, plot])


def test_the_verdict_stands_at_the_top_in_its_colour(tmp_path):
    unstable = tune(rng=1, maxfev=600)
    nfopidn.report(unstable, tmp_path / "red.html")
    text = (tmp_path / "red.html").read_text()
    assert unstable.verdict.colour == "red"
    assert '<p class="verdict red">V' + html.escape(unstable.verdict.line[1:]) + ".</p>" in text
    assert "Cost E, " not in text


def test_a_robust_result_tells_its_family_and_its_robot(tmp_path):
    found = nfopidn.tune(rng=1, maxfev=400)
    nfopidn.report(found, tmp_path / "robust.html")
    text = (tmp_path / "robust.html").read_text()
    assert f'<p class="verdict {found.verdict.colour}">' in text
    assert f"Cost E, {len(found.family)} scenarios" in text
    assert text.count("of the robot that the gains are made for") == 4
    assert "None" not in Parsed(text).text
