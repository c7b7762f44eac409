"""Feedback by imposed twists, the law computed from the scene, the true array anywhere within its tolerances.

The law commands multiples of three twists ``xi_m``, by the rims' speeds of the scene.  Under these speeds every
minimizer xi of every array of the box satisfies ``|xi - xi_m| <= rho`` (rule ``box``: bounds of ``+-e_k . xi`` by
:mod:`nonsmooth.proofs.robust.box`; rules with friction sets: below), and so do multiples, for D is homogeneous in twist
and speeds.  With
``g = (c, l theta)``, ``V = |g|^2`` and the xi_m of the largest ``x = |g . xi_m|/|g| >= sqrt(kappa)``::

    V'/2 = -k (g . xi_m)(g . xi) <= -k (x^2 - rho x) |g|^2 <= -k sqrt(kappa) (sqrt(kappa) - rho) V.

So wherever ``rho < sqrt(kappa)`` every array brings position and heading home, exactly to the point: what is wrong with
the array is wrong in proportion to what is commanded.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from flint import arb, ctx

from nonsmooth.proofs.boxes.balanced_forces import LoadBox, Triple, load_box
from nonsmooth.proofs.boxes.enclosures import UNIT
from nonsmooth.proofs.boxes.intervals import Intervals
from nonsmooth.proofs.clauses.feedback.driven_law import rim_speeds
from nonsmooth.proofs.findings import Feedback
from nonsmooth.proofs.robust.box import BoxBound, box_wheels
from nonsmooth.proofs.robust.plane_minimum import MAX_WHEELS, BoxCorners
from nonsmooth.proofs.robust.smooth_rules import FOLLOWED, ArrayBox, PieceForces, force_law
from nonsmooth.symbolic.mechanics.contact_states import with_rims_along_axes
from nonsmooth.symbolic.mechanics.scene import Scene, Tolerance
from nonsmooth.symbolic.mechanics.similar_scenes import in_own_length
from nonsmooth.symbolic.numbers.coefficients import rational_ball
from nonsmooth.symbolic.numbers.enclosures import rational_below
from nonsmooth.symbolic.numbers.plane_arrays import Floats, max_norm

if TYPE_CHECKING:
    from nonsmooth.proofs.clauses.feedback.clause import AnyFeedback
    from nonsmooth.proofs.clauses.feedback.driven_law import LawCone
    from nonsmooth.proofs.clauses.feedback.twist_candidates import ImposedTwist
    from nonsmooth.symbolic.numbers.number import Number

PRECISION = 64  # bits of the balls
PUSHES = (0.6, 0.45, 0.3, 0.2, 0.1, 0.05, 0.02)  # of the friction of all wheels
ONE_PAIR = (
    "near the point the law drives one pair of wheels at a time, and within the tolerances another pair may carry there"
)
NEARBY = 1 - Fraction(1, 2**20)  # of a rate at the point: it holds near the point too
STILL = Fraction(0)


@dataclass(frozen=True)
class RobustLoop:
    """What feedback does for every array.

    Attributes:
        rate: kappa with ``V' <= -2 k kappa V`` near the point for every array; None where none is proved.
        reason: why not, else empty.
    """

    rate: Fraction | None
    reason: str = ""


def decide_robust_loop(scene: Scene, feedback: AnyFeedback) -> RobustLoop | None:
    """Whether the law of a scene's feedback clause serves every array within the tolerances; None where it has none.

    Args:
        scene: with tolerances.
        feedback: its clause.
    """
    box = scene.tolerances
    if box is None or feedback.verdict is not Feedback.STABILIZABLE:
        return None
    cones: tuple[LawCone, ...] = getattr(feedback, "cones", ())
    reason = _why_not(scene, box, cones)
    if reason:
        return RobustLoop(None, reason)
    kappa = feedback.certified_kappa
    if kappa is None:
        return None
    centred = scene.recentred()
    if scene.contact.rule in FOLLOWED:
        rescaled = in_own_length(centred)
        shrunk = box.scaled(1 / scene.check.length)
        return _decided(rescaled, shrunk, kappa, partial(_smooth_error, rescaled, shrunk, cones[0], kappa))
    plain = with_rims_along_axes(centred)
    if plain is None or len(scene.wheels) > MAX_WHEELS:
        return RobustLoop(None, f"feedback is followed for up to {MAX_WHEELS} wheels driven along their friction axes")
    return _decided(plain, box, kappa, partial(_box_error, plain, box, cones[0]))


def _why_not(scene: Scene, box: Tolerance, cones: Sequence[LawCone]) -> str:
    """Why no law is followed; empty where it is."""
    if scene.contact.rule not in ("box", *FOLLOWED):
        return ONE_PAIR
    if scene.contact.loads_are_unknown:
        return "the loads are not known"
    if box.centre_of_mass:
        return "the law measures the pose at the centre of mass, and that is not known exactly"
    if len(cones) != 1:
        return "frictions balance exactly at the point, and within the tolerances they do not"
    return ""


def _box_error(scene: Scene, box: Tolerance, cone: LawCone, number: int, loads: LoadBox) -> arb | None:
    """Under rule ``box``."""
    return _CommandedTwist(scene, box, loads, cone.vectors[number]).error()


def _smooth_error(
    scene: Scene, box: Tolerance, cone: LawCone, kappa: Fraction, number: int, loads: LoadBox
) -> arb | None:
    """Under the rules ``ellipse``, ``roller`` and ``mixed``."""
    return distance_of_minimizers(scene, box, loads, cone.twists[number], math.sqrt(kappa))


def _decided(
    scene: Scene, box: Tolerance, kappa: Fraction, error_of: Callable[[int, LoadBox], arb | None]
) -> RobustLoop:
    """From the errors of the three twists."""
    with ctx.workprec(PRECISION):
        loads = load_box(scene, box.position.ball())
        if loads is None or not all(load > 0 for load in loads.at((arb(0), arb(0)))):
            return RobustLoop(None, "a wheel may lift off at the point")
        errors = [error_of(number, loads) for number in range(3)]
        bounds = [error for error in errors if error is not None]
        if len(bounds) < len(errors):
            return RobustLoop(None, "a twist that the law commands may slip away within the tolerances")
        root = (rational_ball(kappa)).sqrt()
        slowest = min((root * (root - error) for error in bounds), key=rational_below)
        if not slowest > 0:
            return RobustLoop(None, "twists may differ from those that the law commands by more than its rate allows")
        return RobustLoop(rational_below(slowest) * NEARBY)


class _CommandedTwist:
    """One twist of the law: the array with the speeds that command it."""

    def __init__(self, scene: Scene, box: Tolerance, loads: LoadBox, twist: Sequence[Number]) -> None:
        """For a twist in the unit l of the scene."""
        self._length = rational_ball(scene.check.length)
        x, y, turn = (entry.ball() for entry in twist)
        self._twist = x, y, turn / self._length
        speeds = [wheel.moved(self._twist)[0] for wheel in box_wheels(scene, box.times(STILL))]
        drive = 1 + box.speed.ball() * UNIT
        pairs = zip(box_wheels(scene, box), speeds, strict=True)
        wheels = [replace(wheel, speeds=(speed * drive, arb(0))) for wheel, speed in pairs]
        self._corners = BoxCorners(scene)
        self._corners.speeds = np.array([[float(speed), 0.0] for speed in speeds]).ravel()
        self._bound = BoxBound(wheels, loads, self._corners.length)

    def error(self) -> arb | None:
        """A bound of ``|xi - xi_m|`` in the unit l, for every minimizer of every array; None where none is shown."""
        total = arb(0)
        for k in range(3):
            sides = [self._one_side(k, sense) for sense in (1, -1)]
            bounds = [side for side in sides if side is not None]
            if len(bounds) < len(sides):
                return None
            total += max(bounds, key=lambda ball: float(ball.upper())).upper() ** 2
        return total.sqrt()

    def _one_side(self, k: int, sense: int) -> arb | None:
        """The least bound of ``sense e_k . (xi - xi_m)`` that some push proves."""
        place = (arb(0), arb(0))
        force = float(self._corners.limits((0.0, 0.0)).sum()) / 2
        twist = np.array([*(float(x) for x in self._twist[:2]), float(self._twist[2]) * self._corners.length])
        bounds = []
        for share in PUSHES:
            strength = sense * share * force
            unit = [arb(0), arb(0), arb(0)]
            unit[k] = self._length if k == 2 else arb(1)
            push = np.array([strength * float(entry) for entry in unit])
            push[2] /= self._corners.length
            proposal = self._corners.proposal((0.0, 0.0), push, twist)
            if proposal is None:
                continue
            gap = self._bound.gap(proposal, place, [strength * entry for entry in unit], self._twist)
            if gap is not None:
                bounds.append(gap / abs(strength))
        return min(bounds, key=lambda ball: float(ball.upper())) if bounds else None


# ---- rules with friction sets --------------------------------------------------------------------
#
# Rules ``ellipse`` and ``roller``: how far the motion of any array of a box is from the twist that its speeds command.
#
# The speeds u that impose xi_m on the scene impose some other twist on an array within its tolerances.  On the border
# of a cube about xi_m let every subgradient g of D have ``g . (xi - xi_m) > 0``.  Then D increases outward there, and,
# being convex, has all its minimizers inside, for every array of the box at once.  The body is at the point.


SIDE_PARTS = 10  # of each edge of the cube
SHARES = (0.03, 0.06, 0.1, 0.15, 0.2, 0.3, 0.4, 0.55, 0.7, 0.9)  # of the largest distance that serves


def distance_of_minimizers(
    scene: Scene, box: Tolerance, loads: LoadBox, imposed: ImposedTwist, most: float
) -> arb | None:
    """A bound of ``|xi - xi_m|``, below ``most``, in the unit l of the scene; None where none is shown.

    Args:
        scene: centred, under rule ``ellipse``, ``roller`` or ``mixed``, with l for the unit of length.
        box: its tolerances.
        loads: of all its arrays.
        imposed: the twist, with the speeds that impose it.
        most: the largest bound that is of use.
    """
    arrays = ArrayBox(box_wheels(scene, box), loads, force_law(scene))
    forces = replace(PieceForces.at_point(arrays), speeds=_speeds(scene, box, imposed))
    middle = np.array([float(entry) for entry in imposed.twist])
    rounding = 2.0**-40 * (most + max_norm(middle))  # of the cube to floats
    for share in SHARES:
        half = share * most / np.sqrt(3)
        if _is_outward(forces, middle, half):
            return arb(half) * arb(3).sqrt() + arb(rounding)
    return None


def _speeds(scene: Scene, box: Tolerance, imposed: ImposedTwist) -> Intervals:
    """Along and across each wheel's friction axis: rims' speeds of the law, within their tolerance (wheels, 2)."""
    drive = 1 + box.speed.ball() * UNIT
    pairs = zip(scene.wheels, rim_speeds(scene, imposed), strict=True)
    return Intervals.about(
        [[(gain / wheel.grip_length).ball() * speed * drive for gain in wheel.gains] for wheel, speed in pairs]
    )


def _is_outward(forces: PieceForces, middle: Floats, half: float) -> bool:
    """Whether D increases outward all along the border of a cube about a twist."""
    ends = np.linspace(-1.0, 1.0, SIDE_PARTS + 1)
    part = Intervals(ends[:-1], ends[1:])
    first, second = np.indices((SIDE_PARTS, SIDE_PARTS)).reshape(2, -1)
    for k in range(3):
        for side in (-1.0, 1.0):
            offset = [Intervals.of(np.full(len(first), side)), part[first], part[second]]
            x, y, spin = (offset[(axis - k) % 3][None] * Intervals.of(half) for axis in range(3))
            if not _increases(forces, middle, (x, y, spin)):
                return False
    return True


def _increases(forces: PieceForces, middle: Floats, offset: Triple) -> bool:
    """``g . (xi - xi_m) > 0`` on parts of one side: along their middles, and what is left of them."""
    x, y, spin = (entry + Intervals.of(value) for entry, value in zip(offset, middle, strict=True))
    pulls = forces.forces((x, y, spin))
    a, b, c = (Intervals.of(entry.middle) for entry in offset)
    power = forces.power(pulls, (a, b, c))
    for entry, centre, pull in zip(offset, (a, b, c), forces.wrench(pulls), strict=True):
        power = power + (entry - centre) * pull
    return bool((power.low > 0).all())
