"""Sphinx configuration of the documentation; build.py lays out the pages that it reads."""

import os
import re
import sys
import warnings
from importlib.util import find_spec
from pathlib import Path
from shutil import copytree, ignore_patterns
from typing import Any

os.environ["MPLBACKEND"] = "Agg"
# Sphinx imports matplotlib and others for the examples; what they deprecate is theirs to mend.
warnings.filterwarnings("ignore", category=DeprecationWarning)

import nfopidn

SITE = Path(__file__).resolve().parent
sys.path.insert(0, str(SITE))

import python_reference

OUTPUT = Path(os.environ["NFOPIDN_DOCS"])  # build.py's folder

PUBLIC = python_reference.public_objects()

project = "nfopidn"
version = release = nfopidn.__version__
language = "en"
root_doc = "index"
default_role = "py:obj"  # docstrings write names in single backticks
smartquotes_action = "D"  # dashes; quotes in docstrings are those of strings

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "sphinx.ext.mathjax",
    "sphinx_copybutton",
    "sphinx_design",
    "sphinx_gallery.gen_gallery",
    "breathe",
]
# Each header's page opens the same namespaces; nothing else is declared twice.
suppress_warnings = ["duplicate_declaration.cpp", "config.cache"]

myst_enable_extensions = ["dollarmath", "colon_fence", "deflist"]
myst_fence_as_directive = ["math"]  # as GitHub writes it
myst_heading_anchors = 5
# A console session that prints numbers alone is no program.
highlight_options = {"default": {"stripall": False}}

autosummary_generate = False  # python_reference.py writes the pages
autodoc_typehints = "none"  # the docstrings tell what is taken, with shapes and units
autodoc_member_order = "groupwise"
autodoc_default_options = {"members": True}
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_attr_annotations = False
napoleon_use_param = False  # several parameters in one entry stay one
napoleon_custom_sections = [("Attributes", "params_style")]  # not as links to names alike

breathe_projects = {"nfopidn": str(OUTPUT / "doxygen" / "xml")}
breathe_default_project = "nfopidn"
breathe_default_members = ("members",)

sphinx_gallery_conf = {
    "examples_dirs": str(OUTPUT / "examples"),
    "gallery_dirs": "gallery",
    "filename_pattern": r"\.py$",
    "abort_on_example_error": True,
    "download_all_examples": False,
    "show_memory": False,
    "show_signature": False,
    "remove_config_comments": True,
    "min_reported_time": 1e9,  # times differ from build to build
    "write_computation_times": False,
    "within_subsection_order": "sphinx_gallery.sorting.FileNameSortKey",
    "backreferences_dir": None,
    "notebook_extensions": set(),
    "matplotlib_animations": False,
    "image_scrapers": ("matplotlib",),
}

html_theme = "furo"
html_title = f"nfopidn {release}"
html_static_path = [str(SITE / "static")]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sphinx = False
html_show_copyright = False
html_theme_options = {
    "light_css_variables": {
        "color-brand-primary": "#0a5c7a",
        "color-brand-content": "#0a5c7a",
        "color-brand-visited": "#0a5c7a",
    },
    "dark_css_variables": {
        "color-brand-primary": "#6cc4e0",
        "color-brand-content": "#6cc4e0",
        "color-brand-visited": "#6cc4e0",
    },
}

# MathJax comes from a Python package and is read from the site itself.
mathjax_path = "mathjax/tex-chtml.js"
mathjax3_config = {"options": {"enableMenu": False}}


def copy_mathjax(app: Any, error: Exception | None) -> None:
    """Put MathJax's component for TeX and its fonts beside the pages."""
    if error is not None or app.builder.format != "html":
        return
    spec = find_spec("sphinx-mathjax-offline")
    assert spec is not None
    assert spec.origin is not None
    source = Path(spec.origin).parent / "static" / "mathjax"
    target = Path(app.outdir) / "_static" / "mathjax"
    others = ("sre", "a11y", "ui", "adaptors", "mml*", "node-main.js", "svg*", "tex-*-*.js")
    copytree(
        source,
        target,
        dirs_exist_ok=True,
        ignore=ignore_patterns(*others, "tex-svg*", "asciimath.js", "all-packages.js"),
    )


def known(name: str, context: str) -> bool:
    """Tell whether a name, seen from a documented object, is a public one."""
    places = context.split(".")
    for count in range(len(places), -1, -1):
        full = ".".join([*places[:count], name])
        if full in PUBLIC:
            return True
        owner, _, member = full.rpartition(".")
        if owner in PUBLIC and hasattr(PUBLIC[owner], member):
            return True
    return False


def plain_docstring(
    app: Any, what: str, name: str, thing: Any, options: Any, lines: list[str]
) -> None:
    """Make reStructuredText of docstrings that are plain text with `code` and tables in it."""
    table = False
    for i, line in enumerate(lines):
        if re.fullmatch(r"\s*=+(?: +=+)+\s*", line):
            table = not table
        elif not table:
            parts = re.split(r"(``[^`]+``|`[^`]+`)", line)
            parts[::2] = [re.sub(r"(\||(?<=\w)_(?!\w)|\*)", r"\\\1", part) for part in parts[::2]]
            parts[1::2] = [
                part if part.startswith("``") or known(part.strip("`"), name) else f"`{part}`"
                for part in parts[1::2]
            ]
            lines[i] = "".join(parts)
    if what in {"attribute", "property", "data"}:
        lines.insert(0, "")  # else napoleon takes what stands before a colon for a type


SIDEBARS: dict[tuple[str, str], str] = {}


def share_sidebar(app: Any, page: str, template: str, context: Any, doctree: Any) -> None:
    """Make the sidebar once a folder for pages that do not stand in it: to make it takes long."""
    standing = {name for names in app.env.toctree_includes.values() for name in names}
    if page in standing or page == root_doc or "toctree" not in context:
        return
    toctree = context["toctree"]

    def shared(**settings: Any) -> str:
        key = (page.rpartition("/")[0], repr(sorted(settings.items())))
        if key not in SIDEBARS:
            SIDEBARS[key] = toctree(**settings)
        return SIDEBARS[key]

    context["toctree"] = shared


def setup(app: Any) -> None:
    """Register what is above."""
    app.connect("html-page-context", share_sidebar, priority=400)  # before the theme's
    app.connect("build-finished", copy_mathjax)
    app.connect("autodoc-process-docstring", plain_docstring, priority=100)
