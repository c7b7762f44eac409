"""Published claims as scenes, each with a verdict that is computed: agrees, or refuted with a witness.

Sources marked "abstract" were looked up, the others are cited from memory; the sentence that is checked is the one in
the row, and nothing else of the work.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from nonsmooth.analysis.bodies.continuum import PolygonOnField, predict
from nonsmooth.proofs.answers.answers import full_answers
from nonsmooth.proofs.theorem4 import check_theorem4
from nonsmooth.reports.checks.answers import check_record
from nonsmooth.reports.checks.equilibrium_headings import headings_record
from nonsmooth.symbolic.files.scene_document import rectangle
from nonsmooth.symbolic.files.scene_file import build_scene, load_scene
from nonsmooth.symbolic.mechanics.body import ContinuousField, PolygonShape
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.number_text import float_text
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from tests.evidence.comparison import Comparison, published
from tests.evidence.pushed_body import Contacts, masons_vote, push, random_push

BOHRINGER = "Bohringer, Donald, Kavraki and Lamiraux 2000 (abstract; the fields from memory)"
SUDSANG = "Sudsang and Kavraki 2001 (from memory)"
LUNTZ = "Luntz, Messner and Choset 2001 (abstract)"
MURPHEY_2001 = "Murphey and Burdick 2001 (the paper)"
MURPHEY_2004 = "Murphey and Burdick 2004 (from memory)"
MA = "Ma and Rodriguez 2018 (abstract)"
MASON = "Mason 1986 (from memory)"


def claim_comparisons() -> Iterator[Comparison]:
    """All rows, in the order of the page."""
    yield from _force_fields()
    yield from _discrete_wheels()
    yield from _distributed_manipulation()
    yield from _pushing()


def _degrees(headings: list[float]) -> str:
    return ", ".join(f"{float_text(math.degrees(angle), 4)} deg" for angle in sorted(headings))


# ---- programmable force fields -------------------------------------------------------------------

Points = tuple[tuple[Fraction, Fraction], ...]

TRIANGLE: Points = tuple(  # from its centroid
    (Fraction(x) - Fraction(1), Fraction(y) - Fraction(1, 3)) for x, y in ((0, 0), (3, 0), (0, 1))
)
SMALL, LARGE = 0.01, 0.2  # constant fields, of the unit field
HEADINGS = 360  # over a whole turn, at which the moment is looked at
SHIFT = 0.37  # of a step: symmetric parts have their equilibria elsewhere
STEPS, SETTLED = 80, 1e-12  # of Newton's method; of the force per area


def _force_fields() -> Iterator[Comparison]:
    for constant, size in ((SMALL, "a small constant"), (LARGE, "any constant (the paper says small)")):
        stable = stable_headings(TRIANGLE, constant)
        claim = f"a unit radial field plus {size}: stable poses of a part"
        witness = f"triangle, constant {constant} of the unit field: {_degrees(stable)}; sampled at 360 headings"
        yield published(claim, BOHRINGER, len(stable), 1, witness)
    numbers = NumberField()
    box = rectangle(numbers.rational(2), numbers.rational(1))
    alone = predict(_inward(numbers, 1, 1, unit=True), box)
    claim = "a unit radial field alone orients nothing: stable headings"
    yield published(claim, BOHRINGER, len(alone.headings), 0, alone.reason)
    elliptic = predict(_inward(numbers, 1, 2, unit=False), box)
    stable = [heading.theta + turn for heading in elliptic.headings if heading.stable for turn in (0, math.pi)]
    claim = "an elliptic field leaves two stable headings of a part, half a turn apart"
    yield published(claim, BOHRINGER, len(stable), 2, f"box 2 x 1: {_degrees(stable)}, from exact second moments")
    triples = ((3, 4, 5), (5, 12, 13), (8, 15, 17), (7, 24, 25))
    turns = [(sign * Fraction(a, c), Fraction(b, c)) for a, b, c in triples for sign in (1, -1)]
    moments = [linear_moment(TRIANGLE, *turn) for turn in turns]
    claim = "a linear radial field plus a constant has one stable pose for a part: headings that are attracted"
    witness = f"exact moment at rest {max(map(abs, moments))} at {len(moments)} rational headings: every heading rests"
    yield published(claim, SUDSANG, float(any(moments)), 1, witness)


def _inward(numbers: NumberField, a: int, b: int, *, unit: bool) -> ContinuousField:
    """``(-a x, -b y)``, or the unit field along it."""
    zero, one = numbers.zero, numbers.one
    matrix = ((numbers.rational(-a), zero), (zero, numbers.rational(-b)))
    return ContinuousField("test", matrix, one if unit else None, (zero, zero))


def stable_headings(part: Points, constant: float) -> list[float]:
    """Headings at which a triangle rests and is turned back, on a unit radial field plus a constant along x; sampled.

    A constant field has no moment about the centroid, so it only moves the place at which a part rests; there the
    radial field of unit size has a moment that depends on the heading.

    Args:
        part: its corners, from its centroid.
        constant: size of the constant field.
    """
    numbers = NumberField()
    shape = PolygonShape(tuple((numbers.rational(x), numbers.rational(y)) for x, y in part))
    body = PolygonOnField(_inward(numbers, 1, 1, unit=True), shape)
    (ax, ay), (bx, by), (cx, cy) = part
    area = float(abs((bx - ax) * (cy - ay) - (by - ay) * (cx - ax)) / 2)
    place, moments = np.zeros(2), []
    thetas = (np.arange(HEADINGS + 1) + SHIFT) * 2 * math.pi / HEADINGS
    for theta in thetas:
        place, moment = _settled(body, float(theta), place, constant * area)
        moments.append(moment)
    signs = np.sign(moments)
    falls = (signs[:-1] > 0) & (signs[1:] < 0)
    return [float(theta) % (2 * math.pi) for theta in (thetas[:-1] + thetas[1:])[falls] / 2]


def _settled(body: PolygonOnField, theta: float, place: Floats, force: float) -> tuple[Floats, float]:
    """The place without force, by Newton's method from a place nearby, and the moment there.

    Raises:
        RuntimeError: where it is not found.
    """
    for _ in range(STEPS):
        wrench = body.wrench(theta, place)
        rest = wrench.force + np.array([force, 0.0])
        if np.abs(rest).max() <= SETTLED * body.area:
            return place, wrench.moment
        step = np.linalg.solve(wrench.stiffness, rest)
        place = place - step * min(1.0, body.size / (2 * float(np.hypot(*step))))
    raise RuntimeError(f"required a place of rest at heading {theta}, found none")


def linear_moment(part: Points, cosine: Fraction, sine: Fraction) -> Fraction:
    """The moment of ``f = -p + e`` on a triangle at its place of rest and a rational heading, exactly.

    The force vanishes where the centroid is at e; from there ``(p - c) x f = (p - c) x -(p - c)`` is integrated over
    the triangle by its second moments: the products of corners k and m weigh 1/6 of its area for k = m, else 1/12.
    """
    turned = [(cosine * x - sine * y, sine * x + cosine * y) for x, y in part]
    return sum(
        (
            Fraction(2 if k == m else 1, 12) * (x * -v - y * -u)
            for k, (x, y) in enumerate(turned)
            for m, (u, v) in enumerate(turned)
        ),
        Fraction(0),
    )


# ---- discrete wheels -----------------------------------------------------------------------------

ELLIPTIC_BED: dict[str, Any] = {
    "name": "box on an elliptic 6 x 6",
    "friction": {"mu_roll": 1, "mu_side": "1/2"},
    "grid": {"rows": 6, "columns": 6},
    "field": {"kind": "elliptic", "a": 1, "b": 2},
    "body": {"shape": "rectangle", "width": "37/10", "height": "8/5"},
    "contact": {"rule": "ellipse"},
    "check": {"radius": "1/5", "length": 1},
}


def _discrete_wheels() -> Iterator[Comparison]:
    scene = build_scene(ELLIPTIC_BED, str(ELLIPTIC_BED["name"]), Path("elliptic-bed.toml"))
    headings = full_answers(check_theorem4(scene), ask_others=False).headings
    found = [] if headings is None else headings_record(headings)["found"]
    home = sum(row["position"] == "comes home" for row in found)
    claim = "discrete wheels position a box stably: share of its rest headings at which the position attracts"
    yield published(claim, LUNTZ, home / len(found), 1, f"{len(found)} intervals of headings, each proved")
    rests = [row for row in found if row["kind"] == "interval"]
    apart = [row for row in rests if not any(row["from"] <= stable <= row["to"] for stable in (0.0, math.pi))]
    witness = "; ".join(f"rest from {_degrees([row['from']])} to {_degrees([row['to']])}, proved" for row in apart)
    claim = "discreteness spoils orientation: 1 where it rests away from the field's headings"
    yield published(claim, LUNTZ, float(bool(apart)), 1, witness or "none")


# ---- distributed manipulation --------------------------------------------------------------------


def _distributed_manipulation() -> Iterator[Comparison]:
    held, odd, drive = (
        check_record(check_theorem4(load_scene(name))) for name in ("four-wheel", "off-center", "differential-drive")
    )
    claim = "Theorem 4 on its own array (four-wheel): 1 where it holds"
    witness = f"V* <= -{float_text(-float(held['translation']['worst_rate']))} |c|, proved"
    yield published(claim, MURPHEY_2001, float(held["theorem4"]["verdict"] == "holds"), 1, witness)
    claim, theorem = "Theorem 4 for every planar array: 1 where it holds for off-center", odd["theorem4"]
    yield published(claim, MURPHEY_2001, float(theorem["verdict"] == "holds"), 1, theorem["reason"])
    claim = "no open loop of constant speeds attracts the heading: 1 where the heading is not attracted"
    low, high = map(float_text, held["rotation"]["drift"])
    witness = f"at rest in (x, y) the body may turn at {low} to {high}"
    yield published(claim, MURPHEY_2004, float(held["rotation"]["verdict"] == "unstable"), 1, witness)
    claim = "feedback with two inputs at a time holds all three coordinates (four-wheel): 1 where it does"
    witness = f"certified law, kappa {float_text(held['feedback']['rate'])}"
    yield published(claim, MURPHEY_2004, float(_can_be_held(held)), 1, witness)
    claim = "feedback holds underactuated arrays, read as all of them: 1 where it holds differential-drive"
    yield published(claim, MURPHEY_2004, float(_can_be_held(drive)), 1, drive["answers"]["pose"]["reason"])


def _can_be_held(record: dict[str, Any]) -> bool:
    return bool(record["answers"]["pose"]["verdict"] == "can be held")


# ---- pushing -------------------------------------------------------------------------------------

PUSHES = 100  # random ones
SEED = 1986
STEEP = 2.0  # ratio of the axes of an anisotropic friction
NARROWED = 0.9  # ratio of spreads below which they are narrowed
SPREAD = math.radians(10)  # of the directions of a push


def _pushing() -> Iterator[Comparison]:
    agree = 0
    for rng in np.random.default_rng(SEED).spawn(PUSHES):
        contacts, tip = random_push(rng)
        agree += np.sign(push(contacts, *tip).twist[2]) == masons_vote(*tip)
    claim = "both edges of the tip's friction cone and the push vote on the sense of rotation: share of random pushes"
    yield published(claim, MASON, agree / PUSHES, 1, f"{agree} of {PUSHES}, random supports and loads")
    even, steep = (_spread_ratio(ratio) for ratio in (1.0, STEEP))
    spreads = f"{float_text(steep, 3)} with axes 1 and {STEEP:g}, {float_text(even, 3)} with isotropic friction"
    claim = "anisotropic support friction makes motions converge: 1 where it alone narrows their spread"
    yield published(claim, MA, float(steep < NARROWED < even), 1, f"spread of motions over that of pushes: {spreads}")


def _spread_ratio(ratio: float) -> float:
    """Spread of directions of motion over that of forces through the centre of mass, about the axis of less friction.

    With half-axes 1 along and ``ratio`` across, ``f ~ (v_x, ratio^2 v_y)``: directions contract by ``ratio^-2``.
    """
    points = np.array([(1.0, 0.0), (-0.5, 0.9), (-0.5, -0.9)])
    contacts = Contacts(points, np.full(3, 1 / 3), np.diag([1.0, ratio]))
    forces = np.linspace(-SPREAD, SPREAD, 5)
    twists = [contacts.twist_of(np.array([np.cos(angle), np.sin(angle), 0.0])) for angle in forces]
    motions = np.array([np.arctan2(twist[1], twist[0]) for twist in twists])
    return float(np.ptp(motions) / np.ptp(forces))
