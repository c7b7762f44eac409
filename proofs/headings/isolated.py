"""Poses at which a body rests with one wheel under its edge, proved in ball arithmetic, and whether they attract.

Let F_1 be the motion on the wheels well under the body, F_2 that with the wheel under the edge, xi_1 and xi_2 their
spatial twists at the centre of mass c.  Zero is a mixture of F_1 and F_2 iff ``xi_2 = -mu xi_1`` with ``mu > 0``, so ::

    G_1(xi_1, c) = 0,      G_2(-mu xi_1, c) = 0

are six equations for ``(c, xi_1, mu)``, and two more for each wheel that sticks, with its force
(:mod:`nonsmooth.proofs.headings.ball_motion`).  Krawczyk's operator encloses a zero; the heading is one of those at
which the wheel lies under the edge.  Let ``nu . xi`` be the rate at which a twist takes the wheel under the body
(``nu = (n, n . J p)``, n the outward normal of the edge) and g how deep it lies there.

- ``nu . xi_1 > 0 > nu . xi_2``: the body comes to the surface ``g = 0`` within finite time and slides on it.  Where
  ``dg/dtheta`` does not vanish, c tells the pose on the surface, and to first order the slide is ``c' = A c`` with ::

      A = [I, J c] (I - xi_1 nu^T/(nu . xi_1)) (D xi_1 + D xi_2/mu)/(1 + 1/mu),      dG_k/dxi D xi_k = -dG_k/dc

  (the weights of the mixture are 1 and 1/mu; how the normal turns drops out, because the mixture rests).  With both
  eigenvalues in the left half-plane position *and heading* return.  With one in the right half-plane the place is
  unstable.
- ``nu . xi_1 < 0 < nu . xi_2``: both motions lead away from the surface, at speeds bounded below: what they move
  leaves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from flint import arb, arb_mat, ctx

from nonsmooth.analysis.bodies.rests import EdgeRest
from nonsmooth.analysis.contact_rule import smooth_rule_of
from nonsmooth.proofs.headings.ball_motion import BallMotion, Pull, UndecidedMotionError, add
from nonsmooth.proofs.headings.krawczyk import contracted, zero_near
from nonsmooth.proofs.headings.pose_slides import Fate, Fates, driven_off, edge_rate, fates_of_slide, slide
from nonsmooth.symbolic.edge_headings import BallOutline, BallVector, ball_of, halved, seen
from nonsmooth.symbolic.numbers.enclosures import PRECISION
from nonsmooth.symbolic.plane import dot
from nonsmooth.symbolic.scene import Scene


@dataclass(frozen=True)
class EdgePose:
    """A pose of rest with one wheel under the edge.

    Attributes:
        scene: all wheels, with the body.
        candidate: the floats that it was found from.
        box: holds exactly one solution ``(x, y, v_x, v_y, omega, mu, forces that stick)``; None where none is proved.
        theta: encloses the heading, in radians from the checked one; None where none is proved.
        position: what becomes of the place.
        heading: what becomes of the heading.
        reason: why it is not proved, or not decided; empty where it is.
    """

    scene: Scene
    candidate: EdgeRest
    box: arb_mat | None = None
    theta: arb | None = None
    position: Fate = Fate.UNDECIDED
    heading: Fate = Fate.UNDECIDED
    reason: str = ""

    @property
    def is_proved(self) -> bool:
        """Whether the body rests there for certain."""
        return self.theta is not None

    def check(self) -> bool:
        """Verify that the box holds a solution, and what follows; what is not proved claims nothing."""
        if self.box is None or self.theta is None:
            return self.position is self.heading is Fate.UNDECIDED
        with ctx.workprec(PRECISION):
            try:
                found = _decided(EdgeEquations(self.scene, self.candidate), self.box)
            except UndecidedMotionError:
                return False
        fates = found.position is self.position and found.heading is self.heading
        return found.theta is not None and bool(found.theta.overlaps(self.theta)) and fates


class EdgeEquations:
    """The equations of one candidate."""

    def __init__(self, scene: Scene, candidate: EdgeRest) -> None:
        """Of a scene with a body, under a rule without cells.

        Raises:
            UnprovedError: where loaded wheels may stand on one line.
        """
        rule, wheels = smooth_rule_of(scene), scene.wheels
        inside = [wheels[k] for k in candidate.inside]
        every = [*inside, wheels[candidate.wheel]]
        self.scene, self.candidate = scene, candidate
        self.without = BallMotion(inside, candidate.loaded[0], candidate.stuck[0], rule)
        self.including = BallMotion(every, candidate.loaded[1], candidate.stuck[1], rule)

    @property
    def start(self) -> list[float]:
        """The candidate as unknowns, with no forces where wheels stick: the equations are linear in these."""
        found = self.candidate
        return [*found.pose[:2], *found.twist, found.ratio, *[0.0] * (self.without.forces + self.including.forces)]

    def forces(self, unknowns: arb_mat) -> tuple[arb_mat, arb_mat]:
        """Of the wheels that stick, without and with the wheel."""
        entries, split = unknowns.entries()[6:], self.without.forces
        return _column(entries[:split]), _column(entries[split:])

    def pulls(self, unknowns: arb_mat) -> tuple[Pull, Pull]:
        """The equations without and with the wheel, at ``(c, xi_1, mu, forces)``."""
        centre, twist, ratio = _parts(unknowns)
        first, second = self.forces(unknowns)
        return self.without.pull(twist, first, centre), self.including.pull(twist * -ratio, second, centre)

    def __call__(self, unknowns: arb_mat) -> tuple[arb_mat, arb_mat]:
        """Values (6 + 2 z, 1) and Jacobian (6 + 2 z, 6 + 2 z)."""
        _, twist, ratio = _parts(unknowns)
        first, second = self.pulls(unknowns)
        split, size = first.values.nrows(), unknowns.nrows()
        jacobian = arb_mat(size, size)
        add(jacobian, 0, 0, first.centre)
        add(jacobian, 0, 2, _columns(first.state, 0, 3))
        add(jacobian, 0, 6, _columns(first.state, 3, split))
        turning = _columns(second.state, 0, 3)
        add(jacobian, split, 0, second.centre)
        add(jacobian, split, 2, turning * -ratio)
        add(jacobian, split, 5, turning * twist * arb(-1))
        add(jacobian, split, 6 + self.without.forces, _columns(second.state, 3, second.values.nrows()))
        return _column([*first.values.entries(), *second.values.entries()]), jacobian


def decide_edge_pose(scene: Scene, candidate: EdgeRest) -> EdgePose:
    """Prove that a body rests near a candidate, and decide what becomes of starts nearby."""
    with ctx.workprec(PRECISION):
        try:
            equations = EdgeEquations(scene, candidate)
            image = zero_near(equations, equations.start)
            box = _widened(image)
            return _decided(equations, box)
        except UndecidedMotionError as error:
            return EdgePose(scene, candidate, reason=str(error))


def _widened(image: arb_mat) -> arb_mat:
    """A box a little larger than an enclosure: Krawczyk's operator proves it again."""
    return arb_mat([[entry + arb(0, arb(2) ** -100)] for entry in image.entries()])


def _decided(equations: EdgeEquations, box: arb_mat) -> EdgePose:
    """What a box proves.

    Raises:
        UnprovedError: where it proves no rest.
    """
    image = contracted(equations, box)
    centre, _, ratio = _parts(image)
    if not ratio > 0:
        raise UndecidedMotionError("a mixture with a negative weight")
    for motion, forces in zip((equations.without, equations.including), equations.forces(image), strict=True):
        motion.require_certain(centre, forces)
    theta, side = _heading(equations, centre)
    found = EdgePose(equations.scene, equations.candidate, box, theta)
    try:
        fates = _fates(equations, image, theta, side)
    except (UndecidedMotionError, ZeroDivisionError) as error:
        return _with(found, (Fate.UNDECIDED, Fate.UNDECIDED), str(error))
    return _with(found, fates, "" if Fate.UNDECIDED not in fates else "no eigenvalue decides")


def _with(pose: EdgePose, fates: Fates, reason: str) -> EdgePose:
    return EdgePose(pose.scene, pose.candidate, pose.box, pose.theta, *fates, reason)


def _heading(equations: EdgeEquations, centre: arb_mat) -> tuple[arb, int | None]:
    """The heading near the candidate's at which its wheel lies on one side, with the same other wheels underneath.

    Raises:
        UnprovedError: where that is not certain.
    """
    scene, candidate = equations.scene, equations.candidate
    if scene.body is None:
        raise ValueError("required a scene with a body")
    outline, places = BallOutline(scene.body), _places(scene, centre)
    edges = list(outline.edge_headings(candidate.wheel, places[candidate.wheel]))
    guess = arb(candidate.pose[2])
    edge = min(edges, key=lambda one: abs(float(halved(one.theta - guess).mid())), default=None)
    if edge is None:
        raise UndecidedMotionError("no heading with the wheel under the edge")
    spot = seen(places[candidate.wheel], edge.theta)
    others = [slack for k, slack in enumerate(outline.slacks(spot)) if edge.side is not None and k != edge.side]
    if not all(slack > 0 for slack in others):
        raise UndecidedMotionError("a wheel under a corner")
    for k, place in enumerate(places):
        expected = 1 if k in candidate.inside else -1
        if k != candidate.wheel and outline.side_of(seen(place, edge.theta)) != expected:
            raise UndecidedMotionError("another wheel that may lie under the edge")
    return edge.theta, edge.side


def _fates(equations: EdgeEquations, image: arb_mat, theta: arb, side: int | None) -> Fates:
    """What becomes of place and heading.

    Raises:
        UnprovedError: where signs are not certain.
    """
    scene, wheel = equations.scene, equations.candidate.wheel
    centre, twist, _ = _parts(image)
    place = _places(scene, centre)[wheel]
    if scene.body is None:
        raise ValueError("required a scene with a body")
    normal = BallOutline(scene.body).outward(side, place, theta)
    x, y = scene.wheels[wheel].position
    rate = edge_rate(normal, (ball_of(x), ball_of(y)))
    coming = (rate * twist)[0, 0]
    if coming < 0:
        (vx, vy, omega), (p, q) = twist.entries(), centre.entries()
        return driven_off((vx - omega * q, vy + omega * p), omega)
    if not coming > 0:
        raise UndecidedMotionError("motions that may run along the edge")
    if not abs(dot(normal, (-place[1], place[0]))) > 0:
        raise UndecidedMotionError("a wheel that a turn does not take across the edge")
    return fates_of_slide(_slide(equations, image, rate), normal)


def _slide(equations: EdgeEquations, image: arb_mat, rate: arb_mat) -> arb_mat:
    """A, the slide to first order, in c."""
    centre, twist, ratio = _parts(image)
    first, second = equations.pulls(image)
    weight = 1 / ratio
    mixed = (first.twist_slope() + second.twist_slope() * weight) * (1 / (1 + weight))
    return slide(centre, twist, mixed, rate)


def _parts(unknowns: arb_mat) -> tuple[arb_mat, arb_mat, arb]:
    """``c`` (2, 1), ``xi_1`` (3, 1) and mu."""
    entries = unknowns.entries()
    return _column(entries[:2]), _column(entries[2:5]), entries[5]


def _column(entries: Sequence[arb]) -> arb_mat:
    return arb_mat(len(entries), 1, list(entries))


def _columns(matrix: arb_mat, start: int, end: int) -> arb_mat:
    """Some columns of a matrix."""
    return arb_mat(
        matrix.nrows(), end - start, [matrix[r, k] for r in range(matrix.nrows()) for k in range(start, end)]
    )


def _places(scene: Scene, centre: arb_mat) -> list[BallVector]:
    """``p_i - c`` of all wheels."""
    x, y = centre.entries()
    return [(ball_of(wheel.position[0]) - x, ball_of(wheel.position[1]) - y) for wheel in scene.wheels]
