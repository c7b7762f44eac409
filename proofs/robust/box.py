"""Rule ``box`` over a box of parameters: where every body stays at rest, and where every body comes nearer.

At rest no side row of any array slips, so that ``xi = 0`` is the only minimizer wherever forces within their limits,
those of the side rows not at them, balance those of the rims.  The places where they do are a convex set: corners
decide.

Outside a disc ``c . v <= -kappa |c|`` is shown on quadrangles, by :mod:`nonsmooth.proofs.robust.box_bound` at their
corners: |c| is convex, and the bound is a mixture of those at the corners.  Then ``(c . c)' = 2 c . v`` as under rule
``nearest``.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from flint import arb, ctx

from nonsmooth.proofs.robust.annulus import AnnulusPiece, Place, polygon_about
from nonsmooth.proofs.robust.box_bound import BoxBound
from nonsmooth.proofs.robust.box_corners import BoxCorners, Proposal
from nonsmooth.proofs.robust.box_wheel import box_wheels
from nonsmooth.proofs.robust.load_box import load_box
from nonsmooth.proofs.robust.rings import PRECISION, RingProof
from nonsmooth.symbolic.numbers.coefficients import as_fmpq
from nonsmooth.symbolic.numbers.enclosures import rational_below
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.tolerances import Tolerance

# of the friction of all wheels; strong ones serve large boxes
PUSHES = (0.75, 0.6, 0.45, 0.3, 0.2, 0.1, 0.05, 0.02)
REST_CORNERS = 16
REST_HALVINGS = 7


@dataclass(frozen=True)
class _Push:
    """What may be tried on a quadrangle.

    Attributes:
        strength: lambda.
        rate: about the largest ``c . v/|c|`` that follows at the middle of the box.
    """

    strength: float
    rate: float


@dataclass(frozen=True)
class _Plan:
    """A twist for a quadrangle, and the pushes that promise a negative rate."""

    twist: tuple[float, float, float]
    distance: float
    pushes: tuple[_Push, ...]


class BoxRingProof(RingProof[BoxBound]):
    """A centred scene under rule ``box``; what floats propose for the scene is kept for all boxes about it."""

    def __init__(self, scene: Scene) -> None:
        """For a scene whose loads are known."""
        self._scene = scene
        self._corners = BoxCorners(scene)
        self._plans: dict[AnnulusPiece, _Plan] = {}
        self._proposals: dict[tuple[AnnulusPiece, float], tuple[Proposal, ...] | None] = {}

    # ---- rest

    def rest_radius(self, box: Tolerance, most: Fraction) -> Fraction:
        """Nearly the largest radius, up to ``most``, of a disc in which bodies stay at rest; 0 where there is none."""
        with ctx.workprec(PRECISION):
            bound = self.over(box)
            if bound is None:
                return Fraction(0)
            if self._rests(bound, most):
                return most
            low, high = Fraction(0), most
            for _ in range(REST_HALVINGS):
                middle = (low + high) / 2
                low, high = (middle, high) if self._rests(bound, middle) else (low, middle)
            return low

    def over(self, box: Tolerance) -> BoxBound | None:
        """The bounds of a box; None where its springs may not fix the loads."""
        loads = load_box(self._scene, box.position.ball())
        return None if loads is None else BoxBound(box_wheels(self._scene, box), loads, self._corners.length)

    def _rests(self, bound: BoxBound, radius: Fraction) -> bool:
        """Whether bodies rest all over a disc, by a polygon about it."""
        zero, still = np.zeros(3), [arb(0)] * 3
        for corner in polygon_about(radius, REST_CORNERS):
            proposal = self._corners.proposal(_floats(corner), zero, zero)
            gap = None if proposal is None else bound.gap(proposal, _balls(corner), still, still)
            if gap is None or not gap <= 0:
                return False
        return True

    # ---- coming nearer

    def rates(self, bound: BoxBound, pieces: Sequence[AnnulusPiece]) -> Iterator[arb | None]:
        """By the bounds at their corners, one after the other."""
        for piece in pieces:
            yield self._rate_at_corners(bound, piece)

    def _rate_at_corners(self, bound: BoxBound, piece: AnnulusPiece) -> arb | None:
        plan = self._plan(piece)
        for push in plan.pushes:
            proposals = self._proposed(piece, push)
            rate = None if proposals is None else _proved(bound, piece, plan, push, proposals)
            if rate is not None:
                return rate
        return None

    # ---- what floats propose

    def _plan(self, piece: AnnulusPiece) -> _Plan:
        """The twist of the middle of a quadrangle, and what pushes promise."""
        if piece not in self._plans:
            corners = [_floats(corner) for corner in piece.corners]
            middle = np.mean(corners, axis=0)
            distance = float(np.hypot(*middle))
            twist, _ = self._corners.least(middle.tolist(), np.zeros(3))
            total = float(self._corners.limits(middle.tolist()).sum()) / 2
            pushes = tuple(self._promise(corners, twist, share * total / distance) for share in PUSHES)
            v_x, v_y, spin = twist.tolist()
            slow = tuple(push for push in pushes if push.rate < 0)
            self._plans[piece] = _Plan((v_x, v_y, spin / self._corners.length), distance, slow)
        return self._plans[piece]

    def _promise(self, corners: list[tuple[float, float]], twist: np.ndarray, strength: float) -> _Push:
        rates = []
        for x, y in corners:
            _, value = self._corners.least((x, y), strength * np.array([x, y, 0.0]))
            rates.append((self._corners.dissipation((x, y), twist) - value) / strength / float(np.hypot(x, y)))
        return _Push(strength, max(rates))

    def _proposed(self, piece: AnnulusPiece, push: _Push) -> tuple[Proposal, ...] | None:
        key = piece, push.strength
        if key not in self._proposals:
            found = [self._proposal(_floats(corner), push.strength) for corner in piece.corners]
            several = tuple(proposal for proposal in found if proposal is not None)
            self._proposals[key] = several if len(several) == len(found) else None
        return self._proposals[key]

    def _proposal(self, place: tuple[float, float], strength: float) -> Proposal | None:
        push = strength * np.array([*place, 0.0])
        twist, _ = self._corners.least(place, push)
        return self._corners.proposal(place, push, twist)


def _proved(
    bound: BoxBound, piece: AnnulusPiece, plan: _Plan, push: _Push, proposals: tuple[Proposal, ...]
) -> arb | None:
    """The rate that the bounds at the corners of a quadrangle prove; None where it is not positive."""
    twist, strength = [arb(entry) for entry in plan.twist], arb(push.strength)
    rates = []
    for corner, proposal in zip(piece.corners, proposals, strict=True):
        place = _balls(corner)
        gap = bound.gap(proposal, place, [strength * place[0], strength * place[1], arb(0)], twist)
        if gap is None:
            return None
        size = (place[0] * place[0] + place[1] * place[1]).sqrt()
        rates.append(-((place[0] * twist[0] + place[1] * twist[1]) + gap / strength) / size)
        if not rates[-1] > 0:
            return None
    return min(rates, key=rational_below)


def _floats(place: Place) -> tuple[float, float]:
    return float(place[0]), float(place[1])


def _balls(place: Place) -> list[arb]:
    return [arb(as_fmpq(entry)) for entry in place]
