"""The tools that build the documentation: docs/site. `./dev docs` runs them on the whole."""

import ast
import dataclasses
import importlib.util
import inspect
import os
import re
import sys
import textwrap

import nfopidn
import pytest
from conftest import REPOSITORY

SITE = REPOSITORY / "docs" / "site"


def load(name):
    """Import a tool; they find each other in their own folder."""
    sys.path.insert(0, str(SITE))
    try:
        spec = importlib.util.spec_from_file_location(name, SITE / f"{name}.py")
        module = importlib.util.module_from_spec(spec)
        sys.modules[name] = module  # dataclasses look there
        spec.loader.exec_module(module)
    finally:
        sys.path.remove(str(SITE))
    return module


check = load("check")
comment_filter = load("comment_filter")
cpp_reference = load("cpp_reference")
equations = load("equations")
python_reference = load("python_reference")
settings_reference = load("settings_reference")
source_pages = load("source_pages")
build = load("build")


def dedent(text):
    return textwrap.dedent(text).lstrip("\n")


# --- comments for Doxygen ---------------------------------------------------------------------


def filtered(text):
    return comment_filter.filtered("// L0. A header.\n#pragma once\n\n" + dedent(text))


def test_a_comment_above_a_declaration_documents_it():
    text = filtered("""
        namespace nfopidn {
        // Adds.
        // In order.
        constexpr int add(int a, int b);
        }
    """)
    assert "/// Adds.\n/// In order.\nconstexpr" in text
    assert text.startswith("/// @file\n/// L0. A header.\n#pragma once\n")


def test_a_comment_apart_from_a_declaration_stays():
    text = filtered("// Apart.\n\nstruct A {};\n// Before the end.\n#endif\n")
    assert "\n// Apart.\n" in text
    assert "\n// Before the end.\n" in text


@pytest.mark.parametrize(
    "opening",
    [
        "int f() {",
        "template <class T> int f() {",
        "constexpr int numbers[] = {",
        "template <class Scalar, class = std::enable_if_t<true>>\nint f(struct A a,\n int b) {",
    ],
)
def test_a_comment_in_a_body_stays(opening):
    text = filtered(f"{opening}\n  // Why.\n  int x = 1;  // [m]\n}};\n")
    assert "  // Why.\n  int x = 1;  // [m]\n" in text


@pytest.mark.parametrize(
    "opening",
    [
        "struct A {",
        "template <class T>\nclass A : public B<sizeof(int)> {",
        "namespace a {\nenum class E : unsigned char {",
        'extern "C" {',
    ],
)
def test_a_comment_behind_a_member_documents_it(opening):
    text = filtered(
        f'{opening}\n  first,   // [m]\n           // and on\n  s = "// no",\n  }}; // end\n'
    )
    assert "  first,   ///< [m]\n           ///< and on\n" in text
    assert 's = "// no",\n' in text
    assert "}; // end" in text


def test_a_comment_is_text_to_doxygen():
    text = filtered('// a < b & `c_d` @param \\x #y "z" 5 %\nint f();\n')
    assert '/// a \\< b \\& <tt>c_d</tt> \\@param \\\\x \\#y \\"z\\" 5 \\%\n' in text


def test_lines_that_are_set_in_are_formulas():
    text = filtered("// The law:\n//   a = b < c\n// with c < d.\nint f();\n")
    told = "/**\n The law:\n@verbatim\na = b < c\n@endverbatim\n with c \\< d.\n\n*/\nint f();\n"
    assert told in text
    text = comment_filter.filtered("// A file.\n//   a = b\n#pragma once\n")
    assert text.startswith("/**\n@file\n A file.\n@verbatim\na = b\n@endverbatim\n")


def test_the_headers_lose_no_line_of_code():
    """Without comments, of either kind, a header is the same."""

    def code(text):
        text = re.sub(r"^ */\*\*$.*?^ *\*/$", "", text, flags=re.MULTILINE | re.DOTALL)
        lines = [comment_filter.split_comment(line)[0].rstrip() for line in text.splitlines()]
        return [line for line in lines if line]

    for header in cpp_reference.headers(REPOSITORY):
        source = (REPOSITORY / cpp_reference.INCLUDE / header).read_text()
        assert code(comment_filter.filtered(source)) == code(source), header


def test_macros_of_attributes_are_expanded():
    source = "#define NFOPIDN_A [[gnu::x]] inline\n#define NFOPIDN_B [[y]]\n#define NFOPIDN_C 1\n"
    assert cpp_reference.macros([source]) == ["NFOPIDN_A=inline", "NFOPIDN_B="]


def test_every_header_has_a_page_and_stands_in_the_index():
    pages = cpp_reference.pages(REPOSITORY)
    assert len(pages) == len(cpp_reference.headers(REPOSITORY)) + 1
    index = pages["cpp/index.rst"]
    for name in set(pages) - {"cpp/index.rst"}:
        page = name.removeprefix("cpp/").removesuffix(".rst")
        assert f"<{page}>`" in index
    assert cpp_reference.summary("// L2. The law, once. More.\n#pragma once") == "The law, once."


# --- where is it? -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "cited"),
    [
        ("eq. 34", [34]),
        ("eqs. 31-36,", [31, 32, 33, 34, 35, 36]),
        ("(eqs. 5, 6, 9 and 10):", [5, 6, 9, 10]),
        ("eqs. 5 to 7", [5, 6, 7]),
        ("eqs.\n// 16-19,\n// 25", [16, 17, 18, 19, 25]),
        ("Eq. 8, its sign", [8]),
        ("eq. 5.12", []),
        ("IEEE ICRA 1990, eq. 7:", []),
        ("IEEE ICRA 1990,\n// eq. 7:", []),
        ("eq. 45", []),  # the paper has 44
        ("seq. 3", []),
    ],
)
def test_citations(text, cited):
    assert [number for _, own in equations.citations(text) for number in own] == cited


def test_a_citation_has_its_line():
    assert equations.citations("a\nb eq. 3\neq. 4") == [(2, [3]), (3, [4])]


def test_only_prose_cites():
    assert "eq. 3" not in equations.cpp_prose('f("eq. 3");')
    assert equations.cpp_prose('f("//");\nint x; // eq. 3') == "\n// eq. 3"
    prose = equations.python_prose('"""Eq. 1."""\nx = "eq. 2"\ny = 1  # eq. 3\n')
    assert equations.citations(prose) == [(1, [1]), (3, [3])]


def test_the_places_are_in_the_files():
    found = equations.search(REPOSITORY, ["cpp", "python", "tests"])
    assert {4, 8, 25, 33, 34, 38, 41} <= set(found)
    for number, places in found.items():
        for place in places:
            lines = (REPOSITORY / place.path).read_text().splitlines()
            near = "\n".join(lines[place.line - 1 : place.line + 1])
            assert re.search(r"[Ee]qs?\.", near), (number, place)


def test_the_law_is_found_in_code_text_and_tests():
    """The equations of the controller and the cost: each is built, explained and tested."""
    page, cited = equations.page(REPOSITORY)
    rows = {}
    for line in page.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if len(cells) == 4 and cells[0][:1].isdigit():
            rows |= dict.fromkeys(equations.numbers(cells[0]), cells[1:])
    assert sorted(rows) == list(equations.EQUATIONS)
    for number in (4, 5, 6, 7, 8, 25, *range(31, 42), 44):
        assert all(rows[number]), number
    assert all((REPOSITORY / path).is_file() for path in cited)


def test_a_section_is_told_by_its_heading():
    text = "# A\n\n## Law (eqs. 1-2)\n\nBy eq. 7.\n```\n# eq. 9\n```\n"
    assert equations.sections(text) == {
        1: [("Law", "law-eqs-1-2")],
        2: [("Law", "law-eqs-1-2")],
        7: [("Law", "law-eqs-1-2")],
    }


# --- settings ---------------------------------------------------------------------------------

SETTINGS = dict(settings_reference.python_settings(nfopidn))


@pytest.mark.parametrize("name", ["Robot", "Scenario", "Controller"])
def test_every_keyword_is_a_setting(name):
    """The table, read from the docstring, against the signature."""
    told = {setting.name for setting in SETTINGS[f"nfopidn.{name}"]}
    signature = getattr(nfopidn, name).__text_signature__.replace("$self", "self")
    taken = ast.parse(f"def f{signature}: ...").body[0].args
    names = {argument.arg for argument in taken.posonlyargs + taken.args + taken.kwonlyargs}
    assert told == names - {"self", "trajectory", "robot", "rng"}


def test_a_setting_in_words():
    (found,) = (s for s in SETTINGS["nfopidn.Robot"] if s.name == "mass")
    assert (found.unit, found.allowed, found.default) == ("kg", "[1e-06, 1e+06]", "11.5")
    (found,) = (s for s in SETTINGS["nfopidn.Controller"] if s.name == "form")
    assert found.allowed == '"positional", "incremental"'
    assert found.default == "'positional'"
    (found,) = (s for s in SETTINGS["nfopidn.Controller"] if s.name == "sample_time")
    assert (found.unit, found.allowed, found.default) == ("s", "greater than 0", "None")


def test_settings_have_the_executable_s_options(executable):
    option = settings_reference.sim_options(settings_reference.executable_help(executable))
    for name in ("Robot", "Scenario", "Controller", "Trajectory.ranunculoid"):
        settings = SETTINGS[f"nfopidn.{name}"]
        assert all(option(setting.text) for setting in settings), name
    mass = next(s for s in SETTINGS["nfopidn.Robot"] if s.name == "mass")
    assert option(mass.text) == "--mass"
    pose = next(s for s in SETTINGS["nfopidn.Scenario"] if s.name == "initial_pose")
    assert option(pose.text) == "--initial-pose, --pose"


def test_options_of_searches_are_read_from_their_structs():
    source = dedent("""
        struct SwarmOptions {
          int cells = 64;
          double reach = 0.5;
          template <class V> static constexpr void fields(V&& visit) {
            visit(field("cells", &S::cells, "", between(4, 10), "most "
                        "\\"cells\\""));
            visit(field("reach", &S::reach, "m", any_number(), "how far"));
          }
        };
    """)
    first, second = settings_reference.struct_settings(source)["SwarmOptions"]
    assert (first.text, first.allowed, first.default) == ('most "cells"', "[4, 10]", "64")
    assert (second.unit, second.allowed, second.default) == ("m", "", "0.5")


def test_the_commands_are_told(executable):
    page = settings_reference.commands_page(executable, "the executable's help")
    assert {
        "nfopidn simulate",
        "nfopidn tune",
        "nfopidn export",
        "nfopidn compare",
        "nfopidn report",
    } <= set(re.findall(r"^## (.*)$", page, re.MULTILINE))
    assert "the executable's help" in page


# --- the Python reference ---------------------------------------------------------------------

PUBLIC = python_reference.public_objects()


def test_every_public_name_has_a_page():
    pages = python_reference.pages()
    assert {"nfopidn.tune", "nfopidn.plot.overview", "nfopidn.stability.loop"} <= set(PUBLIC)
    for name, thing in PUBLIC.items():
        short = name.rpartition(".")[2]
        assert f".. auto{python_reference.kind(thing)}:: {short}\n" in pages[f"api/{name}.rst"]
        assert any(f"   {short} <{name}>" in page for page in pages.values())


@pytest.mark.parametrize("name", PUBLIC)
def test_a_public_name_is_documented(name):
    """Itself, its public members, and the fields of a dataclass."""
    thing = PUBLIC[name]
    if not (inspect.isclass(thing) or inspect.isroutine(thing)):
        return
    text = inspect.getdoc(thing)
    assert text
    if dataclasses.is_dataclass(thing):
        fields = {field.name for field in dataclasses.fields(thing) if field.repr}
        assert not {field for field in fields if not re.search(rf"\b{field}\b", text)}
    if inspect.isclass(thing):
        for member, value in vars(thing).items():
            if not member.startswith("_") and (callable(value) or isinstance(value, property)):
                assert inspect.getdoc(getattr(thing, member, value)), member


@pytest.fixture(scope="module")
def conf():
    before = os.environ.get("NFOPIDN_DOCS")
    os.environ["NFOPIDN_DOCS"] = "build/docs"
    module = load("conf")
    if before is None:
        del os.environ["NFOPIDN_DOCS"]
    return module


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("the peak |V_r| of w_c", r"the peak \|V_r\| of w_c"),
        ("a*b and w_", r"a\*b and w\_"),
        ("as `tune` does", "as `tune` does"),
        ("the `lateral` channel", "the ``lateral`` channel"),
        ("``x|y``", "``x|y``"),
        ("see `nfopidn.plot.overview`", "see `nfopidn.plot.overview`"),
    ],
)
def test_docstrings_are_plain_text(conf, text, expected):
    lines = [text]
    conf.plain_docstring(None, "function", "nfopidn.bfoa", None, None, lines)
    assert lines == [expected]


def test_tables_in_docstrings_stay(conf):
    table = ["=== ====", "`a` b|c", "=== ====", "d|e"]
    lines = list(table)
    conf.plain_docstring(None, "module", "nfopidn.plot", None, None, lines)
    assert lines == [*table[:3], r"d\|e"]


# --- links and pages --------------------------------------------------------------------------


def test_links_lead_to_the_site_s_pages():
    links = build.Links(set(build.markdown_pages()))
    text = dedent("""
        [a](theory.md#heading) [b](../bench/README.md) [c](../examples/tune.py)
        [d](../CITATION.cff) [e](../examples/firmware)
        [f](images/overview.png) [g](#here) [h](../README.md) [i](https://example.org)
        ```
        [no](nowhere.md)
        ```
    """)
    assert links.rewritten("docs/tuning.md", text) == dedent("""
        [a](theory.md#heading) [b](bench/README.md) [c](gallery/tune.rst)
        [d](source/CITATION.cff.rst) [e](source/examples/firmware/folder.rst)
        [f](images/overview.png) [g](#here) [h](index.md) [i](https://example.org)
        ```
        [no](nowhere.md)
        ```
    """)
    assert links.broken == []
    assert links.files == {"CITATION.cff"}
    assert links.folders == {"examples/firmware"}


def test_a_link_to_nothing_is_told():
    links = build.Links(set())
    links.rewritten("bench/README.md", "[a](nowhere.md)")
    assert links.broken == ["bench/README.md: nowhere.md"]


def test_the_repository_s_links_lead_somewhere():
    pages = build.markdown_pages()
    links = build.Links(set(pages))
    for path, text in pages.items():
        links.rewritten(path, text)
    assert links.broken == []


def test_every_page_is_in_the_sidebar():
    names = {build.staged(path).removesuffix(".md") for path in build.markdown_pages()}
    told = build.contents(names | {"a_new_guide"})
    for name in names | {"a_new_guide", "api/index", "cpp/index", "settings", "equations"}:
        assert re.search(rf"^(.* <)?{re.escape(name)}>?$", told, re.MULTILINE), name


def test_a_source_page_has_a_place_for_each_line():
    path = "tests/py/conftest.py"
    pages = source_pages.page(REPOSITORY, path)
    listing = pages[f"source/{path}.listing"]
    count = len((REPOSITORY / path).read_text().splitlines())
    assert f'id="line-{count}"' in listing
    assert f'id="line-{count + 1}"' not in listing


# --- what is checked of the built pages -------------------------------------------------------


@pytest.fixture
def site(tmp_path):
    """A site of two pages without faults."""
    (tmp_path / "style.css").write_text('a { src: url("font.woff2"); }')
    (tmp_path / "picture.png").write_bytes(b"x")
    (tmp_path / "index.html").write_text(
        '<link rel="stylesheet" href="style.css"><img src="picture.png">'
        '<a href="other.html#place">there</a> <a href="https://example.org">out</a>'
    )
    (tmp_path / "other.html").write_text('<h1 id="place">x</h1><dt id="nfopidn.tune">y</dt>')
    return tmp_path


def test_a_site_without_faults(site):
    assert check.faults(site, ["nfopidn.tune"]) == []


@pytest.mark.parametrize(
    "text",
    [
        '<script src="https://example.org/x.js"></script>',
        '<script src="//example.org/x.js"></script>',
        '<link rel="preload stylesheet" href="http://example.org/x.css">',
        '<img src="picture.png" srcset="picture.png 1x, https://example.org/x.png 2x">',
        '<iframe src="https://example.org"></iframe>',
        '<p style="background: url(https://example.org/x.png)"></p>',
        "<style>@import 'https://example.org/x.css';</style>",
    ],
)
def test_what_is_loaded_by_the_network_is_a_fault(site, text):
    (site / "other.html").write_text((site / "other.html").read_text() + text)
    assert len(check.faults(site, [])) == 1


def test_a_style_sheet_that_loads_is_a_fault(site):
    (site / "style.css").write_text("@font-face { src: url(https://example.org/x.woff2); }")
    assert check.faults(site, []) == ["style.css loads https://example.org/x.woff2"]


@pytest.mark.parametrize(
    ("link", "fault"),
    [
        ("nowhere.html", "index.html links to nowhere.html"),
        ("other.html#nowhere", "index.html: no place other.html#nowhere"),
        ("#nowhere", "index.html: no place #nowhere"),
    ],
)
def test_a_link_that_leads_nowhere_is_a_fault(site, link, fault):
    (site / "index.html").write_text(f'<a href="{link}">x</a>')
    assert check.faults(site, []) == [fault]


def test_a_name_that_is_missing_is_a_fault(site):
    assert check.faults(site, ["nfopidn.tune", "nfopidn.bfoa"]) == ["nfopidn.bfoa has no entry"]


def test_no_site_is_a_fault(tmp_path):
    assert check.faults(tmp_path, []) == [f"no start page in {tmp_path}"]


def test_examples_have_titles_for_the_gallery():
    for path in sorted((REPOSITORY / "examples").glob("*.py")):
        lines = path.read_text().splitlines()
        assert lines[0] == '"""', path
        assert re.fullmatch("=+", lines[2]), path
        assert len(lines[1]) == len(lines[2]), path
        assert lines[3] == "", path
