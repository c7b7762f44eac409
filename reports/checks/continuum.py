"""The continuous idealization beside the array's verdicts: one table for terminals, reports and JSON."""

from __future__ import annotations

from collections.abc import Sequence
from math import degrees

from rich.console import Group, RenderableType
from rich.text import Text

from nonsmooth.analysis.bodies.continuum import HeadingEffect, NoIdealizationError, Prediction, predictions
from nonsmooth.proofs.findings import Record
from nonsmooth.proofs.theorem4 import Check
from nonsmooth.reports.output.document import Section, display, table
from nonsmooth.reports.output.facts import with_exact
from nonsmooth.reports.output.prose import paragraph
from nonsmooth.reports.output.terminal import header_table
from nonsmooth.symbolic.mechanics.body import ContinuousField, Disc, outline_text
from nonsmooth.symbolic.mechanics.units import Units
from nonsmooth.symbolic.numbers.number_text import exact_place, float_text, short_text

HEADER = ("what moves", "position", "rotation")
NOTE = "predicted in floats for force per area along the field; position settles first; not proved, not in the verdict"

Row = tuple[str, str, str]


def continuum_section(result: Check) -> Section | None:
    """What a continuous field would do to an object, beside what the array does; None where no field stands for it."""
    try:
        found = predictions(result.scene)
    except NoIdealizationError:
        return None
    words = paragraph(
        "The wheels sample one field: {}. If every point p of the object's footprint were pushed by a force per area "
        "along it, force and moment about the centroid would be",
        _field_text(found[0].field),
    )
    balance = display(
        r"F = \int f \, dA, \qquad M = \int (p - c) \times f \, dA",
        "F = int f dA, M = int (p - c) x f dA",
    )
    rest = paragraph(
        "and the object would rest where both vanish, at stable headings where the moment turns back. That is what "
        "many small actuators would do; the last row is what these few wheels do."
    )
    units = result.scene.units
    rows = table(HEADER, [*(_row(one, units) for one in found), _array_row(result)], (3, 4, 6))
    return Section(
        "The continuous idealization", (words, balance, rest, rows, paragraph("The first rows are {}.", NOTE))
    )


def continuum_view(found: Sequence[Prediction], results: Sequence[Check]) -> RenderableType:
    """The table on a terminal."""
    rows = header_table(*HEADER)
    rows.show_lines = True
    units = results[0].scene.units
    for row in (*(_row(one, units) for one in found), *map(_array_row, results)):
        rows.add_row(*map(Text, row))
    given = "" if _is_given(results[0]) else "; no [body] in the scene: objects that just cover the wheels"
    return Group(Text(f"continuous idealization: {_field_text(found[0].field)}{given}"), rows, Text(NOTE, "dim"))


def continuum_record(found: Sequence[Prediction], result: Check) -> Record:
    """JSON: the predictions, and the array's verdicts beside them."""
    field, drift = found[0].field, result.rotation.drift
    return {
        "field": {"kind": field.kind, **with_exact({"speed": field.speed, "centre": field.centre})},
        "given": _is_given(result),
        "objects": [_object_record(prediction) for prediction in found],
        "array": {
            "rule": str(result.scene.contact.rule),
            "equilibrium": str(result.equilibrium.verdict),
            "translation": str(result.translation.verdict),
            "rotation": str(result.rotation.verdict),
            **with_exact({"drift": None if drift is None else drift.interval}),
        },
        "proved": False,
    }


def _object_record(prediction: Prediction) -> Record:
    footprint = prediction.footprint
    if isinstance(footprint, Disc):
        shape = {"shape": "disc", **with_exact({"radius": footprint.radius})}
    else:
        shape = {"shape": footprint.name, **with_exact({"vertices": footprint.vertices})}
    return {
        **shape,
        "attracts": prediction.attracts,
        "offset": None if prediction.rotation is HeadingEffect.UNKNOWN else prediction.offset,
        "rotation": str(prediction.rotation),
        "headings": [{"theta": heading.theta, "stable": heading.stable} for heading in prediction.headings],
        "reason": prediction.reason,
    }


def _is_given(result: Check) -> bool:
    return result.scene.body is not None


def _field_text(field: ContinuousField) -> str:
    size = "proportional to the distance" if field.kind == "radial" else "as large as the field's vector"
    if field.speed is not None:
        size = f"of constant size {short_text(field.speed)}"
    x, y = map(short_text, field.centre)
    return f"{field.kind} field about ({x}, {y}), {size}"


def _row(prediction: Prediction, units: Units) -> Row:
    """An object on the field: what it is, what its position does, what its heading does."""
    where = "centre of the field"
    if prediction.offset:
        where = f"centroid up to {float_text(prediction.offset)} from the {where}"
    attracts = {True: "attracts", False: "does not attract", None: "not decided"}[prediction.attracts]
    is_known = prediction.rotation is not HeadingEffect.UNKNOWN
    stability = {True: "stable", False: "unstable", None: "not decided"}
    said = [f"theta = {_angle(heading.theta, units)} {stability[heading.stable]}" for heading in prediction.headings]
    headings = f": {', '.join(said)} (and half a turn on)" if said else ""
    return (
        f"{outline_text(prediction.footprint)} on the field",
        f"{where}: {attracts}" if is_known else "not found",
        f"{prediction.rotation}{headings}; {prediction.reason}",
    )


def _angle(radians: float, units: Units, per: str = "") -> str:
    """In the unit in which people read the scene's angles, named where the scene states units."""
    text = float_text(degrees(radians) if units.in_degrees else radians)
    return f"{text} {units.angle}{per}" if units.length else text


def _array_row(result: Check) -> Row:
    drift, point = result.rotation.drift, exact_place(result.scene.check.equilibrium)
    units = result.scene.units
    spin = ""
    if drift is not None:
        spin = f"; drift at rest [{', '.join(_angle(float(end), units, '/s') for end in drift.interval)}]"
    return (
        f"the array, rule {result.scene.contact.rule}",
        f"equilibrium at {point}: {result.equilibrium.verdict}; {result.translation.verdict}",
        f"{result.rotation.verdict}{spin}",
    )
