"""Bounds that certificates of arrays state beside the verdicts: of the rotation, the way home, the rate of feedback.

All are short rational numbers on the safe side of what is printed, or those numbers themselves; the checker confirms
them by multiplying out (:mod:`nonsmooth.proofs.checker.regions`, :mod:`nonsmooth.proofs.checker.feedback`).
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import Any, TypeAlias

from flint import arb

from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult
from nonsmooth.proofs.clauses.feedback.facts import AnyFeedback
from nonsmooth.proofs.clauses.feedback.gradient_law import SLACK
from nonsmooth.proofs.clauses.rotation.on_cells import RotationResult
from nonsmooth.proofs.clauses.translation.certified_disc import SIMPLE
from nonsmooth.proofs.clauses.translation.on_cells import TranslationResult
from nonsmooth.proofs.clauses.translation.quadratic import STEPS, QuadraticCertificate, QuadraticDecrease, shaped
from nonsmooth.symbolic.mechanics.constraints import Twist
from nonsmooth.symbolic.numbers.coefficients import rational_ball
from nonsmooth.symbolic.numbers.enclosures import enclosure, rational_below, short_below
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.plane import dot

Record: TypeAlias = dict[str, Any]

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
    most = max((_above(enclosure(square).sqrt() / enclosure(inward)) for square, inward in turns), default=Fraction(0))
    simple = most.limit_denominator(SIMPLE)
    is_exact = all(sign(inward * inward * (simple * simple) - square) >= 0 for square, inward in turns)
    return simple if is_exact and abs(simple - most) <= most * (1 - NEARLY) else short_above(most)


def _above(ball: arb) -> Fraction:
    """The upper end of a ball."""
    return -rational_below(-ball)


# ---- the way home by another V -------------------------------------------------------------------


def ellipse_record(translation: TranslationResult, rotation: RotationResult) -> Record | None:
    """What the checker needs of ``V = c^T P c``; None where there is none, or it shows no more than a disc."""
    found = translation.quadratic
    if found is None:
        return None
    rho = found.descent.eccentricity
    squared_radius = found.disc_radius * found.disc_radius
    if sign(squared_radius * (1 + rho) - found.level) >= 0:  # the checker's ellipse touches no side
        squared_radius = squared_radius * NEARLY
    level = squared_radius * (1 + rho)
    arrival = _arrival(found, found.swift or found.descent, squared_radius)
    if arrival is None:
        return None
    record = {
        "squared_radius": squared_radius,
        "form": _form(found.shape),
        "level": level,
        "squared_swing": level / (1 - rho),
        "bend": _bend(found.descent, level),
        "arrival": arrival,
    }
    drift = rotation.drift
    if drift is None or any(drift.interval):
        return record
    fastest = max(_above(enclosure(abs(twist.omega))) for _, twist in _corners(found))
    return {**record, "turn": short_above(fastest / arrival["rate"])}


def _form(shape: tuple[Fraction, Fraction]) -> list[Fraction]:
    a, b = shape
    return [1 + a, b, 1 - a]


def _bend(own: QuadraticDecrease, level: Number) -> Fraction:
    """At least ``rho sqrt(level)/sqrt(1 - rho^2)``, which bounds what the rotation adds."""
    rho = own.eccentricity
    return short_above(_above((enclosure(level) * rational_ball(rho * rho / (1 - rho * rho))).sqrt()))


def _arrival(found: QuadraticCertificate, own: QuadraticDecrease, squared_radius: Number) -> Record | None:
    """Speeds at which sqrt(W) falls, step by step, and the rate that follows; None where one is not positive."""
    rho = own.eccentricity
    level = squared_radius * (1 + rho)
    bend = _bend(own, level)
    slopes = []
    for corner, twist in _corners(found):
        image = shaped(own.shape, corner)
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
    return {"form": _form(own.shape), "level": level, "bend": bend, "speeds": speeds, "rate": rate}


def _corners(found: QuadraticCertificate) -> Iterator[tuple[Point, Twist]]:
    """Each corner of the cells at the point, but that, with each motion there."""
    for cone in found.cones:
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
