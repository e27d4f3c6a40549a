"""The workflows of .github: what they build is what pyproject.toml says, and who may publish."""

import re
import shlex
import tomllib

import pytest
import yaml
from conftest import REPOSITORY

WORKFLOWS = {path.stem: path for path in (REPOSITORY / ".github" / "workflows").glob("*.yml")}
PROJECT = tomllib.loads((REPOSITORY / "pyproject.toml").read_text())
VERSIONS = ["3.11", "3.12", "3.13", "3.14"]


def workflow(name):
    return yaml.safe_load(WORKFLOWS[name].read_text())


def steps(name):
    return [step for job in workflow(name)["jobs"].values() for step in job["steps"]]


@pytest.mark.parametrize("name", WORKFLOWS)
def test_a_workflow_may_only_read_but_for_the_job_that_publishes(name):
    document = workflow(name)
    assert document["permissions"] == {"contents": "read"}
    allowed = {key for key, job in document["jobs"].items() if "permissions" in job}
    assert allowed <= {"publish"}
    for step in steps(name):
        if step.get("uses", "").startswith("actions/checkout@"):
            assert step["with"]["persist-credentials"] is False


def test_continuous_integration_runs_every_test_with_every_compiler():
    jobs = workflow("ci")["jobs"]
    assert "./dev test" in [step.get("run") for step in jobs["test"]["steps"]]
    matrix = [entry for job in jobs.values() for entry in job["strategy"]["matrix"]["include"]]
    compilers = {entry["cxx"] for entry in matrix}
    assert {"g++-12", "g++-13", "g++-14"} <= compilers
    assert any(name.startswith("clang++") for name in compilers)
    assert {entry["python"] for entry in matrix if "python" in entry} == set(VERSIONS)


def test_wheels_are_built_for_every_python_that_is_supported():
    classifiers = PROJECT["project"]["classifiers"]
    named = [re.fullmatch(r"Programming Language :: Python :: (3\.\d+)", it) for it in classifiers]
    assert [it[1] for it in named if it] == VERSIONS
    settings = PROJECT["tool"]["cibuildwheel"]
    assert settings["build"] == [f"cp{version.replace('.', '')}-*" for version in VERSIONS]
    assert PROJECT["project"]["requires-python"] == f">={VERSIONS[0]}"


def test_wheels_are_built_for_every_system():
    systems = workflow("wheels")["jobs"]["wheels"]["strategy"]["matrix"]["os"]
    assert {re.sub(r"-\d[\d.]*", "", name) for name in systems} == {
        *["ubuntu", "ubuntu-arm", "macos", "macos-intel"]
    }


def test_wheels_are_published_for_a_tag_and_by_trust_alone():
    job = workflow("wheels")["jobs"]["publish"]
    assert set(job["needs"]) == {"sdist", "wheels"}
    assert "startsWith(github.ref, 'refs/tags/v')" in job["if"]
    assert job["permissions"]["id-token"] == "write"
    assert "secrets." not in WORKFLOWS["wheels"].read_text()


@pytest.mark.parametrize("key", ["before-all", "test-command"])
def test_what_cibuildwheel_runs_is_there(key):
    words = shlex.split(PROJECT["tool"]["cibuildwheel"][key])
    files = [word.removeprefix("{project}/") for word in words if word.startswith("{project}/")]
    assert files
    assert all((REPOSITORY / file).is_file() for file in files)


def test_every_artifact_that_is_published_has_a_name_that_is_fetched():
    names = [
        step["with"]["name"]
        for step in steps("wheels")
        if step.get("uses", "").startswith("actions/upload-artifact@")
    ]
    (fetched,) = (
        step["with"]["pattern"]
        for step in steps("wheels")
        if step.get("uses", "").startswith("actions/download-artifact@")
    )
    assert names
    assert all(name.startswith(fetched.removesuffix("*")) for name in names)
