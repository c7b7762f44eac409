"""The continuous idealization beside the array's verdicts: one table for terminals, reports and JSON."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rich.console import Group, RenderableType
from rich.text import Text

from nonsmooth.analysis.continuum.prediction import HeadingEffect, MomentFreeHeading, Prediction
from nonsmooth.proofs.theorem4_result import Check
from nonsmooth.reports.exact_record import Record, with_exact
from nonsmooth.reports.terminal import header_table
from nonsmooth.symbolic.body import outline_text
from nonsmooth.symbolic.continuum import ContinuousField, Disc
from nonsmooth.symbolic.number_text import float_text, short_text
from nonsmooth.symbolic.scene import Scene

HEADER = ("what moves", "position", "rotation")
NOTE = "predicted in floats for force per area along the field; position settles first; not proved, not in the verdict"

Row = tuple[str, str, str]


def continuum_rows(found: Sequence[Prediction], results: Sequence[Check]) -> list[Row]:
    """What moves, what its position does, what its heading does: each object on the field, then the array."""
    return [*(_row(prediction) for prediction in found), *(_array_row(result) for result in results)]


def continuum_view(found: Sequence[Prediction], results: Sequence[Check]) -> RenderableType:
    """The table on a terminal."""
    rows = header_table(*HEADER)
    rows.show_lines = True
    for row in continuum_rows(found, results):
        rows.add_row(*(Text(entry) for entry in row))
    head = f"continuous idealization: {field_text(found[0].field)}{_objects_text(results[0].scene)}"
    return Group(Text(head), rows, Text(NOTE, "dim"))


def continuum_record(found: Sequence[Prediction], result: Check) -> Record:
    """JSON: the predictions, and the array's verdicts beside them."""
    field, scene, drift = found[0].field, result.scene, result.rotation.drift
    return {
        "field": {"kind": field.kind, **with_exact({"speed": field.speed, "centre": field.centre})},
        "given": _is_given(scene),
        "objects": [_object_record(prediction) for prediction in found],
        "array": {
            "rule": str(scene.contact.rule),
            "equilibrium": str(result.equilibrium.verdict),
            "translation": str(result.translation.verdict),
            "rotation": str(result.rotation.verdict),
            **with_exact({"drift": None if drift is None else drift.interval}),
        },
        "proved": False,
    }


def _object_record(prediction: Prediction) -> Record:
    footprint = prediction.footprint
    shape: dict[str, Any] = {"shape": "disc" if isinstance(footprint, Disc) else footprint.name}
    if isinstance(footprint, Disc):
        shape |= with_exact({"radius": footprint.radius})
    else:
        shape |= with_exact({"vertices": footprint.vertices})
    return {
        **shape,
        "attracts": prediction.attracts,
        "offset": None if prediction.rotation is HeadingEffect.UNKNOWN else prediction.offset,
        "rotation": str(prediction.rotation),
        "headings": [{"theta": heading.theta, "stable": heading.stable} for heading in prediction.headings],
        "reason": prediction.reason,
    }


def field_text(field: ContinuousField) -> str:
    """The field in words."""
    size = "proportional to the distance" if field.kind == "radial" else "as large as the field's vector"
    if field.speed is not None:
        size = f"of constant size {short_text(field.speed)}"
    x, y = (short_text(entry) for entry in field.centre)
    return f"{field.kind} field about ({x}, {y}), {size}"


def _objects_text(scene: Scene) -> str:
    return "" if _is_given(scene) else "; no [body] in the scene: objects that just cover the wheels"


def _is_given(scene: Scene) -> bool:
    return scene.continuum is not None and scene.continuum.footprint is not None


def _row(prediction: Prediction) -> Row:
    return _object_text(prediction), _position_text(prediction), _rotation_text(prediction)


def _object_text(prediction: Prediction) -> str:
    return f"{outline_text(prediction.footprint)} on the field"


def _position_text(prediction: Prediction) -> str:
    if prediction.rotation is HeadingEffect.UNKNOWN:
        return "not found"
    where = "centre of the field"
    if prediction.offset:
        where = f"centroid up to {float_text(prediction.offset)} from the centre of the field"
    said = {True: "attracts", False: "does not attract", None: "not decided"}
    return f"{where}: {said[prediction.attracts]}"


def _rotation_text(prediction: Prediction) -> str:
    found = f": {', '.join(_heading_text(h) for h in prediction.headings)} (and half a turn on)"
    return f"{prediction.rotation}{found if prediction.headings else ''}; {prediction.reason}"


def _heading_text(heading: MomentFreeHeading) -> str:
    stable = {True: "stable", False: "unstable", None: "not decided"}[heading.stable]
    return f"theta = {float_text(heading.theta)} {stable}"


def _array_row(result: Check) -> Row:
    scene, drift = result.scene, result.rotation.drift
    x, y = (short_text(entry) for entry in scene.check.equilibrium)
    position = f"equilibrium at ({x}, {y}): {result.equilibrium.verdict}; {result.translation.verdict}"
    spin = "" if drift is None else f"; drift at rest [{', '.join(map(float_text, drift.interval))}]"
    return f"the array, rule {scene.contact.rule}", position, f"{result.rotation.verdict}{spin}"
