"""The hand-kept stub _core.pyi against the module."""

import ast
import inspect
from pathlib import Path

import nfopidn
import pytest
from nfopidn import _core

STUB = ast.parse((Path(nfopidn.__file__).parent / "_core.pyi").read_text())
NOT_IN_STUBS = {"__doc__", "__module__", "__init__", "__repr__", "__getstate__", "__setstate__"}


def public(body):
    """Definitions by name: classes, functions and annotated names that have no underscore."""
    found = {}
    for node in body:
        name = getattr(node, "name", None) or getattr(getattr(node, "target", None), "id", None)
        if name and (not name.startswith("_") or name.startswith("__")):
            found[name] = node
    return found


MODULE = public(STUB.body)
# What tune(), bfoa(), nfopidn.stability, nfopidn.fractional and the commands' files are made of:
# they are documented, these are not.
INNER = {
    "annotate",
    "read_table",
    "column_meaning",
    "DrawnRuns",
    "drawn_parameters",
    "check_options",
    "check_sample_time",
    "check_writable",
    "StandardArithmetic",
    "checkpoint_problem",
    "family_cap",
    "read_text",
    "run_simulate",
    "StopIf",
    "write_file",
    "analyse_loop",
    "loop_jacobians",
    "series_weights",
    "rule_scale",
    "gain_factors",
    "continued_fraction",
    "oustaloup",
    "SampleFilter",
    "final_errors",
    "linear_plant",
    "METHODS",
    "UNLIMITED",
    "STAGE_SUFFIXES",
    "LEAST_SPEED_SCALE",
    "CostFunction",
    "ParameterSpace",
    "search_function",
    "plan_stages",
    "run_plan",
    "search_rival",
    "FIGURES",
    "SETTLED_WITHIN",
    "measure_runs",
    "measure_draws",
    "family_mean",
    "settling_time",
    "torque_deviation",
    "from_unit",
    "to_unit",
    "play",
    "score_rows",
    "noise_rows",
    "metric_fields",
    "structure",
    "parameter_bounds",
    "default_options",
}
CLASSES = {
    name: public(node.body) for name, node in MODULE.items() if isinstance(node, ast.ClassDef)
}


def decorators(node):
    return {ast.unparse(decorator) for decorator in node.decorator_list}


def parameters(node):
    """Name and default of each parameter of a definition in the stub, self left out."""
    arguments = node.args
    names = [argument.arg for argument in arguments.posonlyargs + arguments.args]
    defaults = [None] * (len(names) - len(arguments.defaults)) + arguments.defaults
    found = {
        name: default and ast.unparse(default)
        for name, default in zip(names, defaults, strict=True)
    }
    found.pop("self", None)
    assert not arguments.vararg
    assert not arguments.kwonlyargs
    if arguments.kwarg:
        found["**" + arguments.kwarg.arg] = None
    return found


def documented(text):
    """The same from a text signature."""
    return parameters(ast.parse(f"def f{text}: ...".replace("$self", "self")).body[0])


def text_signature(member):
    return getattr(member, "__func__", member).__text_signature__


def test_the_module_has_the_names_of_the_stub():
    runtime = {name for name in dir(_core) if not name.startswith("_")} | {"__version__"}
    assert set(MODULE) == runtime
    assert runtime - INNER <= set(nfopidn.__all__)
    assert runtime >= INNER


@pytest.mark.parametrize("name", CLASSES)
def test_a_class_has_the_members_of_the_stub(name):
    runtime = {
        member
        for member in vars(getattr(_core, name))
        if member.startswith("__") or not member.startswith("_")
    }
    assert set(CLASSES[name]) - NOT_IN_STUBS == runtime - NOT_IN_STUBS
    assert ("__init__" in CLASSES[name]) == (getattr(_core, name).__text_signature__ is not None)


MEMBERS = [
    pytest.param(name, member, id=f"{name}.{member}")
    for name, members in CLASSES.items()
    for member in members
    if not member.startswith("__")
]


@pytest.mark.parametrize(("name", "member"), MEMBERS)
def test_a_member_is_of_its_kind(name, member):
    runtime = inspect.getattr_static(getattr(_core, name), member)
    stub = decorators(CLASSES[name][member])
    assert isinstance(runtime, property) == ("property" in stub)
    assert isinstance(runtime, staticmethod) == ("staticmethod" in stub)
    if isinstance(runtime, property):
        assert runtime.fset is None


def literal(text):
    """A default as a value; lists and tuples alike. What is no literal, as text."""
    try:
        value = ast.literal_eval(text)
    except ValueError:
        return text
    return list(value) if isinstance(value, tuple) else value


CALLABLES = {"simulate": (MODULE["simulate"], _core.simulate)}
for name, members in CLASSES.items():
    owner = getattr(_core, name)
    if "__init__" in members:
        CALLABLES[name] = (members["__init__"], owner)
    for member, node in members.items():
        if not member.startswith("__") and "property" not in decorators(node):
            CALLABLES[f"{name}.{member}"] = (node, getattr(owner, member))


@pytest.mark.parametrize(("node", "runtime"), CALLABLES.values(), ids=CALLABLES.keys())
def test_a_signature_is_the_stub_s(node, runtime):
    stub = parameters(node)
    real = documented(text_signature(runtime))
    assert list(stub) == list(real)
    for parameter, default in stub.items():
        if default == "...":  # no literal
            assert real[parameter] == "Robot()"
        elif default is None or real[parameter] is None:
            assert default is real[parameter]
        else:
            assert literal(default) == literal(real[parameter])


def fields(name):
    """The keys of a TypedDict of the stub, inherited ones included."""
    node = next(n for n in STUB.body if getattr(n, "name", "") == name)
    own = [item.target.id for item in node.body if isinstance(item, ast.AnnAssign)]
    return set(own).union(*(fields(base.id) for base in node.bases if base.id != "TypedDict"))


def arguments_of(cls):
    return set(documented(cls.__text_signature__))


def test_what_may_be_changed_is_what_may_be_given():
    scenario = arguments_of(nfopidn.Scenario)
    controller = arguments_of(nfopidn.Controller)
    path = set(documented(nfopidn.Trajectory.ranunculoid.__text_signature__))
    assert fields("_RobotChanges") == arguments_of(nfopidn.Robot)
    assert fields("_ScenarioChanges") == scenario
    assert fields("_PublishedScenarioChanges") == scenario | path
    assert fields("_ControllerChanges") == controller
    assert fields("_PublishedControllerChanges") == controller - {"memory"}
    assert fields("_Structure") == controller - {"gains", "alpha", "sigma"}


def choices(message):
    """The choices that an error message lists."""
    return set(ast.literal_eval(f"[{message.split('one of ')[1]}]"))


@pytest.mark.parametrize(
    ("alias", "call", "name"),
    [
        ("_Heading", nfopidn.Trajectory.line, "heading"),
        ("_Derivatives", nfopidn.Trajectory.line, "derivatives"),
        ("_Integrator", nfopidn.Scenario.published, "integrator"),
        ("_Form", nfopidn.Controller.published, "form"),
        ("_Activation", nfopidn.Controller.published, "activation"),
        ("_Frame", nfopidn.Controller.published, "frame"),
        ("_Generator", nfopidn.Controller.published, "generator"),
        ("_Lateral", nfopidn.Controller.published, "lateral"),
        ("_AntiWindup", nfopidn.Controller.published, "anti_windup"),
        ("_Net", nfopidn.Controller.published, "net"),
    ],
)
def test_literals_are_the_choices(alias, call, name):
    node = next(n for n in STUB.body if getattr(getattr(n, "target", None), "id", "") == alias)
    words = {item.value for item in ast.walk(node.value) if isinstance(item, ast.Constant)}
    with pytest.raises(ValueError, match="one of") as caught:
        call(**{name: "?"})
    assert words == choices(str(caught.value))
