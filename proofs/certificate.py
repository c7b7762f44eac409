"""Certificates of arrays: a verdict under rule ``nearest`` or ``box``, as :mod:`nonsmooth.proofs.checker` re-checks it.

A certificate holds the wheels, the cells with their twists, and for each clause what shows its verdict: weights and
multipliers of the drift, a separating direction, the squared radius of the disc on which V* keeps its sign; signs of
translations along the nearest rims, three imposed twists, or the normal of a plane of twists for the feedback.  Of a
scene with tolerances it holds the disc in which bodies end for every array, where rule ``nearest`` shows one.  All
else (reasons, the witness where no certificate for feedback was found) lies under ``notes``, which the checker does not
read.

Every cell lists all corners of the partition that lie on its sides, and the checked point where it lies on them.  So
the sides of neighbours are the same pairs of points, once in each sense: that shows that the cells tile.  Cells that
the check left out, because the lemma on inward rims speaks for them, are built here: a certificate needs no lemma.
Rule ``ellipse`` has no cells and is refused.
The form of the numbers is described in :mod:`nonsmooth.proofs.exact_json`.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any, TypeAlias

from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.loads import load_regions
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.contact_rule import contact_rule, rule_of
from nonsmooth.proofs.checker.arrays import ROBUST, SCHEMA, check_certificate
from nonsmooth.proofs.clauses.equilibrium.on_cells import decide_equilibrium
from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult, rim_signs
from nonsmooth.proofs.clauses.feedback.clause import AnyFeedback
from nonsmooth.proofs.clauses.feedback.driven_law import in_scene
from nonsmooth.proofs.clauses.rotation.on_cells import drift_at_rest
from nonsmooth.proofs.clauses.translation.certified_disc import CertifiedDisc, certified_disc
from nonsmooth.proofs.exact_json import encode, homogeneous
from nonsmooth.proofs.robust.certified_bound import certified_bounds
from nonsmooth.proofs.theorem4 import check_cells
from nonsmooth.proofs.theorem4_result import CellCheck, SmoothCheck
from nonsmooth.proofs.verdicts import Feedback
from nonsmooth.symbolic.constraints import Twist
from nonsmooth.symbolic.contact_set import alone
from nonsmooth.symbolic.number_text import brief_text
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.square_roots import NestingError
from nonsmooth.symbolic.plane import around, cross, dot
from nonsmooth.symbolic.scene import Scene, Wheel
from nonsmooth.symbolic.unknown_loads import UnknownLoads

Record: TypeAlias = dict[str, Any]

FOLLOWED = ("nearest", "box")  # the rules that the stand-alone checker knows, written there once more on purpose


class CertificateError(ValueError):
    """A verdict for which there is no certificate; the message says why."""


def build_certificate(result: CellCheck | SmoothCheck) -> Record:
    """The certificate of a check, as data for JSON; it has passed the checker.

    Raises:
        CertificateError: for rule ``ellipse``, and where the checker does not follow the verdict.
    """
    rule = result.scene.contact.rule
    _loads(result.scene)
    if isinstance(result, SmoothCheck) or rule not in FOLLOWED:
        names, why = " or ".join(f'"{name}"' for name in FOLLOWED), "follows cells, and this rule has none"
        if isinstance(result, CellCheck):
            why = "knows no other rule"
        raise CertificateError(
            f'certificate: required contact.rule {names}, received "{rule}": the stand-alone checker {why}'
        )
    if result.scene.body is not None:  # a certificate knows no outline: it speaks of the wheels under it
        result = check_cells(alone(result.scene))
    certificate, claim = _with_tolerances(result, _document(result))
    if claim and rule_of(result.scene).keeps_rows and _rows_left_out(result.scene):
        raise CertificateError(
            "certificate: required friction in both directions, received rows without friction, which are left out: "
            "the stand-alone checker follows both rows of the nearest wheel and one row of the second"
        )
    if claim:
        raise CertificateError(f"certificate: required a verdict that the checker follows; it does not show: {claim}")
    return certificate


def _with_tolerances(result: CellCheck, document: Record) -> tuple[Record, str]:
    """The document as data with the strongest claim about tolerances that the checker shows; and what it does not."""
    for bound in certified_bounds(result.scene):
        certificate = encode({**document, ROBUST: {"tolerance": tolerance_record(result.scene), **vars(bound)}})
        if not check_certificate(certificate):
            return certificate, ""
    certificate = encode(document)
    return certificate, check_certificate(certificate)


def tolerance_record(scene: Scene) -> Record | None:
    """The tolerances that the motion of the true centre of mass follows; None for a scene without."""
    box = scene.tolerances
    if box is None:
        return None
    return {name: getattr(box, name) for name in ("position", "heading", "speed", "mu_roll", "mu_side")}


def _rows_left_out(scene: Scene) -> bool:
    """Whether a row has no friction, so that rule ``nearest`` does not take it."""
    return not all(wheel.friction.roll and wheel.friction.side for wheel in scene.wheels)


def certificate_text(certificate: Record) -> str:
    """JSON, with one wheel, point or cell to a line; ASCII, ending in a newline."""
    parts = [f"{json.dumps(key)}: {_lines(value)}" for key, value in certificate.items()]
    return "{\n" + ",\n".join(parts) + "\n}\n"


def _lines(value: Any) -> str:
    if isinstance(value, list) and any(isinstance(item, list | dict) for item in value):
        return "[\n" + ",\n".join(f"  {json.dumps(item)}" for item in value) + "\n]"
    return json.dumps(value)


# ---- the document: numbers are still those of the scene's field --------------------------


def _document(result: CellCheck) -> Record:
    scene, partition = result.scene, result.partition
    if not partition.complete:
        partition = build_partition(scene.recentred())
    points, chains = _corners(partition)
    disc = CertifiedDisc(None, {}) if result.translation.region_radius is None else _disc(partition)
    zero = scene.field.zero
    here = [twist for cell in partition.cells_at((zero, zero)) for twist in cell.twists]
    return {
        "schema": SCHEMA,
        "field": scene.field,
        **_scene(scene),
        "points": [homogeneous(point) for point in points],
        "cells": _cells(partition, chains, disc),
        "equilibrium": {"verdict": str(result.equilibrium.verdict), "separator": _separator(partition)},
        "translation": {"verdict": str(result.translation.verdict), "squared_radius": disc.squared_radius},
        "rotation": {"verdict": str(result.rotation.verdict), **_drift(here)},
        "feedback": _feedback(result.feedback),
        "theorem4": str(result.verdict),
        "notes": _notes(result),
    }


def scene_record(scene: Scene) -> Record:
    """The part of a certificate that says which scene it is about, with the field of its numbers.

    Raises:
        CertificateError: where the length of a rim direction lies in no field that a certificate can name.
    """
    return encode({"field": scene.field, **_scene(scene), "tolerance": tolerance_record(scene)})


def _scene(scene: Scene) -> Record:
    return {
        "at": list(scene.check.equilibrium),
        "radius": scene.check.radius,
        "rule": str(scene.contact.rule),
        "loads": _loads(scene),
        "wheels": [_wheel(wheel) for wheel in scene.wheels],
    }


def _disc(partition: Partition) -> CertifiedDisc:
    try:
        return certified_disc(partition)
    except OverflowError as error:
        raise CertificateError(f"certificate: {error}") from None


def _loads(scene: Scene) -> Any:
    if not rule_of(scene).needs_loads:
        return None
    loads = scene.contact.loads
    if isinstance(loads, UnknownLoads):
        raise CertificateError(f"certificate: required loads that are known, received {loads.words}")
    return "elastic" if loads is None else loads.rows


def _wheel(wheel: Wheel) -> Record:
    try:
        direction, speed, _ = wheel.unit_direction, wheel.speed, wheel.unit_grip
    except NestingError as error:
        raise CertificateError(
            f"certificate: the length of the rim direction or of the axis of wheel {wheel.index}: {error}"
        ) from None
    friction = wheel.friction.roll, wheel.friction.side
    record = {"position": wheel.position, "direction": direction, "speed": speed, "friction": friction}
    return record if wheel.axis is None else {**record, "axis": wheel.unit_grip}


def _cells(partition: Partition, chains: list[list[int]], disc: CertifiedDisc) -> list[Record]:
    loaded = _loaded_wheels(partition)
    return [
        {
            "polygon": chains[k],
            "loaded": loaded[k],
            "states": [
                {"rows": [row.name for row in state.rows], "twist": state.twist, "barrier": disc.barriers.get((k, s))}
                for s, state in enumerate(cell.states)
            ],
        }
        for k, cell in enumerate(partition.cells)
    ]


def _loaded_wheels(partition: Partition) -> list[list[int] | None]:
    """The wheels that carry load in each cell; None where loads are not elastic."""
    scene = partition.scene
    if not contact_rule(partition.rule).needs_loads or scene.contact.loads is not None:
        return [None] * len(partition.cells)
    regions = load_regions(scene)
    return [
        sorted(next(r.loaded for r in regions if all(r.polygon.contains(v) for v in cell.polygon.vertices)))
        for cell in partition.cells
    ]


def _separator(partition: Partition) -> Sequence[Number] | None:
    separator = decide_equilibrium(partition).separator
    return None if separator is None else homogeneous(separator)[:2]


def _drift(here: Sequence[Twist]) -> Record:
    """Both ends of the drift: weights (one for each motion at the point, cell by cell) and multipliers, up to scale."""
    distinct = tuple(dict.fromkeys(here))
    drift = drift_at_rest(distinct)
    if drift is None:
        return {"lowest": None, "highest": None}
    ends: Record = {}
    for name, mixture in (("lowest", drift.lowest), ("highest", drift.highest)):
        *shares, _ = homogeneous(list(mixture.weights.values()))
        weights = [shares[0] * 0] * len(here)
        for k, share in zip(mixture.weights, shares, strict=True):
            weights[here.index(distinct[k])] = share
        ends[name] = {"weights": weights, "multipliers": homogeneous(mixture.multipliers)}
    return ends


def _feedback(feedback: AnyFeedback) -> Record:
    """The verdict with a sign for each motion at the point, three twists, or the normal of a plane.

    Under rule ``box`` a law that depends on the direction of c is not followed: the clause stands as undecided.
    """
    verdict = feedback.verdict
    if feedback.obstruction is not None:
        return {"verdict": str(verdict), "evidence": feedback.obstruction}
    if verdict is not Feedback.STABILIZABLE:
        return {"verdict": str(verdict), "evidence": None}
    if isinstance(feedback, FeedbackResult):
        return {"verdict": str(verdict), "evidence": rim_signs(feedback)}
    (first, *others) = feedback.cones
    if others:
        return {"verdict": str(Feedback.UNDECIDED), "evidence": None}
    return {"verdict": str(verdict), "evidence": [in_scene(twist, feedback.length) for twist in first.vectors]}


def _notes(result: CellCheck) -> Record:
    clauses = ("equilibrium", "translation", "rotation", "feedback")
    witness = result.feedback.witness
    return {
        "scene": result.scene.name,
        "reasons": {name: getattr(result, name).reason for name in clauses} | {"theorem4": result.reason},
        "drift": None if result.rotation.drift is None else [brief_text(end) for end in result.rotation.drift.interval],
        "feedback_witness": None if witness is None else [brief_text(x) for x in (*witness.point, witness.value)],
        "check_with": "python -I -S proofs/checker FILE",
    }


# ---- corners -----------------------------------------------------------------------------


def _corners(partition: Partition) -> tuple[list[Point], list[list[int]]]:
    """The corners of all cells, and for each cell its corners counterclockwise, the checked point among them."""
    polygons = [cell.polygon for cell in partition.cells]
    plane = partition.complex
    chains = [
        [
            edge.start if edge.left == k else edge.end
            for border in plane.borders[k]
            for edge in map(plane.edges.__getitem__, border)
        ]
        for k in range(len(polygons))
    ]
    points = list(plane.points)
    zero = partition.scene.field.zero
    if all(any(point) for point in points):
        chains = [_with_origin(points, chain) for chain in chains]
        if any(len(points) in chain for chain in chains):
            points.append((zero, zero))
    return points, chains


def _with_origin(points: list[Point], chain: list[int]) -> list[int]:
    """The chain with one more corner, of the next free number, where the origin lies on a side."""
    for k, (start, end) in enumerate(around(chain)):
        a, b = points[start], points[end]
        if not sign(cross(a, b)) and sign(dot(a, b)) < 0:
            return [*chain[: k + 1], len(points), *chain[k + 1 :]]
    return chain
