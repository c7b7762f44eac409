"""Certificates of arrays: a verdict under rule ``nearest`` or ``box``, as :mod:`nonsmooth.proofs.checker` re-checks it.

The statement names the wheels and the clauses that are decided.  The evidence of theorem ``theorem 4`` are the corners
of the cells, with the wheels that act in each and the twists; and for each clause what shows its verdict: weights and
multipliers of the drift, or a separating direction; the squared radius of the disc on which V* keeps its sign, with
barriers; signs of translations along the nearest rims, three imposed twists, or the normal of a plane of twists for the
feedback; and what shows the numbers of the answers.  Of a scene with tolerances the certificate states the disc in
which bodies end for every array, where rule ``nearest`` shows one.  All else (reasons, the witness where no certificate
for feedback was found) lies under ``notes``, which the checker does not read.

Every cell lists all corners of the partition that lie on its sides, and the checked point where it lies on them.  So
the sides of neighbours are the same pairs of points, once in each sense: that shows that the cells tile.  Cells that
the check left out, because the lemma on inward rims speaks for them, are built here: a certificate needs no lemma.
Rule ``ellipse`` has no cells and is refused.
The form of the numbers is described in :mod:`nonsmooth.proofs.findings`.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any, Protocol, TypeAlias

from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.contact_rule import contact_rule, rule_of
from nonsmooth.analysis.cells.loads import load_regions
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.proofs.checker.statements import VERSION, show_entry
from nonsmooth.proofs.checker.theorem4 import CLAUSES
from nonsmooth.proofs.checker.wheels import read_array
from nonsmooth.proofs.checker.work import BUDGET, RejectedError
from nonsmooth.proofs.clause_registry import conclude, decide_clauses
from nonsmooth.proofs.clauses.equilibrium.clause import decide_equilibrium
from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult
from nonsmooth.proofs.clauses.feedback.clause import AnyFeedback
from nonsmooth.proofs.clauses.feedback.driven_law import in_scene
from nonsmooth.proofs.clauses.feedback.gradient_law import SLACK
from nonsmooth.proofs.clauses.rotation.clause import RotationResult, drift_at_rest
from nonsmooth.proofs.clauses.translation.on_cells import SIMPLE, CertifiedDisc, TranslationResult, certified_disc
from nonsmooth.proofs.clauses.translation.quadratic import STEPS, QuadraticCertificate, QuadraticDecrease, rim, shaped
from nonsmooth.proofs.clauses.workspace import Workspace
from nonsmooth.proofs.findings import Equilibrium, Feedback, Record, encode, homogeneous
from nonsmooth.proofs.kernel.subject import NoCertificateError
from nonsmooth.proofs.robust.nearest import certified_bounds
from nonsmooth.proofs.verified import verified
from nonsmooth.symbolic.mechanics.contact_set import alone
from nonsmooth.symbolic.mechanics.contact_states import Twist
from nonsmooth.symbolic.mechanics.load_model import UnknownLoads
from nonsmooth.symbolic.mechanics.scene import LoadTable, Scene, Wheel
from nonsmooth.symbolic.numbers.coefficients import rational_ball
from nonsmooth.symbolic.numbers.enclosures import enclosure, rational_above, rational_below, short_below
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.number_text import brief_text
from nonsmooth.symbolic.numbers.plane import around, cross, dot, minus
from nonsmooth.symbolic.numbers.square_roots import NestingError

# ---- bounds that certificates of arrays state beside the verdicts --------------------------------
#
# Of the rotation, the way home, the rate of feedback.
#
# All are short rational numbers on the safe side of what is printed, or those numbers themselves; the checker confirms
# them by multiplying out (:mod:`nonsmooth.proofs.checker.regions`, :mod:`nonsmooth.proofs.checker.feedback`).


NEARLY = 1 - Fraction(1, 2**20)


def short_above(value: Fraction) -> Fraction:
    """A short fraction that is no smaller than a positive one, and nearly as small; zero for zero."""
    return value and 1 / short_below(1 / value)


# ---- the rotation --------------------------------------------------------------------------------


def turning_factor(partition: Partition, rotation: RotationResult) -> Fraction | None:
    """A short K with ``K c . v + |omega| |c| <= 0`` at all corners of cells that turn the body, if there is one.

    So a body that comes home through the square turns by at most ``K |c_0|``.
    """
    if rotation.rotation_per_distance is None:
        return None
    turns = [
        (twist.omega * twist.omega * dot(vertex, vertex), -dot(twist.velocity, vertex))
        for cell in partition.cells
        for twist in cell.twists
        if twist.omega
        for vertex in cell.polygon.vertices
        if any(vertex)
    ]
    if not all(sign(inward) > 0 for _, inward in turns):
        return None
    # Of the upper end: a ball around the square of a rounded rate that is nearly zero holds negative numbers, too.
    factors = (rational_above(enclosure(square).upper().sqrt() / enclosure(inward)) for square, inward in turns)
    most = max(factors, default=Fraction())
    simple = most.limit_denominator(SIMPLE)
    is_exact = all(sign(inward * inward * (simple * simple) - square) >= 0 for square, inward in turns)
    return simple if is_exact and abs(simple - most) <= most * (1 - NEARLY) else short_above(most)


# ---- the way home by another V -------------------------------------------------------------------


def ellipse_record(translation: TranslationResult, rotation: RotationResult) -> Record | None:
    """What the checker needs of ``V = c^T P c``; None where there is none, or it shows no more than a disc."""
    certificate = translation.quadratic
    if certificate is None:
        return None
    rho = certificate.descent.eccentricity
    squared_radius = certificate.disc_radius * certificate.disc_radius
    if sign(squared_radius * (1 + rho) - certificate.level) >= 0:  # the checker's ellipse touches no side
        squared_radius = squared_radius * NEARLY
    level = squared_radius * (1 + rho)
    arrival = _arrival(certificate, certificate.swift or certificate.descent, squared_radius)
    if arrival is None:
        return None
    record = {
        "squared_radius": squared_radius,
        "form": _form(certificate.shape),
        "level": level,
        "squared_swing": level / (1 - rho),
        "bend": _bend(certificate.descent, level),
        "arrival": arrival,
    }
    if _crosses_lines(certificate, level):
        record["sides"] = True
    drift = rotation.drift
    if drift is None or any(drift.interval):
        return record
    fastest = max(rational_above(enclosure(abs(twist.omega))) for _, twist in _corner_twists(certificate))
    return {**record, "turn": short_above(fastest / arrival["rate"])}


def _crosses_lines(certificate: QuadraticCertificate, level: Number) -> bool:
    """Whether ``V = level`` meets the line of a side of the cells somewhere, beyond that side."""
    a, b = certificate.shape
    determinant = 1 - a * a - b * b
    return any(
        sign(determinant * cross(p, q) * cross(p, q) - level * certificate.value(minus(q, p))) <= 0
        for p, q in rim(certificate.cones)
    )


def _form(shape: tuple[Fraction, Fraction]) -> list[Fraction]:
    a, b = shape
    return [1 + a, b, 1 - a]


def _bend(falling: QuadraticDecrease, level: Number) -> Fraction:
    """At least ``rho sqrt(level)/sqrt(1 - rho^2)``, which bounds what the rotation adds."""
    rho = falling.eccentricity
    return short_above(rational_above((enclosure(level) * rational_ball(rho * rho / (1 - rho * rho))).sqrt()))


def _arrival(certificate: QuadraticCertificate, falling: QuadraticDecrease, squared_radius: Number) -> Record | None:
    """Speeds at which sqrt(W) falls, step by step, and the rate that follows; None where one is not positive."""
    rho = falling.eccentricity
    level = squared_radius * (1 + rho)
    bend = _bend(falling, level)
    slopes = []
    for corner, twist in _corner_twists(certificate):
        image = shaped(falling.shape, corner)
        down, size = -dot(image, twist.velocity), dot(image, corner)
        slopes.append((enclosure(down) / enclosure(size).sqrt(), enclosure(abs(twist.omega))))
    speeds = []
    for k in range(1, STEPS + 1):
        slowest = min(rational_below(steep - turn * rational_ball(bend * k / STEPS)) for steep, turn in slopes)
        if slowest <= 0:
            return None
        speeds.append(short_below(slowest))
    mean = sum((1 / speed for speed in speeds), Fraction(0)) / STEPS
    rate = short_below(rational_below(1 / (rational_ball(mean) * rational_ball(1 + rho).sqrt())))
    return {"form": _form(falling.shape), "level": level, "bend": bend, "speeds": speeds, "rate": rate}


def _corner_twists(certificate: QuadraticCertificate) -> Iterator[tuple[Point, Twist]]:
    """Each corner of the cells at the point, but that, with each motion there."""
    for cone in certificate.cones:
        for vertex in cone.cell.polygon.vertices:
            for twist in cone.twists if any(vertex) else ():
                yield vertex, twist


# ---- feedback ------------------------------------------------------------------------------------


def law_record(feedback: AnyFeedback) -> Record | None:
    """V and kappa of the law by rows, with the distance to which the rate holds; None without a certified rate."""
    if not isinstance(feedback, FeedbackResult) or feedback.rate is None or not feedback.has_lyapunov:
        return None
    lyapunov, rate = feedback.lyapunov, feedback.rate
    record: Record = {"form": _form(lyapunov.shape), "weight": lyapunov.weight, "kappa": rate.kappa}
    reach = rate.shape_reach
    if reach is None:
        return {**record, "squared_reach": None}
    return {**record, "squared_reach": reach * reach, "slack": SLACK, "least": 1 - lyapunov.eccentricity}


# ---- the certificate -----------------------------------------------------------------------------


UNDECIDED = "undecided"
FOLLOWED = ("nearest", "box")  # the rules that the stand-alone checker knows, written there once more on purpose


class DecidedArray(Protocol):
    """What is certified of an array: the results of the clauses by name, on its cells about the checked point."""

    @property
    def scene(self) -> Scene:
        """The array as it was given."""

    @property
    def partition(self) -> Partition | None:
        """The cells; None under a rule without."""

    @property
    def results(self) -> Mapping[str, Any]:
        """What the clauses say."""


def build_certificate(decided: DecidedArray, further: Sequence[tuple[Record, Record]] = ()) -> Record:
    """The certificate of a check, as data for JSON; it has passed the checker.

    Clauses that are not decided, and those that the checker's theorem leaves open, are not stated.

    Args:
        decided: what is certified.
        further: claims beside these, each with the entry of evidence that shows it.

    Raises:
        NoCertificateError: for rules without cells, for loads that are not known, where nothing is decided, and beyond
            the limits of the checker.
        UnverifiedError: where the checker rejects what is claimed.
    """
    scene, partition, results = decided.scene, decided.partition, decided.results
    rule = scene.contact.rule
    _loads(scene)
    if partition is None or rule not in FOLLOWED:
        names, why = " or ".join(f'"{name}"' for name in FOLLOWED), "follows cells, and this rule has none"
        if partition is not None:
            why = "knows no other rule"
        raise NoCertificateError(
            f'certificate: required contact.rule {names}, received "{rule}": the stand-alone checker {why}'
        )
    if scene.body is not None:  # a certificate knows no outline: it speaks of the wheels under it
        work = Workspace(alone(scene))
        scene, partition, results = work.given, work.partition or partition, decide_clauses(work)
    document = _document(scene, partition, results)
    document["statement"]["claims"] += [claim for claim, _ in further]
    document["evidence"] += [entry for _, entry in further]
    return verified(_with_tolerances(scene, document), certificate_text)


def stated_words(certificate: Mapping[str, Any]) -> dict[str, str]:
    """What a certificate states of each clause, and as the conclusion, by their names; it may leave some out."""
    said = {name: word for claim in certificate["statement"]["claims"] for name, word in claim.items()}
    words = {name: said[name] for name in CLAUSES if name in said}
    if "equilibrium" in words:
        words["equilibrium"] = "holds" if words["equilibrium"] else "fails"
    return words


def _with_tolerances(scene: Scene, document: Record) -> Record:
    """The document as data, with the strongest claim about tolerances that the checker shows."""
    statement, evidence = document["statement"], document["evidence"]
    for bound in certified_bounds(scene):
        about = {**statement["subject"], "tolerances": tolerance_record(scene)}
        extended = {"subject": about, "claims": [*statement["claims"], {"tolerances": vars(bound)}]}
        entry = {"theorem": "tolerances", "hypotheses": vars(bound), "proofs": {}}
        certificate = encode({**document, "statement": extended, "evidence": [*evidence, entry]})
        if _shows_the_last(certificate):
            return certificate
    return encode(document)


def _shows_the_last(certificate: Record) -> bool:
    """Whether the checker shows the last theorem of a certificate, which is a proposal."""
    try:
        with BUDGET.granted(len(certificate_text(certificate))):
            return bool(show_entry(read_array(certificate["statement"]["subject"]), certificate["evidence"][-1]))
    except RejectedError:
        return False


def tolerance_record(scene: Scene) -> Record | None:
    """The tolerances that the motion of the true centre of mass follows; None for a scene without."""
    box = scene.tolerances
    if box is None:
        return None
    return {name: getattr(box, name) for name in ("position", "heading", "speed", "mu_roll", "mu_side")}


def certificate_text(certificate: Record) -> str:
    """JSON, with one wheel, claim, point or cell to a line; ASCII, ending in a newline."""
    return _lines(certificate, 5) + "\n"


def _lines(value: Any, levels: int) -> str:
    """A value, of which the first levels of containers that hold others have an item to a line."""
    items = list(value.values()) if isinstance(value, dict) else value
    if not levels or not isinstance(items, list) or not any(isinstance(item, list | dict) for item in items):
        return json.dumps(value)
    if isinstance(value, dict):
        parts = [f"{json.dumps(key)}: {_lines(item, levels - 1)}" for key, item in value.items()]
        return "{\n" + ",\n".join(parts) + "\n}"
    parts = [_lines(item, levels - 1) if "theorem" in item else json.dumps(item) for item in items]
    return "[\n" + ",\n".join(f"  {part}" for part in parts) + "\n]"


# ---- the document: numbers are still those of the scene's field --------------------------


def _document(scene: Scene, partition: Partition, results: Mapping[str, Any]) -> Record:
    if not partition.complete:
        partition = build_partition(scene.recentred())
    disc = CertifiedDisc(None, {}) if results["translation"].region_radius is None else _disc(partition)
    here = [twist for cell in partition.meeting for twist in cell.twists]
    of_feedback, law = _feedback(results["feedback"])
    hypotheses = {
        **cells_record(partition),
        "disc": disc.squared_radius,
        **_bounds(partition, results, disc),
    }
    proofs = {
        **_at_rest(partition, here),
        **{f"barrier {cell} {state}": barrier for (cell, state), barrier in disc.barriers.items()},
        **law,
    }
    return {
        "version": VERSION,
        "statement": {"subject": subject_record(scene), "claims": _claims(results, of_feedback, disc, hypotheses)},
        "evidence": [{"theorem": "theorem 4", "hypotheses": hypotheses, "proofs": proofs}],
        "notes": _notes(scene, results),
    }


def scene_record(scene: Scene) -> Record:
    """The subject of a certificate about a scene, with all its tolerances.

    Raises:
        NoCertificateError: where the length of a rim direction lies in no field that a certificate can name.
    """
    return encode({**subject_record(scene), "tolerances": tolerance_record(scene)})


def subject_record(scene: Scene) -> Record:
    """The subject of a certificate, without tolerances; its numbers are those of the scene's field."""
    return {
        "field": scene.field,
        "at": list(scene.check.equilibrium),
        "radius": scene.check.radius,
        "rule": str(scene.contact.rule),
        "loads": _loads(scene),
        "wheels": [_wheel(wheel) for wheel in scene.wheels],
    }


def _bounds(partition: Partition, results: Mapping[str, Any], disc: CertifiedDisc) -> Record:
    """The numbers that are stated beside the verdicts, with what they need; without those that are not shown."""
    translation, rotation = results["translation"], results["rotation"]
    rests = rotation.drift is not None and not any(rotation.drift.interval)
    bounds = {
        "drift": None if rotation.drift is None else list(homogeneous(rotation.drift.interval)),
        "rate": disc.rate,
        "turn": turning_factor(partition, rotation) if rests and disc.squared_radius is not None else None,
        "ellipse": ellipse_record(translation, rotation),
        "law": law_record(results["feedback"]),
    }
    return {name: bound for name, bound in bounds.items() if bound is not None}


def _claims(
    results: Mapping[str, Any], of_feedback: Sequence[Record], disc: CertifiedDisc, bounds: Record
) -> list[Record]:
    """Every clause that is decided, the bounds, the disc, and the conclusion."""
    verdicts = {name: result.verdict for name, result in results.items()} | {"theorem 4": conclude(results)[0]}
    claims: list[Record] = []
    if verdicts["equilibrium"] is not Equilibrium.UNDECIDED:
        claims.append({"equilibrium": verdicts["equilibrium"] is Equilibrium.HOLDS})
    for name in ("translation", "rotation"):
        claims += [] if verdicts[name] == UNDECIDED else [{name: str(verdicts[name])}]
    claims += of_feedback
    if disc.squared_radius is not None:
        sign = "strictly" if disc.strictly else "weakly"
        claims.append({"disc": {"squared_radius": disc.squared_radius, "decreases": sign}})
    claims += _bound_claims(disc, bounds)
    is_known = set(results) <= set(CLAUSES)  # a conclusion from other clauses is none that the checker draws
    if is_known and verdicts["theorem 4"] != UNDECIDED:
        claims.append({"theorem 4": str(verdicts["theorem 4"])})
    if not claims:
        raise NoCertificateError("certificate: required a clause that is decided, received none")
    return claims


def _bound_claims(disc: CertifiedDisc, bounds: Record) -> Iterator[Record]:
    """The claims that rest on the bounds of :func:`_bounds`."""
    if "drift" in bounds:
        yield {"drift": bounds["drift"]}
    for name, claim, key in (("rate", "arrival", "rate"), ("turn", "turning", "per_distance")):
        if name in bounds:
            yield {claim: {"squared_radius": disc.squared_radius, key: bounds[name]}}
    if "ellipse" in bounds:
        ellipse = bounds["ellipse"]
        start = {"squared_radius": ellipse["squared_radius"]}
        yield {"swing": {**start, "squared_swing": ellipse["squared_swing"]}}
        yield {"arrival": {**start, "rate": ellipse["arrival"]["rate"]}}
        if "turn" in ellipse:
            yield {"turning": {**start, "per_distance": ellipse["turn"]}}
    if "law" in bounds:
        yield {"feedback rate": {key: bounds["law"][key] for key in ("form", "weight", "kappa", "squared_reach")}}


def _disc(partition: Partition) -> CertifiedDisc:
    try:
        return certified_disc(partition)
    except OverflowError as error:
        raise NoCertificateError(f"certificate: {error}") from None


def _loads(scene: Scene) -> Any:
    if not rule_of(scene).needs_loads:
        return None
    loads = scene.contact.loads
    if isinstance(loads, UnknownLoads):
        raise NoCertificateError(f"certificate: required loads that are known, received {loads.words}")
    if loads is None:
        return "elastic"
    if not isinstance(loads, LoadTable):
        raise NoCertificateError(f"certificate: required elastic loads or a table, received {loads.words}")
    return loads.rows


def _wheel(wheel: Wheel) -> Record:
    try:
        direction, speed, _ = wheel.unit_direction, wheel.speed, wheel.unit_grip
    except NestingError as error:
        raise NoCertificateError(
            f"certificate: the length of the rim direction or of the axis of wheel {wheel.index}: {error}"
        ) from None
    friction = wheel.friction.roll, wheel.friction.side
    record = {"position": wheel.position, "direction": direction, "speed": speed, "friction": friction}
    return record if wheel.axis is None else {**record, "axis": wheel.unit_grip}


def cells_record(partition: Partition) -> Record:
    """The corners of all cells, and the cells with the wheels that act and their twists."""
    points, chains = _corners(partition)
    return {"points": [homogeneous(point) for point in points], "cells": _cells(partition, chains)}


def _cells(partition: Partition, chains: list[list[int]]) -> list[Record]:
    acting = _loaded_wheels(partition)
    return [
        {
            "polygon": chain,
            "wheels": list(cell.wheels) if partition.rule == "nearest" else wheels,
            "twists": [state.twist for state in cell.states],
        }
        for cell, chain, wheels in zip(partition.cells, chains, acting, strict=True)
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


def _at_rest(partition: Partition, here: Sequence[Twist]) -> Record:
    """A direction in which all motions lead; or for both ends of the drift weights and multipliers, up to scale.

    There is one weight for each motion at the point, cell by cell.
    """
    separator = decide_equilibrium(partition).separator
    if separator is not None:
        return {"separator": homogeneous(separator)[:2]}
    distinct = tuple(dict.fromkeys(here))
    drift = drift_at_rest(distinct)
    ends: Record = {}
    for name, mixture in () if drift is None else (("lowest", drift.lowest), ("highest", drift.highest)):
        *shares, _ = homogeneous(list(mixture.weights.values()))
        weights = [shares[0] * 0] * len(here)
        for k, share in zip(mixture.weights, shares, strict=True):
            weights[here.index(distinct[k])] = share
        ends[name] = {"weights": weights, "multipliers": homogeneous(mixture.multipliers)}
    return ends


def _feedback(feedback: AnyFeedback) -> tuple[list[Record], Record]:
    """The claims of the clause, and their evidence: a sign for each motion at the point, three twists, or a normal.

    Under rule ``box`` a law that depends on the direction of c is not followed: the clause stands as undecided.
    """
    verdict, normal = feedback.verdict, feedback.obstruction
    if verdict is Feedback.UNDECIDED:
        return [], {}
    claims: list[Record] = [{"feedback": str(verdict)}]
    if normal is not None:
        return [*claims, {"obstruction": normal}], {"feedback": {"plane": normal}}
    if verdict is not Feedback.STABILIZABLE:
        return claims, {}
    if isinstance(feedback, FeedbackResult):
        return claims, {"feedback": {"signs": feedback.rim_signs}}
    if len(feedback.cones) != 1:
        return [], {}
    return claims, {"feedback": {"twists": [in_scene(twist, feedback.length) for twist in feedback.cones[0].vectors]}}


def _notes(scene: Scene, results: Mapping[str, Any]) -> Record:
    witness, drift = results["feedback"].witness, results["rotation"].drift
    return {
        "scene": scene.name,
        "reasons": {name: result.reason for name, result in results.items()} | {"theorem4": conclude(results)[1]},
        "drift": None if drift is None else [brief_text(end) for end in drift.interval],
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


# ---- whether a certificate speaks of a given scene -----------------------------------------------
#
# The same wheels, rule, loads, point and square, exactly.
#
# Both sides are numbers over generators, each the largest root of a monic polynomial over the generators before it.  So
# equal polynomials have equal roots, and after renaming the scene's generators to the certificate's, numbers are equal
# if they are the same sums of products.  The certificate has been accepted by the checker: its generators are as they
# should be and its products are reduced.


Sum: TypeAlias = dict[tuple[int, ...], Fraction]

UNKNOWN = -1  # a generator of the scene that the certificate does not have


def find_difference(certificate: Record, scene: Scene) -> str:
    """Where an accepted certificate and a scene differ, in words; empty where it speaks of this scene.

    Args:
        certificate: parsed JSON of an array that the checker accepted.
        scene: the array, with the rule, the point and the square that were checked.
    """
    stated, subject = scene_record(alone(scene)), certificate["statement"]["subject"]
    if subject["rule"] != stated["rule"]:
        return "rule"
    names = _renamed_generators(stated["field"], subject["field"])
    for key in ("at", "radius", "loads"):
        if _value(subject[key], None) != _value(stated[key], names):
            return key
    if len(subject["wheels"]) != len(stated["wheels"]):
        return f"number of wheels ({len(subject['wheels'])} instead of {len(stated['wheels'])})"
    for number, (theirs, ours) in enumerate(zip(subject["wheels"], stated["wheels"], strict=True), 1):
        if set(theirs) != set(ours):
            return f"axis of wheel {number}"
        for key in ours:
            if _value(theirs[key], None) != _value(ours[key], names):
                return f"{key} of wheel {number}"
    return "" if _has_tolerances(subject.get("tolerances"), stated["tolerances"], names) else "tolerance"


def not_followed(certificate: Record, scene: Scene) -> Iterator[str]:
    """What of a scene the claims of an accepted certificate about it do without, in words.

    Args:
        certificate: parsed JSON of an array that the checker accepted.
        scene: from which :func:`find_difference` finds none.
    """
    claims = {name for claim in certificate["statement"]["claims"] for name in claim}
    if "tolerances" in claims and scene.tolerances is not None and scene.tolerances.centre_of_mass:
        yield "how far the centre of mass is from its nominal place; within the tolerances it is the true one"
    if "feedback rate" in claims and scene.speed_limits:
        yield "the limits of speeds; the feedback rate is that of the law while no wheel is at its limit"
    if "feedback rate" in claims and scene.loop_errors is not None:
        yield "how late and wrong the pose is; the feedback rate is that of the law with the exact pose"


def _has_tolerances(theirs: Record | None, stated: Record | None, names: list[int]) -> bool:
    """Whether a certificate speaks of a scene's tolerances, or of none."""
    if theirs is None:
        return True
    return stated is not None and all(_value(theirs[name], None) == _value(stated[name], names) for name in stated)


def _renamed_generators(stated: list[Record], theirs: list[Record]) -> list[int]:
    """The number of each of the scene's generators in the certificate."""
    polynomials = [_value(entry["polynomial"], None) for entry in theirs]
    names: list[int] = []
    for entry in stated:
        polynomial = _value(entry["polynomial"], names)
        names.append(polynomials.index(polynomial) if polynomial in polynomials else UNKNOWN)
    return names


def _value(data: Any, names: list[int] | None) -> Any:
    """Numbers as sums of products, in lists of the same shape; words as they are."""
    if data is None or data == "elastic":
        return data
    if isinstance(data, str):
        return _sum([[data]], names)
    if data and all(_is_product(item) for item in data):
        return _sum(data, names)
    return [_value(item, names) for item in data]


def _is_product(item: Any) -> bool:
    """Whether an item is ``[rational, generator, ...]``; the items of a vector are texts or lists of these."""
    return isinstance(item, list) and isinstance(item[0], str) and all(isinstance(k, int) for k in item[1:])


def _sum(products: list[list[Any]], names: list[int] | None) -> Sum:
    total: Sum = {}
    for text, *factors in products:
        renamed = factors if names is None else [names[k] for k in factors]
        monomial = tuple(sorted(renamed))
        total[monomial] = total.get(monomial, Fraction(0)) + Fraction(text)
    return {monomial: c for monomial, c in total.items() if c}
