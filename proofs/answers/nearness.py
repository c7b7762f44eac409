"""Where bodies near the checked point end, where no clause says that they come home: to the accuracy of the scene.

A clause speaks of the point itself, and the rest point of a table that was measured never is at the point itself.  So
the question is asked with a length a, the accuracy:

- *comes near*: every body from within R is within r of the point after a time T, with ``r <= a`` and ``R >= 2 max(r,
  a)``.  Without that inequality it would say little: a body that stays where it is put ends within a of the point too.
- *leaves*: as near to the point as one likes there are starts whose bodies end, or are carried, farther away than a;
  beside a place of rest that only rounding tells from the point, within a distance that is said.
  That the point itself is no place of rest does not suffice.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache

from nonsmooth.analysis.cells.fan import CellCone, rays_of
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.proofs.clauses.translation.clause import AnyTranslation
from nonsmooth.proofs.clauses.translation.fan_stability import FanResult, Move, MoveEvidence
from nonsmooth.proofs.robust.drift import driven_out
from nonsmooth.proofs.robust.ends import Ends, decide_ends, why_not_followed
from nonsmooth.proofs.robust.rest_points import NO_FARTHER, EnclosedRest, enclosed_rest, is_carried_away
from nonsmooth.proofs.verdicts import Equilibrium, Translation
from nonsmooth.symbolic.constraints import Twist
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.rounded import either_way
from nonsmooth.symbolic.plane import cross, dot
from nonsmooth.symbolic.scene import Scene, Wheel

ROUNDING = Fraction(1, 10**11)  # of the accuracy: a place of rest so near is the point, to all printed digits


@dataclass(frozen=True)
class Nearness:
    """What is shown about the ends of bodies from near the point.

    Attributes:
        ends: the disc or the place in which they end; None where none is shown.
        out_after: the time after which every body has left the disc of the accuracy; None where that is not shown.
        thrown_out_from: some bodies from within this distance of the point are carried out of that disc: zero for as
            near as one likes, and more beside a place of rest that only rounding tells from the point; None where that
            is not shown.
        rests_within: a distance from the point, no more than rounding, within which all members of what was rounded
            have one place of rest each, which attracts; None where that is not shown.
        why_not: why nothing was looked for; empty where something was.
    """

    ends: Ends | None = None
    out_after: Fraction | None = None
    thrown_out_from: Fraction | None = None
    rests_within: Fraction | None = None
    why_not: str = ""

    @property
    def comes_near(self) -> bool:
        """Whether bodies end within the accuracy."""
        return self.ends is not None and self.ends.is_near

    @property
    def leaves(self) -> bool:
        """Whether some end, or are carried, farther away."""
        ends_away = self.ends is not None and not self.ends.is_near
        return ends_away or self.out_after is not None or self.thrown_out_from is not None


@dataclass(frozen=True, eq=False)
class _Asked:
    """A question, the same where it is about the same object: to compare scenes number by number takes longer."""

    scene: Scene
    equilibrium: Equilibrium
    translation: Translation
    fan: FanResult | None

    def __hash__(self) -> int:
        return hash((id(self.scene), self.equilibrium, self.translation))

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, _Asked)
            and self.scene is other.scene
            and (self.equilibrium, self.translation) == (other.equilibrium, other.translation)
        )


def nearness(scene: Scene, equilibrium: Equilibrium, translation: AnyTranslation) -> Nearness:
    """Where bodies near the checked point end; what the clauses say of it may spare the search.

    Args:
        scene: the array.
        equilibrium: whether the point is a place of rest.
        translation: what bodies beside it do.
    """
    return _decided(_Asked(scene, equilibrium, translation.verdict, getattr(translation, "fan", None)))


@lru_cache(maxsize=16)  # an answer is asked for several times
def _decided(asked: _Asked) -> Nearness:
    scene, accuracy = asked.scene, asked.scene.accuracy
    centred = scene.recentred()
    why_not = why_not_followed(centred)
    if why_not:
        return Nearness(why_not=why_not)
    holds = asked.equilibrium is Equilibrium.HOLDS
    with either_way(scene.field):  # what is shown holds for every member of what was rounded
        ends = decide_ends(centred, accuracy, rests=holds and asked.translation is Translation.STABLE)
        if asked.equilibrium is Equilibrium.UNDECIDED:
            return _beside_a_rest(centred, accuracy, ends)
        if ends is not None or (holds and asked.translation is Translation.STABLE):
            return Nearness(ends)
        if holds:
            carried_away = asked.translation is Translation.UNSTABLE and is_carried_away(centred, accuracy, Fraction(0))
            is_out = carried_away or _is_surely_out(asked, accuracy)
            return Nearness(thrown_out_from=Fraction(0) if is_out else None)
        return Nearness(out_after=driven_out(centred, accuracy))


def _beside_a_rest(scene: Scene, accuracy: Fraction, ends: Ends | None) -> Nearness:
    """Where a place of rest that only rounding tells from the point of a centred scene attracts bodies, or repels them.

    So it is too where its rotation rate is not a number of the scene, as of arrays that are symmetric about the point.
    """
    rest = rest_beside(scene)
    if rest is not None and rest.stability is Translation.ASYMPTOTICALLY_STABLE:
        return Nearness(ends, rests_within=rest.distance)
    if ends is None and rest is not None and rest.stability is Translation.UNSTABLE:
        is_out = is_carried_away(scene, accuracy, rest.distance)
        return Nearness(thrown_out_from=NO_FARTHER * accuracy if is_out else None)
    return Nearness(ends)


def rest_beside(scene: Scene) -> EnclosedRest | None:
    """The place of rest of a centred scene that is its point, to all printed digits; None where none is enclosed."""
    rest = enclosed_rest(scene)
    return rest if rest is not None and rest.distance <= ROUNDING * scene.accuracy else None


def _is_surely_out(asked: _Asked, accuracy: Fraction) -> bool:
    """Whether bodies are carried out of the disc of the accuracy, by signs that are those of every member."""
    field, fan = asked.scene.field, asked.fan
    before = field.rounded_signs
    out = fan is not None and any(_is_carried_out(move, fan, accuracy) for move in fan.evidence)
    return (out or _is_thrown_out(asked.scene, accuracy)) and field.rounded_signs == before


def _is_carried_out(move: MoveEvidence, fan: FanResult, accuracy: Fraction) -> bool:
    """Whether a body slides outward along a ray of the fan, between the same two cells, farther than the accuracy.

    At the place ``lambda r`` of the ray r the velocity of a cell has the normal part ``J r . v + lambda omega r . r``,
    which is affine in lambda, and the radial part ``r . v``.  Where the normal parts of the two cells oppose each other
    at both ends of a piece of the ray they do so on all of it.
    """
    if move.move is not Move.SLIDE:
        return False
    ray = move.ray
    size = float(dot(ray, ray)) ** 0.5
    most = Fraction(float(accuracy) / size) * (1 + Fraction(1, 2**20))
    end = ray[0] * most, ray[1] * most
    for _, before, after in rays_of(fan.cones):
        cells = [cone.cell for cone in (before, after) if isinstance(cone, CellCone)]
        # every velocity of both cells is in F on the ray, so that any two of them may mix there
        if after.start is ray and len(cells) == 2 and {*move.twists} <= {*before.twists, *after.twists}:
            inside = all(cell.polygon.contains(end) for cell in cells)
            return inside and dot(end, end) > accuracy * accuracy and _slides_outward(ray, move.twists, most)
    return False


def _slides_outward(ray: Point, twists: tuple[Twist, ...], most: Fraction) -> bool:
    """Whether the mixture of two motions along a ray leads outward all along a piece of it."""
    normal = [(cross(ray, twist.velocity), twist.omega * dot(ray, ray)) for twist in twists]
    first, second = ([at + by * part for part in (Fraction(0), most)] for at, by in normal)
    outward, inward = (dot(ray, twist.velocity) for twist in twists)
    if not all(sign(a * b) < 0 for a, b in zip(first, second, strict=True)):
        return False
    speeds = [sign(b * outward - a * inward) * sign(b - a) for a, b in zip(first, second, strict=True)]
    return speeds[0] >= 0 and speeds[1] > 0


def _is_thrown_out(scene: Scene, accuracy: Fraction) -> bool:
    """Whether, with all rims reversed, every body from within the accuracy comes home to the point.

    D does not change where all speeds and the twist change their signs: motions of the reversed array are those of the
    array, run backward.  So some body from as near as one likes is carried out of the disc.
    """
    from nonsmooth.proofs.clauses import registry
    from nonsmooth.proofs.clauses.workspace import Workspace

    backward = replace(scene, wheels=tuple(_reversed(wheel) for wheel in scene.wheels))
    work = Workspace(backward, sample=False)
    try:
        for clause in registry.CLAUSES:
            if clause.name in {"equilibrium", "translation"}:
                work.earlier[clause.name] = work.decided(clause)
    except RefusalError:
        return False
    found = work.earlier["translation"]
    home = getattr(found, "home_radius", None)
    attracts = found.verdict is Translation.ASYMPTOTICALLY_STABLE
    return bool(attracts and home is not None and home >= accuracy)


def _reversed(wheel: Wheel) -> Wheel:
    return replace(wheel, given_speed=-wheel.speed)
