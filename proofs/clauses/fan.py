"""Stability of an equilibrium decided by the fan of cones around it: complete up to exact ties.

Near the equilibrium only the cells whose closure holds it matter: a fan of cones, each with one velocity v and one
rotation rate omega.  With exact kinematics ``c' = v + omega J c`` a Filippov solution near it is a chain of moves:

- *escape*: a velocity that points into its own closed cone carries the body straight away: unstable;
- *slide* along a ray between two cones: possible where the normal velocities ``N = n + s omega`` on its two sides
  do not have the same strict sign; the radial speed at distance s is ``(N_1 rho_2 - N_2 rho_1)/(N_1 - N_2)``.  Its
  sign for small s is found by comparing the constant term, then the linear one.  Outward: unstable (on repelling
  rays too: one solution is enough).  Inward: the body slides home.  Exactly zero: a ray of equilibria;
- *turn* through a cone from ray r to ray r': lengths are multiplied by the gain ``(r x v)/(r' x v)``.  A sense of
  rotation in which every cone can be crossed allows full turns: the product of gains above one is unstable, below
  one contracts, exactly one is left undecided (second-order terms decide).

If nothing is unstable and nothing rests, every chain ends in an inward slide or contracts, so the equilibrium is
asymptotically stable; with rest it is stable, not asymptotically.  Where several motions tie in a cone, any of
their mixtures may be followed.  With normal and radial parts (n, rho) the growth per angle ``rho/n`` of a mixture lies
between those of the two, whose order ``rho_1 n_2 - rho_2 n_1 = +-v_1 x v_2`` is the same at every angle: so the largest
gain is that of one of them, and turning back and forth between them where n changes sign grows the distance only
if their mixture slides outward, which shows at a ray of the cone.  The overshoot is the largest growth of the
distance along a chain, from a start anywhere in a cone (not bounded here where motions tie).  (Filippov 1988,
sec. 15-16, for the piecewise constant field; the linear terms are the pose's own.)
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cmp_to_key
from itertools import product
from typing import Any

from nonsmooth.analysis.partitions.partition import Cell, Partition
from nonsmooth.analysis.partitions.polygon import Point
from nonsmooth.proofs.verdicts import Translation
from nonsmooth.symbolic.constraints import Twist
from nonsmooth.symbolic.formulas import brief_text
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.scene import cross, dot


class Move(StrEnum):
    """What a witness does."""

    ESCAPE = "escape"
    SLIDE = "outward slide"
    TURN = "outward spiral"
    REST = "rest"
    TIE = "tie"


@dataclass(frozen=True)
class Cone:
    """The part of a cell near the equilibrium: counterclockwise from ray ``start`` to ray ``end``.

    Attributes:
        start: first ray.
        end: last ray.
        twists: the motions in the cone.
    """

    start: Point
    end: Point
    twists: tuple[Twist, ...]

    def holds(self, vector: Point) -> bool:
        """Whether a nonzero vector points into the closed cone (of angle at most a half turn)."""
        if not cross(self.start, self.end):  # half-plane
            return sign(cross(self.start, vector)) >= 0
        return sign(cross(self.start, vector)) >= 0 and sign(cross(vector, self.end)) >= 0


@dataclass(frozen=True)
class CellCone(Cone):
    """The cone of a cell of an array."""

    cell: Cell


@dataclass(frozen=True)
class Evidence:
    """One move with the exact data that shows it.

    Attributes:
        move: the kind.
        ray: the direction in which it happens.
        twists: the twists involved (one for an escape, two for a slide, one per cone for a turn).
        value: radial speed (leading nonzero term) of a slide, gain of a turn.
    """

    move: Move
    ray: Point
    twists: tuple[Twist, ...]
    value: Any

    def __str__(self) -> str:
        x, y = (float(v) for v in self.ray)
        match self.move:
            case Move.ESCAPE:
                return f"the velocity ({x:.5g}, {y:.5g}) points into its own cell: the body escapes along it"
            case Move.SLIDE:
                speed = brief_text(self.value)
                return f"along the ray ({x:.5g}, {y:.5g}) the body may slide outward (leading coefficient {speed})"
            case Move.TURN:
                return f"a full turn multiplies the distance by {brief_text(self.value)} ~ {float(self.value):.6g}"
            case Move.REST:
                return f"every point of the ray ({x:.5g}, {y:.5g}) near the equilibrium is an equilibrium"
            case _:
                return f"exact tie: {self.value} at the ray ({x:.5g}, {y:.5g})"


@dataclass(frozen=True)
class FanResult:
    """Decision with everything found in the fan.

    Attributes:
        verdict: strong stability of the equilibrium.
        cones: the fan, counterclockwise.
        evidence: what is unstable, at rest, or tied (empty for asymptotic stability).
        gains: product of gains of a full turn, by sense (1 counterclockwise, -1 clockwise), where one exists.
        squared_overshoot: square of the largest growth of the distance along a chain of cones (at least one);
            None where several motions tie in a cone.
    """

    verdict: Translation
    cones: tuple[Cone, ...]
    evidence: tuple[Evidence, ...]
    gains: dict[int, Any]
    squared_overshoot: Any

    @property
    def reason(self) -> str:
        """One sentence for people."""
        if self.evidence:
            return str(self.evidence[0])
        turns = "; ".join(f"a full turn contracts by {brief_text(gain)}" for gain in self.gains.values())
        return "no velocity escapes, every slide leads inward" + (f"; {turns}" if turns else ", no full turn exists")

    def check(self) -> bool:
        """Re-decide from the cones."""
        return self == decide_cones(self.cones)


def decide_fan(partition: Partition) -> FanResult:
    """Decide stability of the equilibrium (the origin) of a centred partition."""
    return decide_cones(build_fan(partition))


def build_fan(partition: Partition) -> tuple[CellCone, ...]:
    """The cones of the cells whose closure holds the origin, counterclockwise."""
    zero = partition.scene.field.zero
    cones = [_cone(cell) for cell in partition.cells_at((zero, zero))]
    cones.sort(key=lambda cone: by_angle(cone.start))
    if len(cones) == 1:
        return tuple(cones)
    # neighbours share one vector per ray, so that gains multiply to the gain of a full turn
    return tuple(replace(cone, end=cones[(k + 1) % len(cones)].start) for k, cone in enumerate(cones))


def decide_cones(cones: Sequence[Cone]) -> FanResult:
    """Decide stability from the fan."""
    fan = tuple(cones)
    gains, overshoot = _turns(fan)
    unstable = [*_escapes(fan), *_slides(fan, outward=True)]
    unstable += [_turn_evidence(fan, sense, gain) for sense, gain in gains.items() if sign(gain - 1) > 0]
    if unstable:
        return FanResult(Translation.UNSTABLE, fan, tuple(unstable), gains, overshoot)
    ties = [*_ties(fan)]
    ties += [
        Evidence(Move.TIE, fan[0].start, (), "a full turn has gain one")
        for gain in gains.values()
        if not sign(gain - 1)
    ]
    if ties:
        return FanResult(Translation.UNDECIDED, fan, tuple(ties), gains, overshoot)
    rest = [*_rests(fan), *_slides(fan, outward=False)]
    verdict = Translation.STABLE if rest else Translation.ASYMPTOTICALLY_STABLE
    return FanResult(verdict, fan, tuple(rest), gains, overshoot)


# ---- geometry of the fan -----------------------------------------------------------------


def _cone(cell: Cell) -> CellCone:
    """The cone of a cell at the origin, from its vertices."""
    vertices = cell.polygon.vertices
    count = len(vertices)
    for k, vertex in enumerate(vertices):
        if not any(vertex):
            return CellCone(vertices[(k + 1) % count], vertices[k - 1], cell.twists, cell)
    for k, vertex in enumerate(vertices):
        after = vertices[(k + 1) % count]
        if not cross(vertex, after) and sign(dot(vertex, after)) < 0:
            return CellCone(after, vertex, cell.twists, cell)
    return CellCone(vertices[0], vertices[0], cell.twists, cell)  # the origin is inside: the cone is the plane


def _compare_angles(a: Point, b: Point) -> int:
    """Order by angle from the positive x axis, counterclockwise."""
    upper = [sign(p[1]) > 0 or (sign(p[1]) == 0 and sign(p[0]) > 0) for p in (a, b)]
    if upper[0] != upper[1]:
        return -1 if upper[0] else 1
    return -sign(cross(a, b))


by_angle = cmp_to_key(_compare_angles)  # key that sorts rays counterclockwise from the positive x axis


def _is_plane(cone: Cone) -> bool:
    return cone.start is cone.end


def _rays(fan: Sequence[Cone]) -> Iterator[tuple[Point, Cone, Cone]]:
    """Each ray with the cone before it and the cone after it (counterclockwise)."""
    if len(fan) == 1:
        return
    for k, cone in enumerate(fan):
        yield cone.start, fan[k - 1], cone


# ---- moves -------------------------------------------------------------------------------


def _escapes(fan: Sequence[Cone]) -> Iterator[Evidence]:
    for cone in fan:
        for twist in cone.twists:
            velocity = twist.velocity
            if any(velocity) and (_is_plane(cone) or (cone.holds(velocity) and _stays(cone, twist))):
                yield Evidence(Move.ESCAPE, velocity, (twist,), None)


def _stays(cone: Cone, twist: Twist) -> bool:
    """For a velocity along a side of the cone: whether its rotation does not bend the path out of the cone."""
    turn = sign(twist.omega)
    leaves_start = not cross(cone.start, twist.velocity) and sign(dot(cone.start, twist.velocity)) > 0 and turn < 0
    leaves_end = not cross(cone.end, twist.velocity) and sign(dot(cone.end, twist.velocity)) > 0 and turn > 0
    return not (leaves_start or leaves_end)


def _slides(fan: Sequence[Cone], *, outward: bool) -> Iterator[Evidence]:
    """Slides that lead outward, or the rays of equilibria."""
    for ray, before, after in _rays(fan):
        twists = tuple(dict.fromkeys(before.twists + after.twists))
        for first, second in product(twists, repeat=2):
            speed = slide_speed(ray, first, second)
            if speed is None:
                continue
            if outward and sign(speed) > 0:
                yield Evidence(Move.SLIDE, ray, (first, second), speed)
                break
            if not outward and not sign(speed):
                yield Evidence(Move.REST, ray, (first, second), speed)
                break


def slide_speed(ray: Point, first: Twist, second: Twist) -> Any | None:
    """Leading nonzero coefficient (a positive multiple of it) of the radial speed of a slide at small distances.

    ``first`` pushes counterclockwise or not at all, ``second`` clockwise or not at all; None where they do not, so
    that the pair is met in the other order or cannot slide.  The speed is ``(N_1 rho_2 - N_2 rho_1)/(N_1 - N_2)`` with
    ``N = n + s omega |r|``; zero means exactly zero for all small s.
    """
    normals = [(cross(ray, t.velocity), t.omega * dot(ray, ray)) for t in (first, second)]
    radials = [dot(ray, t.velocity) for t in (first, second)]
    signs = [sign(n) or sign(w) for n, w in normals]
    if signs[0] < 0 or signs[1] > 0:
        return None
    if signs == [0, 0]:
        return radials[0]
    constant = normals[0][0] * radials[1] - normals[1][0] * radials[0]
    return constant if constant else normals[0][1] * radials[1] - normals[1][1] * radials[0]


def _ties(fan: Sequence[Cone]) -> Iterator[Evidence]:
    """Cones whose behaviour the leading terms do not decide."""
    for cone in fan:
        for twist in cone.twists:
            if not any(twist.velocity) and twist.omega:
                yield Evidence(Move.TIE, cone.start, (twist,), "the body turns about the equilibrium itself")


def _rests(fan: Sequence[Cone]) -> Iterator[Evidence]:
    """Cones in which the body does not move at all."""
    for cone in fan:
        for twist in cone.twists:
            if not any(twist):
                yield Evidence(Move.REST, cone.start, (twist,), twist.omega)


def _may_cross(cone: Cone, twist: Twist, sense: int) -> bool:
    """Whether a path can enter the cone at one ray and leave it at the other, turning in the given sense."""
    velocity = twist.velocity
    return (
        not _is_plane(cone)
        and sense * sign(cross(cone.start, velocity)) > 0
        and sense * sign(cross(cone.end, velocity)) > 0
    )


def _gain(cone: Cone, twist: Twist, sense: int) -> Any:
    """``s'/s`` for entry at ``s r`` and exit at ``s' r'``: distances in units of the rays' vectors."""
    at_start, at_end = cross(cone.start, twist.velocity), cross(cone.end, twist.velocity)
    return at_start / at_end if sense > 0 else at_end / at_start


def _turns(fan: Sequence[Cone]) -> tuple[dict[int, Any], Any]:
    """Gain of a full turn by sense, and the squared overshoot."""
    gains: dict[int, Any] = {}
    overshoot: Any = 1
    for sense in (1, -1):
        steps = [_step(cone, sense) for cone in (fan if sense > 0 else fan[::-1])]
        known = [step for step in steps if step is not None]
        if len(fan) > 1 and len(known) == len(fan):
            gain: Any = 1
            for step in known:
                gain = step[0] * gain
            gains[sense] = gain
        firsts = [_departure(cone, sense) for cone in (fan if sense > 0 else fan[::-1])]
        overshoot = max(overshoot, _largest_chain(firsts, steps))
    return gains, None if any(len(cone.twists) > 1 for cone in fan) else overshoot


def _step(cone: Cone, sense: int) -> tuple[Any, Any] | None:
    """Largest gain of crossing a cone, in the rays' units and squared in length; None where it cannot be crossed."""
    gains = [_gain(cone, twist, sense) for twist in cone.twists if _may_cross(cone, twist, sense)]
    if not gains:
        return None
    gain = max(gains)
    lengths = dot(cone.end, cone.end) / dot(cone.start, cone.start)
    return gain, gain * gain * (lengths if sense > 0 else 1 / lengths)


def _departure(cone: Cone, sense: int) -> Any | None:
    """Largest squared growth from a start anywhere in the cone to its exit; None where no path leaves that way.

    The path from e to the exit ray r' grows by ``|e x v| |r'|/|r' x v|`` for unit e: largest for e at right angles to v
    where the cone holds it, on a ray of the cone otherwise.
    """
    best: Any | None = None
    exit_ray = cone.end if sense > 0 else cone.start
    for twist in cone.twists:
        v = twist.velocity
        leaving = sense * cross(exit_ray, v)
        if _is_plane(cone) or sign(leaving) <= 0:
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


def _largest_chain(firsts: Sequence[Any | None], steps: Sequence[tuple[Any, Any] | None]) -> Any:
    """Largest squared growth: out of one cone, then through consecutive ones, at most once around."""
    best: Any = 1
    for start, first in enumerate(firsts):
        total = first
        for offset in range(1, len(steps)):
            if total is None:
                break
            best = max(best, total)
            step = steps[(start + offset) % len(steps)]
            total = None if step is None else step[1] * total
        if total is not None:
            best = max(best, total)
    return best


def _turn_evidence(fan: Sequence[Cone], sense: int, gain: Any) -> Evidence:
    twists = tuple(cone.twists[0] for cone in fan)
    return Evidence(Move.TURN, fan[0].start if sense > 0 else fan[-1].end, twists, gain)
