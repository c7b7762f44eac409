"""Headings at which a body stops that turns on the spot: below such a heading it turns up to it, above back to it.

With the centre of mass at c0 the motions on both sides are ``(0, omega_-)`` and ``(0, omega_+)``; where their signs
differ, zero is a mixture of them, so the body rests with wheels under its edge.  What becomes of it:

- ``omega_- < 0 < omega_+``: both turn away, so the heading leaves.
- A set of wheels whose own motion takes its wheels farther under the body and the others farther out leads away, from
  wherever exactly these carry: what that motion moves leaves.
- One wheel under the edge: the slide is that of :mod:`nonsmooth.proofs.headings.isolated`, ``mu = -omega_2/omega_1``.
- Two wheels under opposite edges of a body and an array that a half turn about c0 takes into themselves: they come
  under the edge at one heading, exactly.  The fields ``f_S`` of the four sets, with the rates ``r_S = (nu_1 . xi_S,
  nu_2 . xi_S)``, mix to slides along the tangent tau of the edges, ``sum w_S r_S = 0``, at one heading.  If every
  ``r_S`` points to both surfaces, ``|g_1| + |g_2|`` falls at a rate bounded below, whatever the mixture, so bodies
  nearby come to slide on both within finite time.  The velocities of these slides, ``m = sum w_S tau . c'_S``, fill
  the interval between those of basic solutions (three sets at most).  At c0 all of them vanish: by the symmetry
  ``c'_0 = c'_12 = 0`` and ``c'_1 = -c'_2``, and ``n . c'_1 != 0`` makes ``w_1 = w_2``.  Where ``dm/ds < 0`` along tau
  for every basic solution that is feasible at c0, every slide leads back to c0: place and heading return.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

from flint import arb, arb_mat, ctx

from nonsmooth.proofs.headings.ball_motion import UndecidedMotionError
from nonsmooth.proofs.headings.heading_intervals import HeadingsAt, RestInterval, Wheels
from nonsmooth.proofs.headings.pose_slides import Fate, Fates, driven_off, edge_rate, fates_of_slide, slide
from nonsmooth.proofs.headings.set_motion import EnclosedMotion
from nonsmooth.proofs.headings.stay import Stays, is_half_turned
from nonsmooth.symbolic.body import Body
from nonsmooth.symbolic.edge_headings import BallVector, HeadingCluster, ball_of
from nonsmooth.symbolic.numbers.enclosures import PRECISION
from nonsmooth.symbolic.plane import dot
from nonsmooth.symbolic.scene import Scene

OPPOSITE = 2  # wheels under the edge whose slide is decided


@dataclass(frozen=True)
class TurnedBack:
    """A heading of rest between two intervals in which the body turns on the spot.

    Attributes:
        scene: all wheels, with the body at the point, at the checked heading.
        cluster: the heading, and the wheels under the edge.
        inside: numbers of the wheels well under the body.
        turning: signs of the rotation rate below and above.
        position: what becomes of the place.
        heading: what becomes of the heading.
        reason: why something is not decided; empty where all is.
    """

    scene: Scene
    cluster: HeadingCluster
    inside: Wheels
    turning: tuple[int, int]
    position: Fate
    heading: Fate
    reason: str = ""

    @property
    def edge(self) -> Wheels:
        """Numbers of the wheels under the edge."""
        return tuple(self.scene.wheels[k].index for k in self.cluster.wheels)

    def check(self) -> bool:
        """Decide again on both sides, and what follows."""
        here = HeadingsAt(self.scene, self.scene.check.equilibrium)
        with ctx.workprec(PRECISION):
            sets = [here.carrying(self.cluster.theta + shift) for shift in _beside(here, self.cluster)]
            stays = [None if wheels is None else here.stays.on(wheels) for wheels in sets]
            signs = tuple(stay.turning for stay in stays if stay is not None and stay.kind is Stays.TURNS)
            again = turned_back(here, self.cluster, self.inside, self.turning)
        return signs == self.turning and (again.position, again.heading) == (self.position, self.heading)


def _beside(here: HeadingsAt, cluster: HeadingCluster) -> tuple[arb, arb]:
    """Small shifts into the intervals below and above a cluster."""
    turn = 2 * arb.pi()
    others = [one.theta + k * turn for one in here.clusters() for k in (-1, 0, 1)]
    below = min((cluster.theta - one for one in others if one < cluster.theta), key=lambda d: float(d.mid()))
    above = min((one - cluster.theta for one in others if one > cluster.theta), key=lambda d: float(d.mid()))
    return -below / 5, above / 5


def is_one_heading(here: HeadingsAt, cluster: HeadingCluster) -> bool:
    """Whether the wheels of a cluster lie under the edge at one heading, exactly: one wheel, or two by a half turn."""
    body = here.scene.body
    if len(cluster.edges) == 1:
        return True
    if body is None or len(cluster.edges) != OPPOSITE or len(cluster.wheels) != OPPOSITE or not is_even(body):
        return False
    first, second = (here.scene.wheels[k].position for k in cluster.wheels)
    point = here.scene.check.equilibrium
    return all(a + b == c + c for a, b, c in zip(first, second, point, strict=True))


def is_even(body: Body) -> bool:
    """Whether a half turn about the centre of mass takes the outline into itself."""
    corners = body.vertices
    return bool(corners) and all(any(a == -x and b == -y for a, b in corners) for x, y in corners)


def turned_back(here: HeadingsAt, cluster: HeadingCluster, inside: Wheels, turning: tuple[int, int]) -> TurnedBack:
    """What becomes of a body at one heading at which the turns of both sides meet."""
    reason = ""
    if turning[0] < 0:
        fates = Fate.UNDECIDED, Fate.LEAVES
        reason = "what becomes of its place is not decided"
    else:
        try:
            fates = _fates(here, cluster, inside)
        except (UndecidedMotionError, ZeroDivisionError) as error:
            fates, reason = (Fate.UNDECIDED, Fate.UNDECIDED), str(error)
    return TurnedBack(here.scene, cluster, inside, turning, *fates, reason)


def meets(below: RestInterval, above: RestInterval) -> tuple[int, int] | None:
    """Signs of the rotation rates on both sides of a heading where they differ; else None."""
    signs = below.stay.turning, above.stay.turning
    turns = below.stay.kind is Stays.TURNS and above.stay.kind is Stays.TURNS
    return signs if turns and signs[0] * signs[1] < 0 else None


def _fates(here: HeadingsAt, cluster: HeadingCluster, inside: Wheels) -> Fates:
    edges = cluster.edges
    normals = [here.outline.outward(edge.side, here.places[edge.wheel], cluster.theta) for edge in edges]
    at = [tuple(ball_of(entry) for entry in here.scene.wheels[edge.wheel].position) for edge in edges]
    rates = [edge_rate(normal, (x, y)) for normal, (x, y) in zip(normals, at, strict=True)]
    numbers = [here.scene.wheels[edge.wheel].index for edge in edges]
    if len(edges) == 1:
        sets = [here.stays.motion(_union(inside, some)) for some in ([], numbers)]
        return _under_one(sets[0], sets[1], rates[0], normals[0])
    every = [wheel for wheel in here.scene.wheels if wheel.index in _union(inside, numbers)]
    if not is_half_turned(every, here.scene.check.equilibrium):
        raise UndecidedMotionError("wheels that a half turn about the point does not take into themselves")
    subsets = [[], numbers[:1], numbers[1:], numbers]
    return _under_two([here.stays.motion(_union(inside, some)) for some in subsets], rates, normals[0])


def _union(inside: Wheels, some: list[int]) -> Wheels:
    return tuple(sorted((*inside, *some)))


def _under_one(without: EnclosedMotion, including: EnclosedMotion, rate: arb_mat, normal: BallVector) -> Fates:
    """The slide under one wheel."""
    if not ((rate * without.twist)[0, 0] > 0 and (rate * including.twist)[0, 0] < 0):
        raise UndecidedMotionError("motions that may run along the edge")
    weight = -without.omega / including.omega
    mixed = (without.slope + including.slope * weight) * (1 / (1 + weight))
    return fates_of_slide(slide(without.centre, without.twist, mixed, rate), normal)


def _under_two(sets: list[EnclosedMotion], rates: list[arb_mat], normal: BallVector) -> Fates:
    """The slides under two wheels, along the tangent of their edges.

    Raises:
        UnprovedError: where signs do not decide.
    """
    for k, motion in enumerate(sets):
        depths = [(rate * motion.twist)[0, 0] * (-1 if k >> bit & 1 else 1) for bit, rate in enumerate(rates)]
        if all(depth < 0 for depth in depths):
            return driven_off(motion.velocity, motion.omega)
        if not all(depth > 0 for depth in depths):
            raise UndecidedMotionError("motions that do not all lead to both edges")
    if dot(normal, sets[1].velocity).contains(0):
        raise UndecidedMotionError("motions that may run along the edge")
    growths = [growth for three in combinations(sets, 3) for growth in _growth(list(three), rates, normal)]
    if all(growth < 0 for growth in growths):
        return Fate.RETURNS, Fate.RETURNS
    if all(growth > 0 for growth in growths):
        return Fate.LEAVES, Fate.UNDECIDED
    raise UndecidedMotionError("slides along the edges that do not all lead to the point")


def _growth(sets: list[EnclosedMotion], rates: list[arb_mat], normal: BallVector) -> list[arb]:
    """``dm/ds`` of the mixture of three sets that keeps both wheels under the edge; none where a weight is negative."""
    tangent = arb_mat([[-normal[1]], [normal[0]]])
    across = tangent.transpose()
    zero = arb(0)
    balance = arb_mat([[arb(1)] * 3, *[[(rate * one.twist)[0, 0] for one in sets] for rate in rates]])
    moved = arb_mat([[zero] * 3, *[[(rate * one.slope * tangent)[0, 0] for one in sets] for rate in rates]])
    speeds = arb_mat([[dot((tangent[0, 0], tangent[1, 0]), one.velocity) for one in sets]])
    faster = arb_mat([[(across * one.linearized * tangent)[0, 0] for one in sets]])
    inverse = balance.inv()
    weights = inverse * arb_mat([[arb(1)], [zero], [zero]])
    if any(weight < 0 for weight in weights.entries()):
        return []
    return [((faster - speeds * inverse * moved) * weights)[0, 0]]
