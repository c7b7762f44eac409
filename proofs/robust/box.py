"""Rule ``box`` over a box of parameters: where every body stays at rest, and where every body comes nearer.

At rest no side row of any array slips, so that ``xi = 0`` is the only minimizer wherever forces within their limits,
those of the side rows not at them, balance those of the rims.  The places where they do are a convex set: corners
decide.

Outside a disc ``c . v <= -kappa |c|`` is shown on quadrangles, by :mod:`nonsmooth.proofs.robust.box_bound` at their
corners: |c| is convex, and the bound is a mixture of those at the corners.  Then ``(c . c)' = 2 c . v`` as under rule
``nearest``.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from flint import arb, ctx

from nonsmooth.proofs.robust.annulus import Piece, Place, polygon_about, ring
from nonsmooth.proofs.robust.box_bound import BoxBound
from nonsmooth.proofs.robust.box_corners import BoxCorners, Proposal
from nonsmooth.proofs.robust.box_wheel import box_wheels
from nonsmooth.proofs.robust.load_box import load_box
from nonsmooth.symbolic.numbers.coefficients import as_fmpq
from nonsmooth.symbolic.numbers.enclosures import rational_below
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.tolerances import Tolerance

PRECISION = 64  # bits of the balls
RINGS = 16  # of equal width, from the square inward
DEPTH = 3  # how often a quadrangle is divided into four
HALVINGS = 5  # of the ring in which the disc ends
STARTS = tuple(Fraction(k, 16) for k in (16, 15, 14, 12, 10, 8))  # shares of the square from which bodies may start
PUSHES = (
    0.75,
    0.6,
    0.45,
    0.3,
    0.2,
    0.1,
    0.05,
    0.02,
)  # of the friction of all wheels; strong ones serve large boxes
GROWTH = Fraction(6, 5)  # of the least radius: what a faster rate may cost
REST_CORNERS = 16
REST_HALVINGS = 7


@dataclass(frozen=True)
class BoxDisc:
    """What holds for every array of the box.

    Attributes:
        radius: of the disc in which bodies end.
        start: radius of the disc of starts.
        kappa: rate at which the distance falls between the two (length/time).
    """

    radius: Fraction
    start: Fraction
    kappa: Fraction


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


class BoxRule:
    """A centred scene under rule ``box``; what floats propose for the scene is kept for all boxes about it."""

    def __init__(self, scene: Scene) -> None:
        """For a scene whose loads are known."""
        self._scene = scene
        self._corners = BoxCorners(scene)
        self._plans: dict[Piece, _Plan] = {}
        self._proposals: dict[tuple[Piece, float], tuple[Proposal, ...] | None] = {}

    # ---- rest

    def rest_radius(self, box: Tolerance, most: Fraction) -> Fraction:
        """Nearly the largest radius, up to ``most``, of a disc in which bodies stay at rest; 0 where there is none."""
        with ctx.workprec(PRECISION):
            bound = self._over(box)
            if bound is None:
                return Fraction(0)
            if self._rests(bound, most):
                return most
            low, high = Fraction(0), most
            for _ in range(REST_HALVINGS):
                middle = (low + high) / 2
                low, high = (middle, high) if self._rests(bound, middle) else (low, middle)
            return low

    def _over(self, box: Tolerance) -> BoxBound | None:
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

    def comes_nearer(self, box: Tolerance, most: Fraction) -> bool:
        """Whether on some ring within ``most`` of the point bodies come nearer."""
        with ctx.workprec(PRECISION):
            bound = self._over(box)
            return bound is not None and self._first_ring(bound, most) is not None

    def disc(self, box: Tolerance, most: Fraction) -> BoxDisc | None:
        """The disc in which bodies end that start in one of a radius up to ``most``; None where none is found."""
        with ctx.workprec(PRECISION):
            bound = self._over(box)
            first = None if bound is None else self._first_ring(bound, most)
            if bound is None or first is None:
                return None
            start, rate = first
            return _fastest(list(self._inward(bound, start, rate)), start)

    def _first_ring(self, bound: BoxBound, most: Fraction) -> tuple[Fraction, arb] | None:
        """The outer radius of the first ring on which bodies come nearer, and their rate there."""
        for share in STARTS:
            outer = most * share
            rate = self._rate(bound, outer * (1 - Fraction(1, RINGS)), outer)
            if rate is not None:
                return outer, rate
        return None

    def _inward(self, bound: BoxBound, start: Fraction, rate: arb) -> Iterator[tuple[Fraction, arb]]:
        """Inner radii of rings one after the other, and the rate on each; the last ones ever narrower."""
        inner, step, halvings = start * (1 - Fraction(1, RINGS)), start / RINGS, 0
        yield inner, rate
        while inner and halvings <= HALVINGS:
            found = self._rate(bound, inner - step, inner)
            if found is None:
                step, halvings = step / 2, halvings + 1
                continue
            inner -= step
            yield inner, found

    def _rate(self, bound: BoxBound, inner: Fraction, outer: Fraction) -> arb | None:
        """A positive kappa with ``c . v <= -kappa |c|`` on a ring; None where none is shown."""
        rates = []
        for piece in ring(inner, outer):
            rate = self._rate_on(bound, piece, DEPTH)
            if rate is None:
                return None
            rates.append(rate)
        return min(rates, key=rational_below)

    def _rate_on(self, bound: BoxBound, piece: Piece, depth: int) -> arb | None:
        """The same on a quadrangle, or on the four that it is divided into."""
        rate = self._rate_at_corners(bound, piece)
        if rate is not None or not depth:
            return rate
        rates = []
        for part in piece.parts:
            found = self._rate_on(bound, part, depth - 1)
            if found is None:
                return None
            rates.append(found)
        return min(rates, key=rational_below)

    def _rate_at_corners(self, bound: BoxBound, piece: Piece) -> arb | None:
        plan = self._plan(piece)
        for push in plan.pushes:
            proposals = self._proposed(piece, push)
            rate = None if proposals is None else _proved(bound, piece, plan, push, proposals)
            if rate is not None:
                return rate
        return None

    # ---- what floats propose

    def _plan(self, piece: Piece) -> _Plan:
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

    def _proposed(self, piece: Piece, push: _Push) -> tuple[Proposal, ...] | None:
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


def _proved(bound: BoxBound, piece: Piece, plan: _Plan, push: _Push, proposals: tuple[Proposal, ...]) -> arb | None:
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


def _fastest(found: list[tuple[Fraction, arb]], start: Fraction) -> BoxDisc:
    """Nearly the smallest disc, with the rate outside it that is largest."""
    radius = max(found[-1][0], Fraction(1, 2**20) * start)
    kept = [k for k, (inner, _) in enumerate(found) if inner <= GROWTH * radius] or [len(found) - 1]
    rates = {k: min(rational_below(rate) for _, rate in found[: k + 1]) for k in kept}
    best = max(kept, key=lambda k: (rates[k], -found[k][0]))
    return BoxDisc(found[best][0], start, rates[best])


def _floats(place: Place) -> tuple[float, float]:
    return float(place[0]), float(place[1])


def _balls(place: Place) -> list[arb]:
    return [arb(as_fmpq(entry)) for entry in place]
