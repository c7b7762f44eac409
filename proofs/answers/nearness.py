"""Where bodies near the checked point end, where no clause says that they come home: to the accuracy of the scene.

A clause speaks of the point itself, and the rest point of a table that was measured never is at the point itself.  So
the question is asked with a length a, the accuracy:

- *comes near*: every body from within R is within r of the point after a time T, with ``r <= a`` and ``R >= 2 max(r,
  a)``.  Without that inequality it would say little: a body that stays where it is put ends within a of the point too.
- *leaves*: as near to the point as one likes there are starts whose bodies end, or are carried, farther away than a;
  beside a place of rest that only rounding tells from the point, within a distance that is said.
  That the point itself is no place of rest does not suffice.

A body with an outline is followed as one without on the wheels that carry it, as far as it is shown that no other wheel
comes under it before it is where it is said.  Where loads are not known, *leaves* is shown under one of them: beside a
load of the set springs change it with the place as those that are equal do.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache

from nonsmooth.analysis.cells.contact_rule import has_cells
from nonsmooth.analysis.cells.fan import CellCone, rays_of
from nonsmooth.analysis.cells.load_sets import Loads
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.proofs.answers.answer import Results, angle_at_least
from nonsmooth.proofs.boxes.enclosed_rest import EnclosedRest, enclosed_rest, turns_all_over
from nonsmooth.proofs.clauses.equilibrium.clause import EllipseEquilibrium, EveryLoadEquilibrium
from nonsmooth.proofs.clauses.translation.at_point import EveryLoadTranslation
from nonsmooth.proofs.clauses.translation.fan_stability import FanResult, Move, MoveEvidence
from nonsmooth.proofs.clauses.translation.on_cells import TranslationResult
from nonsmooth.proofs.findings import Equilibrium, Translation
from nonsmooth.proofs.robust.ends import MOST_WHEELS, Ends, decide_ends
from nonsmooth.proofs.robust.rest_points import DISCS, NO_FARTHER, attracting_disc, is_carried_away
from nonsmooth.proofs.robust.touching_rings import FINEST
from nonsmooth.symbolic.mechanics.contact_set import ContactSet, alone, contact_set
from nonsmooth.symbolic.mechanics.contact_states import Twist
from nonsmooth.symbolic.mechanics.load_model import UnknownLoads
from nonsmooth.symbolic.mechanics.rule import MIXED
from nonsmooth.symbolic.mechanics.scene import LoadTable, Scene
from nonsmooth.symbolic.mechanics.springs import NoSpringsError, spring_forms
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.plane import cross, dot
from nonsmooth.symbolic.numbers.rounded import either_way

FOLLOWED = {"nearest", "box", "ellipse", "roller", MIXED}  # rules whose motions are enclosed
TURNING = (8, 4, 2, 1)  # radii in which bodies may turn about a place beside the point, over the accuracy
LOAD_SHARES = (Fraction(1), Fraction(7, 8), Fraction(1, 2))  # of the way from the load of equal springs to another one


@dataclass(frozen=True)
class Turning:
    """A place beside the point about which bodies turn, of which rims that do not slip fix the twist.

    Attributes:
        rates: bounds of the rotation rate (1/time).
        away: a bound of its distance from the point (length).
        within: radius of the disc of starts about the point (length).
    """

    rates: tuple[Fraction, Fraction]
    away: Fraction
    within: Fraction


@dataclass(frozen=True)
class Nearness:
    """What is shown about the ends of bodies from near the point.

    Attributes:
        ends: the disc or the place in which they end; None where none is shown.
        out_after: the time after which every body has left the disc of the accuracy; None where that is not shown.
        thrown_out_from: some bodies from within this distance of the point are carried out of that disc: zero for as
            near as one likes, and more beside a place of rest that only rounding tells from the point; None where that
            is not shown.
        is_from_point: whether the body that starts at the point itself is one of these.
        rests_within: a distance from the point, no more than rounding, within which all members of what was rounded
            have one place of rest each, which attracts; None where that is not shown.
        home: the disc of starts that come to that place, or to the point: ``ends_within`` is a distance from the point
            beyond that of the place, and ``after`` how long it takes them to come that near; None where none is shown.
        turning: how bodies turn about a place beside the point; None where they are not shown to.
        is_of_one_load: whether this is shown under one of the loads that a scene leaves open.
        why_not: what stands in the way of following bodies farther; empty where nothing does.
    """

    ends: Ends | None = None
    out_after: Fraction | None = None
    thrown_out_from: Fraction | None = None
    is_from_point: bool = False
    rests_within: Fraction | None = None
    home: Ends | None = None
    turning: Turning | None = None
    is_of_one_load: bool = False
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
class _SameObject:
    """A question, the same where it is about the same object: to compare scenes number by number takes longer."""

    scene: Scene
    equilibrium: Equilibrium
    translation: Translation
    fan: FanResult | None
    load: Loads | None
    place: EnclosedRest | None

    def __hash__(self) -> int:
        return hash((id(self.scene), self.equilibrium, self.translation))

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, _SameObject)
            and self.scene is other.scene
            and (self.equilibrium, self.translation) == (other.equilibrium, other.translation)
        )


def nearness(scene: Scene, results: Results) -> Nearness:
    """Where bodies near the checked point end; what the clauses say of it may spare the search.

    Args:
        scene: the array.
        results: the clauses on the equilibrium and on (x, y).
    """
    rest, translation = results["equilibrium"], results["translation"]
    load = rest.point.witness if isinstance(rest, EveryLoadEquilibrium) else None
    if isinstance(translation, EveryLoadTranslation) and load is None:
        load = translation.load
    fan = translation.fan if isinstance(translation, TranslationResult) else None
    place = rest.point.rest if isinstance(rest, EllipseEquilibrium) else None
    verdicts = Equilibrium(rest.verdict), Translation(translation.verdict)
    return _decided(_SameObject(scene, *verdicts, fan, load, place))


@lru_cache(maxsize=16)
def homecoming(scene: Scene) -> Nearness:
    """From how far bodies come to the point that attracts those close by, by enclosures: with ``ends`` and ``home``.

    V falls along all motions from the disc of ``home``, but for one place in it; and the point is at rest.

    Args:
        scene: an array of which the clauses show that.
    """
    if scene.contact.rule not in FOLLOWED or (scene.contact.rule != "nearest" and scene.contact.loads_are_unknown):
        return Nearness()
    kept, array = contact_set(scene), alone(scene).recentred()
    with either_way(scene.field):
        ends = decide_ends(array, scene.accuracy, rests=True, kept=kept, finer=(), finest=())
        rest = enclosed_rest(array)
        attracts = rest is not None and rest.stability is Translation.ASYMPTOTICALLY_STABLE
        home = _home_disc(rest, array, scene.accuracy, ends, kept) if rest is not None and attracts else None
    return Nearness(ends if ends is not None and ends.is_near else None, home=home)


@lru_cache(maxsize=16)
def place_of_rest(scene: Scene, ends: Ends) -> EnclosedRest | None:
    """The place of rest to which bodies come close by, inside the disc in which bodies from the point end.

    Args:
        scene: the array.
        ends: that disc, as :func:`nearness` shows it.

    Returns:
        The place, measured from the centre of that disc; None where none is enclosed inside it, or it may repel.
    """
    array = alone(scene).recentred()
    x, y = (array.field.rational(entry) for entry in ends.at)
    rest = enclosed_rest(array.checked_at((x, y), array.check.radius).recentred())
    if rest is None or rest.distance > ends.about or rest.stability is not Translation.ASYMPTOTICALLY_STABLE:
        return None
    return rest


@lru_cache(maxsize=16)  # an answer is asked for several times
def _decided(asked: _SameObject) -> Nearness:
    scene, accuracy = asked.scene, asked.scene.accuracy
    if scene.contact.rule not in FOLLOWED:
        return Nearness(why_not=f"under rule {scene.contact.rule} bodies are not followed")
    kept, array = contact_set(scene), alone(scene).recentred()
    with either_way(scene.field):  # what is shown holds for every member of what was rounded
        if array.contact.rule != "nearest" and array.contact.loads_are_unknown:
            shown_near = _under_a_load(asked, array, kept)
        else:
            shown_near = _under_known_loads(asked, array, kept)
    is_shown = shown_near.leaves or shown_near.comes_near or shown_near.turning is not None
    return shown_near if is_shown else replace(shown_near, why_not=_why_not(array, accuracy, kept))


def _why_not(scene: Scene, accuracy: Fraction, kept: ContactSet) -> str:
    """What may stand in the way of following bodies, in words."""
    if scene.contact.rule != "nearest" and scene.contact.loads_are_unknown:
        return "under every load bodies are not followed"
    if kept.margin is not None and kept.margin <= accuracy:
        return "within the accuracy other wheels come under it"
    if kept.angle is not None:
        within = angle_at_least(kept.angle, scene.units)
        return f"that it turns by less than {within} on its way is not shown, and beyond that others may come under it"
    if len(scene.wheels) > MOST_WHEELS:
        return f"bodies are followed on up to {MOST_WHEELS} wheels"
    return ""


def _under_known_loads(asked: _SameObject, array: Scene, kept: ContactSet) -> Nearness:
    """On a centred array of the wheels that carry."""
    accuracy, equilibrium = asked.scene.accuracy, asked.equilibrium
    rests = equilibrium is Equilibrium.HOLDS and asked.translation is Translation.STABLE
    may_move = equilibrium is not Equilibrium.HOLDS and asked.place is None
    turning = _turning(array, accuracy, kept) if may_move else None
    if turning is not None:
        return Nearness(turning=turning)
    leaving = _leaving(array, accuracy, kept) if may_move else None
    finest = FINEST if leaving is None else ()
    ends = decide_ends(array, accuracy, rests=rests, kept=kept, finest=finest)
    if asked.place is not None:
        return _beside_a_rest(asked.place, array, accuracy, ends, kept)
    if ends is None and leaving is not None:
        return leaving
    if ends is not None or rests or equilibrium is not Equilibrium.HOLDS:
        return Nearness(ends)
    is_out = _is_thrown_out(asked, array) and kept.keeps(accuracy, None)
    return Nearness(thrown_out_from=Fraction(0) if is_out else None)


def _turning(array: Scene, accuracy: Fraction, kept: ContactSet) -> Turning | None:
    """How bodies turn about a place beside the point of a centred array, without an outline."""
    rest = enclosed_rest(array) if kept.margin is None else None
    if rest is None or not rest.balance.fixes_twist or 2 * rest.distance >= accuracy:
        return None
    for share in TURNING:
        reach = share * accuracy
        if sign(array.check.radius - reach) >= 0 and turns_all_over(rest, reach):
            return Turning(rest.rates, rest.distance, reach - 2 * rest.distance)
    return None


def _leaving(array: Scene, accuracy: Fraction, kept: ContactSet) -> Nearness | None:
    """How bodies leave the disc of the accuracy, all of them or that from the point; then this is no equilibrium."""
    after = _driven_out(array, accuracy, kept)
    if after is not None:
        return Nearness(out_after=after)
    if not kept.keeps(accuracy, None):
        return None
    followed = _is_followed_out(array, accuracy)
    if followed or _is_driven_to_one_side(array, accuracy):
        return Nearness(thrown_out_from=Fraction(0), is_from_point=followed)
    return None


def _driven_out(array: Scene, accuracy: Fraction, kept: ContactSet) -> Fraction | None:
    """When every body has left the disc of the accuracy, if no wheel enters or leaves before."""
    from nonsmooth.proofs.robust.drift import driven_out, largest_spin

    after = driven_out(array, accuracy)
    if after is None or kept.margin is None:
        return after
    spin = None if kept.angle is None else largest_spin(array, accuracy)
    return after if kept.keeps(accuracy, None if spin is None else spin * after) else None


def _under_a_load(asked: _SameObject, array: Scene, kept: ContactSet) -> Nearness:
    """Under the load that moves or throws out the body at the point, or one between it and that of equal springs."""
    unknown, accuracy = array.contact.loads, asked.scene.accuracy
    scatter = unknown.scatter if isinstance(unknown, UnknownLoads) else None
    if asked.load is None or (scatter is not None and scatter.stiffness):
        return Nearness()
    try:
        forms = spring_forms(array.positions)
    except NoSpringsError:
        return Nearness()
    for share in LOAD_SHARES:
        rows = [(a + share * (load - a), b, c) for (a, b, c), load in zip(forms, asked.load, strict=True)]
        loaded = replace(array, contact=replace(array.contact, loads=LoadTable(tuple(rows))))
        leaving = _leaving(loaded, accuracy, kept)
        if leaving is not None:
            return replace(leaving, is_of_one_load=True)
        may_be_thrown = asked.translation is Translation.UNSTABLE and kept.keeps(accuracy, None)
        if may_be_thrown and is_carried_away(loaded, accuracy, Fraction(0)):
            return Nearness(thrown_out_from=Fraction(0), is_of_one_load=True)
    return Nearness()


def _beside_a_rest(
    rest: EnclosedRest, scene: Scene, accuracy: Fraction, ends: Ends | None, kept: ContactSet
) -> Nearness:
    """Where a place of rest that only rounding tells from the point of a centred scene attracts bodies, or repels them.

    So it is too where its rotation rate is not a number of the scene, as of arrays that are symmetric about the point.
    """
    if rest.stability is Translation.ASYMPTOTICALLY_STABLE:
        return Nearness(ends, rests_within=rest.distance, home=_home_disc(rest, scene, accuracy, ends, kept))
    if ends is None and rest.stability is Translation.UNSTABLE:
        is_out = kept.keeps(accuracy, None) and is_carried_away(scene, accuracy, rest.distance)
        return Nearness(thrown_out_from=NO_FARTHER * accuracy if is_out else None)
    return Nearness(ends)


def _home_disc(
    rest: EnclosedRest, scene: Scene, accuracy: Fraction, ends: Ends | None, kept: ContactSet
) -> Ends | None:
    """Where bodies from the disc of starts come into one that attracts to the place of rest; without an outline."""
    if kept.margin is not None:
        return None
    near = None if ends is None else ends.ends_within
    disc = attracting_disc(rest, [*([] if near is None else [near]), *(share * accuracy for share in DISCS)])
    if disc is None:
        return None
    there, point = 2 * rest.distance, (Fraction(0), Fraction(0))
    if ends is not None and near is not None and near <= disc.radius:
        swing = max(ends.swings_out_to, disc.swing)
        return Ends(there, ends.within, swing, ends.after + disc.time_to(there, near), point, there)
    if disc.radius <= there:
        return None
    return Ends(there, disc.radius, disc.swing, disc.time_to(there, disc.radius), point, there)


def _is_thrown_out(asked: _SameObject, array: Scene) -> bool:
    """Whether some bodies from as near as one likes are carried out of the disc of the accuracy, for every member."""
    accuracy, fan, before = asked.scene.accuracy, asked.fan, array.field.rounded_signs
    if asked.translation is Translation.UNSTABLE and is_carried_away(array, accuracy, Fraction(0)):
        return True
    out = fan is not None and any(_is_carried_out(move, fan, accuracy) for move in fan.evidence)
    out = out or _is_driven_to_one_side(array, accuracy) or _comes_home_reversed(array, accuracy)
    return out and array.field.rounded_signs == before


def _is_driven_to_one_side(array: Scene, accuracy: Fraction) -> bool:
    """Whether bodies on one side of a line through the point leave the disc, for every member; of cells alone."""
    from nonsmooth.proofs.robust.drift import is_driven_out_on_one_side

    before = array.field.rounded_signs
    is_out = has_cells(array) and is_driven_out_on_one_side(array, accuracy)
    return is_out and array.field.rounded_signs == before


def _is_followed_out(array: Scene, accuracy: Fraction) -> bool:
    """Whether the body that starts at the point leaves the disc, for every member."""
    from nonsmooth.proofs.robust.followed_body import is_carried_out, leaves_by_funnel

    if not has_cells(array):
        return leaves_by_funnel(array, accuracy)
    before = array.field.rounded_signs
    return is_carried_out(array, accuracy) and array.field.rounded_signs == before


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


def _comes_home_reversed(scene: Scene, accuracy: Fraction) -> bool:
    """Whether, with all rims reversed, every body from within the accuracy comes home to the point.

    D does not change where all speeds and the twist change their signs: motions of the reversed array are those of the
    array, run backward.  So some body from as near as one likes is carried out of the disc.
    """
    from nonsmooth.proofs import clause_registry
    from nonsmooth.proofs.clauses.workspace import Workspace

    backward = replace(scene, wheels=tuple(replace(wheel, given_speed=-wheel.speed) for wheel in scene.wheels))
    work = Workspace(backward, sample=False)
    try:
        for clause in clause_registry.CLAUSES:
            if clause.name in {"equilibrium", "translation"}:
                work.earlier[clause.name] = clause.decided(work)
    except RefusalError:
        return False
    translation = work.earlier["translation"]
    home = getattr(translation, "home_radius", None)
    attracts = translation.verdict is Translation.ASYMPTOTICALLY_STABLE
    return bool(attracts and home is not None and home >= accuracy)
