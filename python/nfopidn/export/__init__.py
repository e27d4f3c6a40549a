"""Controllers as source code for a microcontroller: C99 by itself, or C++ on the core's headers.

Both run in single precision and do the same operations in the same order as the core's
``Controller<float, ...>``, so that their torques have the same bits.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from nfopidn._core import Controller, Scenario
from nfopidn.arguments import check_sample_time, no_rival
from nfopidn.export.c_hardware import hardware_texts
from nfopidn.export.c_law import law_texts
from nfopidn.export.c_tracking import has_speed_errors
from nfopidn.export.cpp_law import law_text
from nfopidn.export.design import check_name, design_of, write
from nfopidn.export.reference import c_reference_texts, warn_of_origin
from nfopidn.robustness.verdict import Verdict


def _asked(wanted: bool, what: str, scenario: Scenario | None) -> Scenario | None:
    if wanted and scenario is None:
        raise ValueError(f"{what} without a scenario, which has it; give a scenario")
    return scenario if wanted else None


def _referenced(scenario: Scenario | None, reference: bool) -> Scenario | None:
    return _asked(reference, "reference is asked for", scenario)


def export_c(
    controller: Controller,
    directory: str | os.PathLike[str],
    *,
    scenario: Scenario | None = None,
    name: str = "nfopidn",
    hardware: bool = False,
    reference: bool = False,
    longest_step: float | None = None,
    velocity_limits: Sequence[float] | None = None,
    verdict: Verdict | None = None,
) -> list[Path]:
    """Write a controller as self-contained C99, a header and a source, in single precision.

    The source has the taps as constants and the functions ``name_init``, ``name_reset`` and
    ``name_step``; it needs neither heap nor libm. Every setting of a controller is supported, free
    taps included.

    Parameters
    ----------
    controller
        The controller. Its memory of past errors is not written.
    directory
        Where ``name.h`` and ``name.c`` are written; made if it does not exist. Files of these names
        are replaced.
    scenario
        Gives the torque limit [N m] (3.078 without a scenario) and, with ``lateral="speed"`` and
        ``speed_scale=0``, the peak speed [m/s]; the header's comment names it.
    name
        Prefix of all names, and of the files: an identifier of C and C++.
    hardware
        Also write ``name_hardware.h`` and ``name_hardware.c``: bad and missed measurements, starts
        and changes without a kick, odometry, signs, velocities for bases that take no torques. The
        scenario, which must be given, has the robot and the sample time.
    reference
        Also write ``name_reference.h`` and ``name_reference.c``: the scenario's reference, a table.
        A path that goes beyond 8192 m, from where on a float's steps are a millimetre and more, is
        counted from its first sample; a warning and the header say so.
    longest_step
        Of `hardware`: the farthest that a wheel can roll in a sample, in [1e-6, 1e6] m. Encoders
        that tell more have failed, and the odometry leaves the pose. Default: ten times what a
        wheel rolls on the scenario's reference.
    velocity_limits
        Of `hardware`, for bases that take velocities: the most v [m/s], omega [rad/s], acceleration
        [m/s^2] and angular acceleration [rad/s^2], written as ``NAME_VELOCITY_LIMITS``. 0: the base
        does not move; infinity, the default of each: no limit.
    verdict
        What nfopidn.verdict() says of the controller; stands in the comment at the top. Without
        one, or with one on another controller or scenario, the comment says ``not verified``.

    Returns
    -------
    list of Path
        The header and the source, then those of `hardware` and `reference`.

    Raises
    ------
    ValueError
        A name that is no identifier, ``lateral="speed"`` without a speed scale, a tap beyond the
        range of single precision, a reference or hardware without a scenario, a controller made
        for another sample time than the scenario's, a `longest_step` out of range,
        `velocity_limits` that are negative or no numbers, either of them without `hardware`; a
        reference that goes farther than 8192 m from its first sample.
    OSError
        A file cannot be written.

    Warns
    -----
    UserWarning
        A reference that is counted from its first sample.
    """
    check_name(name)
    design = design_of(no_rival(controller), scenario)
    path = _referenced(scenario, reference)
    robot = _asked(hardware, "hardware is asked for (robot, sample time)", scenario)
    if longest_step is not None and not hardware:
        raise ValueError("longest_step is given without hardware, which has the odometry")
    if velocity_limits is not None and not hardware:
        raise ValueError("velocity_limits are given without hardware, which has velocities")
    texts = law_texts(controller, scenario, design, name, verdict=verdict, repeats=hardware)
    if robot is not None:
        check_sample_time(controller, robot)
        texts |= hardware_texts(controller, robot, name, longest_step, velocity_limits)
    if path is not None:
        texts |= c_reference_texts(path, name, turn_rate=has_speed_errors(controller))
        warn_of_origin(path)
    return write(directory, texts)


def export_cpp(
    controller: Controller,
    directory: str | os.PathLike[str],
    *,
    scenario: Scenario | None = None,
    name: str = "nfopidn_controller",
    reference: bool = False,
    verdict: Verdict | None = None,
) -> list[Path]:
    """Write a controller as a constexpr C++17 header on the core's own, in single precision.

    The header defines ``name::Law`` and the constant ``name::controller``, which the compiler
    makes.

    Parameters
    ----------
    controller
        The controller. Its memory of past errors is not written.
    directory
        Where ``name.hpp`` is written; made if it does not exist. A file of this name is replaced.
    scenario
        Gives the torque limit [N m] (3.078 without a scenario) and, with ``lateral="speed"`` and
        ``speed_scale=0``, the peak speed [m/s]; the header's comment names it.
    name
        The namespace and the file: an identifier of C and C++ other than ``nfopidn``.
    reference
        Also define the tables ``name::reference`` and ``name::laps`` of the scenario's reference,
        as export_c() has it.
    verdict
        What nfopidn.verdict() says of the controller; stands in the comment at the top. Without
        one, or with one on another controller or scenario, the comment says ``not verified``.

    Returns
    -------
    list of Path
        The header.

    Raises
    ------
    ValueError
        A name that is no identifier or is the library's, ``lateral="speed"`` without a speed scale,
        a tap beyond the range of single precision, a reference without a scenario, or a controller
        made for another sample time than the scenario's.
    OSError
        A file cannot be written.

    Warns
    -----
    UserWarning
        A reference that is counted from its first sample.
    """
    check_name(name)
    if name == "nfopidn":
        raise ValueError("name is 'nfopidn', the library's own namespace; choose another")
    design = design_of(no_rival(controller), scenario)
    path = _referenced(scenario, reference)
    text = law_text(controller, scenario, design, name, verdict=verdict, reference=path)
    if path is not None:
        warn_of_origin(path)
    return write(directory, {f"{name}.hpp": text})
