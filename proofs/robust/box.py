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
from fractions import Fraction
from typing import TypeAlias

import numpy as np
from flint import arb, ctx

from nonsmooth.proofs.boxes.load_box import load_box
from nonsmooth.proofs.robust.annulus import AnnulusPiece, Place, polygon_about
from nonsmooth.proofs.robust.box_bound import BoxBound
from nonsmooth.proofs.robust.box_corners import BoxCorners, Proposal
from nonsmooth.proofs.robust.box_wheel import box_wheels
from nonsmooth.proofs.robust.rings import PRECISION, RingProof
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.mechanics.tolerances import Tolerance
from nonsmooth.symbolic.numbers.coefficients import as_fmpq
from nonsmooth.symbolic.numbers.enclosures import rational_below

# of the friction of all wheels; strong ones serve large boxes
PUSHES = (0.75, 0.6, 0.45, 0.3, 0.2, 0.1, 0.05, 0.02)
REST_CORNERS = 16
REST_HALVINGS = 7


Plan: TypeAlias = tuple[tuple[float, float, float], list[float]]  # a twist, and strengths of pushes


class BoxRingProof(RingProof[BoxBound]):
    """A centred scene under rule ``box``; what floats propose for the scene is kept for all boxes about it."""

    def __init__(self, scene: Scene) -> None:
        """For a scene whose loads are known."""
        self._scene = scene
        self._corners = BoxCorners(scene)
        self._plans: dict[AnnulusPiece, Plan] = {}
        self._proposals: dict[tuple[AnnulusPiece, float], list[Proposal | None]] = {}

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

    def rates(self, bound: BoxBound, pieces: Sequence[AnnulusPiece], *, at_any: bool) -> Iterator[arb | None]:
        """By the bounds at their corners, one after the other; the first push that proves a positive one, for both."""
        for piece in pieces:
            twist, strengths = self._plan(piece)
            rates = (self._proved(bound, piece, twist, strength) for strength in strengths)
            yield next((rate for rate in rates if rate is not None), None)

    def _proved(
        self, bound: BoxBound, piece: AnnulusPiece, twist: tuple[float, float, float], strength: float
    ) -> arb | None:
        """The rate that the bounds at the corners of a quadrangle prove; None where it is not positive."""
        key, xi, push, rates = (piece, strength), [arb(entry) for entry in twist], arb(strength), []
        if key not in self._proposals:
            self._proposals[key] = [self._proposal(_floats(corner), strength) for corner in piece.corners]
        for corner, proposal in zip(piece.corners, self._proposals[key], strict=True):
            x, y = _balls(corner)
            gap = None if proposal is None else bound.gap(proposal, (x, y), [push * x, push * y, arb(0)], xi)
            if gap is None:
                return None
            rates.append(-((x * xi[0] + y * xi[1]) + gap / push) / (x * x + y * y).sqrt())
            if not rates[-1] > 0:
                return None
        return min(rates, key=rational_below)

    # ---- what floats propose

    def _plan(self, piece: AnnulusPiece) -> Plan:
        """The twist of the middle of a quadrangle, and the pushes that promise a negative rate."""
        if piece not in self._plans:
            corners = [_floats(corner) for corner in piece.corners]
            middle = np.mean(corners, axis=0)
            twist, _ = self._corners.least(middle.tolist(), np.zeros(3))
            unit = float(self._corners.limits(middle.tolist()).sum()) / 2 / float(np.hypot(*middle))
            strengths = [share * unit for share in PUSHES]
            v_x, v_y, spin = twist.tolist()
            slow = [strength for strength in strengths if self._promise(corners, twist, strength) < 0]
            self._plans[piece] = (v_x, v_y, spin / self._corners.length), slow
        return self._plans[piece]

    def _promise(self, corners: list[tuple[float, float]], twist: np.ndarray, strength: float) -> float:
        """About the largest ``c . v/|c|`` that follows at the middle of the box."""
        rates = []
        for x, y in corners:
            _, value = self._corners.least((x, y), strength * np.array([x, y, 0.0]))
            rates.append((self._corners.dissipation((x, y), twist) - value) / strength / float(np.hypot(x, y)))
        return max(rates)

    def _proposal(self, place: tuple[float, float], strength: float) -> Proposal | None:
        push = strength * np.array([*place, 0.0])
        twist, _ = self._corners.least(place, push)
        return self._corners.proposal(place, push, twist)


def _floats(place: Place) -> tuple[float, float]:
    return float(place[0]), float(place[1])


def _balls(place: Place) -> list[arb]:
    return [arb(as_fmpq(entry)) for entry in place]
