"""Stability of an equilibrium decided by the fan of cones around it: complete up to exact ties.

Near the equilibrium only the cells whose closure holds it matter: a fan of cones, each with one velocity v and one
rotation rate omega.  With exact kinematics ``c' = v + omega J c`` a Filippov solution near it is a chain of moves:

- *escape*: a velocity that points into its own closed cone carries the body straight away: unstable.  Where it lies
  along a ray of the cone, omega decides: it is an escape unless omega bends the path out of the cone there;
- *slide* along a ray between two cones (module ``analysis.cells.fan``): the sign of its radial speed for small s is
  that of A, or of B where A is zero.  Outward: unstable (on repelling rays too: one solution is enough).  Inward: the
  body slides home.  Exactly zero: a ray of equilibria;
- *crossing* of a cone from ray to ray, and *full turns* where every cone can be crossed in one sense:
  module ``analysis.cells.fan``.  Distances that diverge: unstable; that contract: fine; a gain of exactly
  one is left undecided (terms of higher order decide), and so are crossings of orders 1/2 and 2 that cancel.

Each of these is decided by the sign of the cross product of ray and velocity, and where that is zero by the sign of
omega: on the ray the body's velocity has the normal component ``n + s omega``, whose sign is the same for all small s.
So every cone is left over a given ray, entered over it, or neither, and a path does not turn back inside a cone.

If nothing is unstable and nothing rests, every chain ends in an inward slide or contracts, so the equilibrium is
asymptotically stable; with rest it is stable, not asymptotically.  Where several motions tie in a cone, any of
their mixtures may be followed.  With normal and radial parts (n, rho) the growth per angle ``rho/n`` of a mixture lies
between those of the two, whose order ``rho_1 n_2 - rho_2 n_1 = +-v_1 x v_2`` is the same at every angle: so the largest
gain is that of one of them, and turning back and forth between them where n changes sign grows the distance only
if their mixture slides outward, which shows at a ray of the cone.  That compares first-order terms; where a tied cone
has a crossing of another order, full turns are not said to contract.  The overshoot is the largest growth of the
distance along a chain, from a start anywhere in a cone; it has no bound where motions tie, and where a start at eps
leaves a cone at the order of ``eps^(1/2)``.  Not decided: a cell that turns the body about the equilibrium itself,
where that is the plane or has other motions.  (Filippov 1988, sec. 15-16, for the piecewise constant field; the linear
terms are the pose's own.)
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from itertools import product
from typing import TYPE_CHECKING, Any

from nonsmooth.analysis.cells.fan import (
    Cone,
    FullTurn,
    Growth,
    build_fan,
    cone_crossings,
    departure_sign,
    entry_and_exit,
    full_turns,
    is_plane,
    most_growth,
    ray_speeds,
    rays_of,
    slide_speed,
)
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.proofs.findings import Translation
from nonsmooth.symbolic.mechanics.contact_states import Twist
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.number_text import brief_text, place_text
from nonsmooth.symbolic.numbers.plane import cross, dot

if TYPE_CHECKING:
    from nonsmooth.analysis.cells.partition import Partition


class Move(StrEnum):
    """What a witness does."""

    ESCAPE = "escape"
    SLIDE = "outward slide"
    TURN = "outward spiral"
    REST = "rest"
    TIE = "tie"


@dataclass(frozen=True)
class MoveEvidence:
    """One move with the exact data that shows it.

    Attributes:
        move: the kind.
        ray: the direction in which it happens.
        twists: the twists involved (one for an escape, two for a slide, one per cone for a turn).
        value: radial speed (leading nonzero term) of a slide, the full turn, or in words what ties.
    """

    move: Move
    ray: Point
    twists: tuple[Twist, ...]
    value: Any

    def __str__(self) -> str:
        ray = place_text(self.ray, 5)
        match self.move:
            case Move.ESCAPE:
                return f"the velocity {ray} points into its own cell: the body escapes along it"
            case Move.SLIDE:
                speed = brief_text(self.value)
                return f"along the ray {ray} the body may slide outward (leading coefficient {speed})"
            case Move.TURN:
                return str(self.value)
            case Move.REST:
                return f"every point of the ray {ray} near the equilibrium is an equilibrium"
            case _:
                return f"exact tie: {self.value} at the ray {ray}"


@dataclass(frozen=True)
class FanResult:
    """Decision with everything found in the fan.

    Attributes:
        verdict: strong stability of the equilibrium.
        cones: the fan, counterclockwise.
        evidence: what is unstable, at rest, or tied (empty for asymptotic stability).
        turns: the full turns, by sense, where they exist.
        squared_overshoot: square of the largest growth of the distance along a chain of cones (at least one);
            None where none is claimed: unstable, undecided, several motions tie in a cone, or no factor bounds it.
    """

    verdict: Translation
    cones: tuple[Cone, ...]
    evidence: tuple[MoveEvidence, ...]
    turns: tuple[FullTurn, ...]
    squared_overshoot: Any

    @property
    def gains(self) -> dict[int, Any]:
        """Gain of a full turn by sense (1 counterclockwise, -1 clockwise), of those whose crossings have order one."""
        return {turn.sense: turn.gain for turn in self.turns if turn.gain is not None}

    @property
    def grows_to_a_root(self) -> bool:
        """Whether a start at distance eps may first move away to the order of ``eps^(1/2)``."""
        return any(leaves_at_a_root(cone) for cone in self.cones)

    @property
    def reason(self) -> str:
        """One sentence for people."""
        if self.evidence:
            return str(self.evidence[0])
        turns = "; ".join(str(turn) for turn in self.turns)
        reason = "no velocity escapes, every slide leads inward" + (f"; {turns}" if turns else ", no full turn exists")
        far = "; a start at distance eps may first move away to the order of eps^(1/2)"
        return reason + (far if self.grows_to_a_root else "")


def decide_fan(partition: Partition) -> FanResult:
    """Decide stability of the equilibrium (the origin) of a centred partition."""
    return decide_cones(build_fan(partition))


def decide_cones(cones: Sequence[Cone]) -> FanResult:
    """Decide stability from the fan."""
    fan = tuple(cones)
    turns = full_turns(fan)
    slides = _slides(fan)
    unstable = [*_escapes(fan), *_outward(slides)]
    unstable += [_turn_evidence(fan, turn) for turn in turns if turn.growth is Growth.DIVERGES]
    if unstable:
        return FanResult(Translation.UNSTABLE, fan, tuple(unstable), turns, None)
    ties = [*_ties(fan)]
    ties += [_turn_tie(fan, turn) for turn in turns if turn.growth is Growth.TIE]
    if ties:
        return FanResult(Translation.UNDECIDED, fan, tuple(ties), turns, None)
    rest = [*_rests(fan), *_equilibria(slides)]
    verdict = Translation.STABLE if rest else Translation.ASYMPTOTICALLY_STABLE
    return FanResult(verdict, fan, tuple(rest), turns, squared_overshoot(fan))


# ---- moves -------------------------------------------------------------------------------


def _escapes(fan: Sequence[Cone]) -> Iterator[MoveEvidence]:
    for cone in fan:
        for twist in cone.twists:
            if any(twist.velocity) and all(departure_sign(normal, twist) >= 0 for normal in cone.inward_normals):
                yield MoveEvidence(Move.ESCAPE, twist.velocity, (twist,), None)


def _slides(fan: Sequence[Cone]) -> list[list[MoveEvidence]]:
    """The slides along each ray, by its vector and their speed."""
    return [list(_slides_along(ray, (*before.twists, *after.twists))) for ray, before, after in rays_of(fan)]


def _slides_along(ray: Point, twists: Iterable[Twist]) -> Iterator[MoveEvidence]:
    speeds = {twist: ray_speeds(ray, twist) for twist in twists}
    for (first, before), (second, behind) in product(speeds.items(), repeat=2):
        speed = slide_speed(before, behind)
        if speed is not None:
            yield MoveEvidence(Move.SLIDE, ray, (first, second), speed)


def _outward(slides: Sequence[Sequence[MoveEvidence]]) -> list[MoveEvidence]:
    """Of each ray the first slide that leads outward."""
    first = (next((slide for slide in on_ray if sign(slide.value) > 0), None) for on_ray in slides)
    return [slide for slide in first if slide is not None]


def _equilibria(slides: Sequence[Sequence[MoveEvidence]]) -> list[MoveEvidence]:
    """Of each ray of equilibria the first pair that rests there."""
    first = (next((slide for slide in on_ray if not sign(slide.value)), None) for on_ray in slides)
    return [replace(slide, move=Move.REST) for slide in first if slide is not None]


def _ties(fan: Sequence[Cone]) -> Iterator[MoveEvidence]:
    """Cells that turn the body about the equilibrium itself, and are the plane or have other motions too.

    A cone with this motion alone is only crossed: the distance is kept.
    """
    for cone in fan:
        for twist in cone.twists:
            crossed = len(cone.twists) == 1 and not is_plane(cone)
            if not any(twist.velocity) and twist.omega and not crossed:
                yield MoveEvidence(Move.TIE, cone.start, (twist,), "the body turns about the equilibrium itself")


def _rests(fan: Sequence[Cone]) -> Iterator[MoveEvidence]:
    """Cones in which the body does not move at all."""
    for cone in fan:
        for twist in cone.twists:
            if not any(twist):
                yield MoveEvidence(Move.REST, cone.start, (twist,), twist.omega)


def _turn_evidence(fan: Sequence[Cone], turn: FullTurn) -> MoveEvidence:
    twists = tuple(cone.twists[0] for cone in fan)
    return MoveEvidence(Move.TURN, _first_ray(fan, turn), twists, turn)


def _turn_tie(fan: Sequence[Cone], turn: FullTurn) -> MoveEvidence:
    is_one = turn.gain is not None and not sign(turn.gain - 1)
    why = "a full turn has gain one" if is_one else "the leading terms of a full turn cancel or mix"
    return MoveEvidence(Move.TIE, _first_ray(fan, turn), (), why)


def _first_ray(fan: Sequence[Cone], turn: FullTurn) -> Point:
    return fan[0].start if turn.sense > 0 else fan[-1].end


# ---- the largest growth of the distance ----------------------------------------------------------


def leaves_at_a_root(cone: Cone) -> bool:
    """Whether a start at distance eps inside the cone may leave it at a distance of order ``eps^(1/2)``.

    So it does where a motion bends out of the cone.
    """
    return not is_plane(cone) and any(cone.bends_out(twist) for twist in cone.twists)


def squared_overshoot(fan: Sequence[Cone]) -> Any | None:
    """Square of the largest growth of the distance along a chain of cones, to first order; at least one.

    None where motions tie in a cone, and where a start at eps may leave a cone at the order of ``eps^(1/2)``: no factor
    bounds the growth there.
    """
    if any(len(cone.twists) > 1 or leaves_at_a_root(cone) for cone in fan):
        return None
    overshoot: Any = 1
    for sense in (1, -1):
        cones = fan if sense > 0 else fan[::-1]
        firsts = [_departure(cone, sense) for cone in cones]
        steps = [_squared_growth(cone, sense) for cone in cones]
        overshoot = max(overshoot, _largest_chain(firsts, steps))
    return overshoot


def _squared_growth(cone: Cone, sense: int) -> Any | None:
    """Squared growth of the length by crossing a cone, for small lengths; None where it cannot be crossed."""
    crossings = cone_crossings(cone, sense)
    if not crossings:
        return None
    step = most_growth(crossings)
    if step.order > 1:  # nothing is left of a small length
        return 0
    if step.gain is None:
        return 1
    entry, exit_ray = entry_and_exit(cone, sense)
    return step.gain * step.gain * dot(exit_ray, exit_ray) / dot(entry, entry)


def _departure(cone: Cone, sense: int) -> Any | None:
    """Largest squared growth from a start anywhere in the cone to its exit; None where no path leaves that way.

    The path from e to the exit ray r' grows by ``|e x v| |r'|/|r' x v|`` for unit e: largest for e at right angles to v
    where the cone holds it, on a ray of the cone otherwise.  Where v = 0 the distance is kept.
    """
    best: Any | None = None
    _, exit_ray = entry_and_exit(cone, sense)
    for twist in cone.twists:
        v = twist.velocity
        if not any(v) and sense * sign(twist.omega) > 0:
            best = 1 if best is None else max(best, 1)
            continue
        leaving = sense * cross(exit_ray, v)
        if is_plane(cone) or sign(leaving) <= 0:
            continue
        across = (sense * v[1], -sense * v[0])
        if cone.holds(across):
            reach = dot(v, v)
        else:
            starts = [r for r in (cone.start, cone.end) if sign(sense * cross(r, v)) > 0]
            reach = max(cross(r, v) * cross(r, v) / dot(r, r) for r in starts)
        growth = reach * dot(exit_ray, exit_ray) / (leaving * leaving)
        best = growth if best is None else max(best, growth)
    return best


def _largest_chain(firsts: Sequence[Any | None], steps: Sequence[Any | None]) -> Any:
    """Largest squared growth: out of one cone, then through consecutive ones, at most once around."""
    best: Any = 1
    for start, first in enumerate(firsts):
        total = first
        for offset in range(1, len(steps)):
            if total is None:
                break
            best = max(best, total)
            step = steps[(start + offset) % len(steps)]
            total = None if step is None else step * total
        if total is not None:
            best = max(best, total)
    return best
