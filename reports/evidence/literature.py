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

from nonsmooth.analysis.continuum.prediction import predict
from nonsmooth.analysis.pushes.contacts import Contacts, push
from nonsmooth.proofs.answers.answers import full_answers
from nonsmooth.proofs.theorem4 import check_theorem4
from nonsmooth.proofs.verified import verified
from nonsmooth.reports.equilibrium_headings import headings_record
from nonsmooth.reports.evidence.claim import Claim, published
from nonsmooth.reports.evidence.force_fields import LARGE, SMALL, TRIANGLE, centred, linear_moment, stable_headings
from nonsmooth.reports.exact_record import Record
from nonsmooth.reports.records import check_record
from nonsmooth.symbolic.continuum import ContinuousField
from nonsmooth.symbolic.files.body_table import rectangle
from nonsmooth.symbolic.files.scene_file import build_scene, load_scene
from nonsmooth.symbolic.number_text import float_text
from nonsmooth.symbolic.numbers.number_field import NumberField

BOHRINGER = "Bohringer, Donald, Kavraki and Lamiraux 2000 (abstract; the fields from memory)"
SUDSANG = "Sudsang and Kavraki 2001 (from memory)"
LUNTZ = "Luntz, Messner and Choset 2001 (abstract)"
MURPHEY_2001 = "Murphey and Burdick 2001 (the paper)"
MURPHEY_2004 = "Murphey and Burdick 2004 (from memory)"
MA = "Ma and Rodriguez 2018 (abstract)"
MASON = "Mason 1986 (from memory)"
PUSHES = 100  # random ones
SEED = 1986
STEEP = 2.0  # ratio of the axes of an anisotropic friction
NARROWED = 0.9  # ratio of spreads below which they are narrowed
SPREAD = math.radians(10)  # of the directions of a push
ELLIPTIC_BED: dict[str, Any] = {
    "name": "box on an elliptic 6 x 6",
    "friction": {"mu_roll": 1, "mu_side": "1/2"},
    "grid": {"rows": 6, "columns": 6},
    "field": {"kind": "elliptic", "a": 1, "b": 2},
    "body": {"shape": "rectangle", "width": "37/10", "height": "8/5"},
    "contact": {"rule": "ellipse"},
    "check": {"radius": "1/5", "length": 1},
}


def literature_claims() -> Iterator[Claim]:
    """All rows, in the order of the page."""
    yield from _force_fields()
    yield from _discrete_wheels()
    yield from _distributed_manipulation()
    yield from _pushing()


# ---- programmable force fields -------------------------------------------------------------------


def _force_fields() -> Iterator[Claim]:
    part = centred(TRIANGLE)
    for constant, size in ((SMALL, "a small constant"), (LARGE, "any constant (the paper says small)")):
        found = stable_headings(part, constant)
        witness = f"triangle, constant {constant} of the unit field: {_degrees(found)}; sampled at 360 headings"
        yield published(f"a unit radial field plus {size}: stable poses of a part", BOHRINGER, len(found), 1, witness)
    alone = predict(_field(1, 1, speed=1), _box())
    claim = "a unit radial field alone orients nothing: stable headings"
    yield published(claim, BOHRINGER, len(alone.headings), 0, alone.reason)
    elliptic = predict(_field(1, 2, speed=None), _box())
    stable = [heading.theta + turn for heading in elliptic.headings if heading.stable for turn in (0, math.pi)]
    claim = "an elliptic field leaves two stable headings of a part, half a turn apart"
    yield published(claim, BOHRINGER, len(stable), 2, f"box 2 x 1: {_degrees(stable)}, from exact second moments")
    moments = [linear_moment(part, *heading) for heading in _rational_headings()]
    claim = "a linear radial field plus a constant has one stable pose for a part: headings that are attracted"
    witness = f"exact moment at rest {max(map(abs, moments))} at {len(moments)} rational headings: every heading rests"
    yield published(claim, SUDSANG, float(any(moments)), 1, witness)


def _field(a: int, b: int, speed: int | None) -> ContinuousField:
    numbers = NumberField()
    zero = numbers.zero
    matrix = ((numbers.rational(-a), zero), (zero, numbers.rational(-b)))
    return ContinuousField("test", matrix, None if speed is None else numbers.rational(speed), (zero, zero))


def _box() -> Any:
    numbers = NumberField()
    return rectangle(numbers.rational(2), numbers.rational(1))


def _rational_headings() -> list[tuple[Fraction, Fraction]]:
    """Cosines and sines of eight headings by Pythagorean triples."""
    triples = ((3, 4, 5), (5, 12, 13), (8, 15, 17), (7, 24, 25))
    return [(sign * Fraction(a, c), Fraction(b, c)) for a, b, c in triples for sign in (1, -1)]


def _degrees(angles: list[float]) -> str:
    return ", ".join(f"{float_text(math.degrees(angle), 4)} deg" for angle in sorted(angles))


# ---- discrete wheels -----------------------------------------------------------------------------


def _discrete_wheels() -> Iterator[Claim]:
    scene = build_scene(ELLIPTIC_BED, str(ELLIPTIC_BED["name"]), Path("elliptic-bed.toml"))
    headings = full_answers(verified(check_theorem4(scene)), ask_others=False).headings
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


def _distributed_manipulation() -> Iterator[Claim]:
    held, odd = _checked("four-wheel"), _checked("off-center")
    theorem, pose = held["theorem4"], held["answers"]["pose"]
    rate = -float(held["translation"]["worst_rate"])
    witness = f"V* <= -{float_text(rate)} |c|, proved"
    claim = "Theorem 4 on its own array (four-wheel): 1 where it holds"
    yield published(claim, MURPHEY_2001, float(theorem["verdict"] == "holds"), 1, witness)
    other = odd["theorem4"]
    claim = "Theorem 4 for every planar array: 1 where it holds for off-center"
    yield published(claim, MURPHEY_2001, float(other["verdict"] == "holds"), 1, other["reason"])
    drift = held["rotation"]["drift"]
    claim = "no open loop of constant speeds attracts the heading: 1 where the heading is not attracted"
    witness = f"at rest in (x, y) the body may turn at {float_text(drift[0])} to {float_text(drift[1])}"
    yield published(claim, MURPHEY_2004, float(held["rotation"]["verdict"] == "unstable"), 1, witness)
    claim = "feedback with two inputs at a time holds all three coordinates (four-wheel): 1 where it does"
    witness = f"certified law, kappa {float_text(held['feedback']['rate'])}"
    yield published(claim, MURPHEY_2004, float(pose["verdict"] == "can be held"), 1, witness)
    drive = _checked("differential-drive")["answers"]["pose"]
    claim = "feedback holds underactuated arrays, read as all of them: 1 where it holds differential-drive"
    yield published(claim, MURPHEY_2004, float(drive["verdict"] == "can be held"), 1, drive["reason"])


def _checked(name: str) -> Record:
    """The record of a verified check of a built-in scene."""
    return check_record(verified(check_theorem4(load_scene(name))))


# ---- pushing -------------------------------------------------------------------------------------


def _pushing() -> Iterator[Claim]:
    agree = sum(map(_votes_tell, np.random.default_rng(SEED).spawn(PUSHES)))
    claim = "both edges of the tip's friction cone and the push vote on the sense of rotation: share of random pushes"
    yield published(claim, MASON, agree / PUSHES, 1, f"{agree} of {PUSHES}, random supports and loads")
    even, steep = (_spread_ratio(ratio) for ratio in (1.0, STEEP))
    spreads = f"{float_text(steep, 3)} with axes 1 and {STEEP:g}, {float_text(even, 3)} with isotropic friction"
    claim = "anisotropic support friction makes motions converge: 1 where it alone narrows their spread"
    yield published(claim, MA, float(steep < NARROWED < even), 1, f"spread of motions over that of pushes: {spreads}")


def _votes_tell(rng: np.random.Generator) -> bool:
    """Whether the majority of Mason's votes is the sense of rotation of one random push."""
    loads, points = rng.dirichlet(np.ones(3)), rng.normal(size=(3, 2))
    angle = rng.uniform(0, 2 * np.pi)
    aside = angle + rng.uniform(-1.2, 1.2)
    normal, velocity = (np.array([np.cos(a), np.sin(a)]) for a in (angle, aside))
    point, friction = rng.normal(size=2), float(rng.uniform(0, 1))
    tangent = np.array([-normal[1], normal[0]])
    found = push(Contacts.isotropic(points - loads @ points, loads), point, normal, velocity, friction)
    voters = (normal + friction * tangent, normal - friction * tangent, velocity)
    votes = sum(np.sign(point[0] * voter[1] - point[1] * voter[0]) for voter in voters)
    return bool(np.sign(found.twist[2]) == np.sign(votes))


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
