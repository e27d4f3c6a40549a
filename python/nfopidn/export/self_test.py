"""The exported C's test of the compiler and the processor that it is on."""

from __future__ import annotations

from nfopidn.export.design import template

# Of Controller<float>: an angle, the same in [-pi, pi), its cosine and sine.
_ANGLES = (
    ("0.5F", "0.5F", "0.87758255F", "0.47942555F"),
    ("2.25F", "2.25F", "-0.628173649F", "0.778073192F"),
    ("3.5F", "-2.78318524F", "-0.93645668F", "-0.350783229F"),
    ("-4.0F", "2.28318524F", "-0.653643608F", "0.756802499F"),
    ("20.25F", "1.40044403F", "0.169529513F", "0.985525131F"),
    ("-301.5F", "0.0928947479F", "0.995688379F", "0.0927612036F"),
)
# A net and the neuron's output.
_NETS = (
    ("0.03125F", "0.0156237278F"),
    ("0.75F", "0.3583574F"),
    ("-2.5F", "-0.848283768F"),
    ("5.0F", "0.986614287F"),
    ("9.0F", "0.999753356F"),
    ("-0.300000012F", "-0.148885041F"),
)
# A speed, and the lateral schedule with lateral_speed 0.25 and lateral_power 1.5.
_SPEEDS = (
    ("0.0F", "0.0F"),
    ("0.3F", "1.22933114F"),
    ("-0.02F", "-0.159236297F"),
    ("7.5F", "0.364844233F"),
)


def self_test_text(
    words: dict[str, str],
    *,
    function: str,
    before: str,
    heading: bool,
    neuron: bool,
    guard: bool,
    schedule: bool = False,
) -> str:
    """Write a function that tries what its file computes with; `guard`: also what looks for NaN.

    It runs straight on, without a table, which would lie in RAM on some processors. `before` is the
    verdict it starts from.
    """
    lines = []
    for angle, wrapped, cosine, sine in _ANGLES:
        lines += [f"input = {angle};", f"compare(wrapped(input), {wrapped}, &verdict);"]
        if heading:
            lines.append("cosine_and_sine(input, &cosine, &sine);")
            lines.append(f"compare(cosine, {cosine}, &verdict);")
            lines.append(f"compare(sine, {sine}, &verdict);")
    for net, output in _NETS if neuron else ():
        lines += [f"input = {net};", f"compare(neuron(input), {output}, &verdict);"]
    for speed, factor in _SPEEDS if schedule else ():
        lines.append(f"input = {speed};")
        lines.append(f"compare(lateral_schedule(input, 0.0625F, -0.75F), {factor}, &verdict);")
    return template("self_test.c").substitute(
        words,
        function=function,
        before=before,
        variables="float nothing, cosine, sine;" if heading else "float nothing;",
        checks="\n".join(f"  {line}" for line in lines),
        taken_for_number="nothing == nothing" + (" || within(nothing)" if guard else ""),
    )
