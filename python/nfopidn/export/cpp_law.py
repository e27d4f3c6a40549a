"""The law as a C++ header on the core's own."""

from __future__ import annotations

from nfopidn._core import Controller, Scenario
from nfopidn.export.design import (
    DECOUPLED,
    PAPER,
    Design,
    literal,
    origin_of,
    table,
    template,
)
from nfopidn.export.reference import cpp_reference_text
from nfopidn.robustness.verdict import Verdict


def law_text(
    controller: Controller,
    scenario: Scenario | None,
    design: Design,
    name: str,
    *,
    verdict: Verdict | None,
    reference: Scenario | None,
) -> str:
    """Write the header; with a table if `reference` is a scenario."""
    kind = {str(PAPER): "paper", str(DECOUPLED): "decoupled"}.get(str(design.allocation))
    choices = {
        "form": f"Form::{controller.form}",
        "lateral": f"Lateral::{controller.lateral}",
        "anti_windup": f"AntiWindup::{controller.anti_windup}",
        "activation": f"Activation::{controller.activation}",
        "frame": f"Frame::{controller.frame}",
    }
    tracks = controller.uses_tracking_law
    net = f"Net::{controller.net.replace('-', '_')}"
    if kind is None:
        rows = ", ".join(
            "{" + ", ".join(literal(share) for share in row) + "}" for row in design.allocation
        )
        allocation, structure = f"{{{{{rows}}}}}", "nfopidn::RuntimeVariant<float>"
        if tracks:
            structure = "nfopidn::TrackingVariant<float>"
    else:
        allocation = f"nfopidn::Allocation<float>::{kind}()"
        words = [choices["form"], f"AllocationKind::{kind}", *list(choices.values())[1:]]
        structure = "nfopidn::FixedVariant<\n        float, " + ",\n        ".join(
            f"nfopidn::{word}" for word in words
        )
        structure += ">"
        if tracks:
            structure = f"nfopidn::FixedTrackingVariant<float, {structure}, nfopidn::{net}>"
    settings = [f"  chosen.{field} = nfopidn::{value};" for field, value in choices.items()]
    settings.append(f"  chosen.allocation = {allocation};")
    parameters = ""
    if tracks:
        settings.append(f"  chosen.net = nfopidn::{net};")
        parameters = _parameters(design)
    return template("law.hpp").substitute(
        reference="" if reference is None else cpp_reference_text(reference),
        name=name,
        origin=origin_of(controller, scenario, verdict, "// "),
        count=design.taps.shape[1],
        limit=literal(design.limit),
        structure=structure,
        taps=table(design.taps),
        settings="\n".join(settings),
        limits=_limits(design),
        parameters=parameters,
        set_parameters="  law.set_parameters(parameters);\n" if tracks else "",
    )


def _limits(design: Design) -> str:
    numbers = ["torque_limit", literal(design.speed_scale)]
    if design.sample_time > 0:
        numbers.append(literal(design.sample_time))
    return ", ".join(numbers)


def _parameters(design: Design) -> str:
    lines = [f"    {literal(number)},  // {name}" for name, number in design.law.items()]
    text = "\n".join(lines)
    return f"\ninline constexpr nfopidn::LawParameters<float> parameters = {{\n{text}\n}};\n"
