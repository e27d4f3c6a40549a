"""docs/embedding.md: its commands run, and its code compiles, for the host and for the board."""

import re
import shlex

import pytest
from nfopidn import Controller, Scenario
from nfopidn.commands.entry import main
from test_export import CORTEX, STRICT, compiled, compiler

CPP = ["-std=c++17", "-Wall", "-Wextra", "-Wpedantic", "-Wshadow", "-Wdouble-promotion", "-Werror"]


@pytest.fixture(scope="module")
def text(repository):
    return (repository / "docs" / "embedding.md").read_text()


def blocks(text, language):
    return re.findall(rf"^```{language}\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)


@pytest.fixture(scope="module")
def firmware(text, tmp_path_factory, sim):
    """What the page's commands export, into a folder of their own."""
    folder = tmp_path_factory.mktemp("embedding")
    commands = [line.partition(" #")[0] for line in blocks(text, "sh")[0].splitlines()]
    (scenario,) = (line for line in commands if "nfopidn_sim" in line)
    assert sim(*shlex.split(scenario)[1:], cwd=folder).returncode == 0
    assert Scenario.load(folder / "scenario.json").trajectory.name == "circle"
    Controller.tuned_nominal().save(folder / "controller.json")  # the search takes too long here
    exports = [shlex.split(line)[1:] for line in commands if "nfopidn export" in line]
    assert len(exports) == 2
    for words in exports:
        assert main([str(folder / w) if w.endswith((".json", "/")) else w for w in words]) == 0
    return folder / "firmware"


def test_the_page_has_code_in_both_languages(text):
    assert len(blocks(text, "cpp")) >= 5
    assert len(blocks(text, "c")) >= 3


@pytest.mark.parametrize("program", ["g++", "clang++", "arm-none-eabi-g++"])
def test_cpp(program, text, firmware, repository):
    for number, code in enumerate(blocks(text, "cpp")):
        source = firmware / f"block{number}.cpp"
        source.write_text(code)
        board = [*CORTEX, "-fno-exceptions", "-fno-rtti"] if program.startswith("arm") else []
        includes = ["-I", repository / "cpp/include", "-I", firmware]
        compiled([compiler(program), *CPP, *board, *includes, "-fsyntax-only", source])


@pytest.mark.parametrize("program", ["gcc", "clang", "arm-none-eabi-gcc"])
def test_c(program, text, firmware):
    for number, code in enumerate(blocks(text, "c")):
        source = firmware / f"block{number}.c"
        source.write_text(code)
        board = CORTEX if program.startswith("arm") else []
        compiled([compiler(program), *STRICT, *board, "-I", firmware, "-fsyntax-only", source])


def test_links_lead_somewhere(text, repository):
    for target in re.findall(r"\]\(([^)#]+)", text):
        assert (repository / "docs" / target).exists(), target
    headings = {
        re.sub(r"[^\w -]", "", line[2:].strip().lower()).replace(" ", "-")
        for line in text.splitlines()
        if line.startswith("#")
    }
    for anchor in re.findall(r"\]\(#([^)]+)\)", text):
        assert anchor in {heading.strip("-") for heading in headings}, anchor
