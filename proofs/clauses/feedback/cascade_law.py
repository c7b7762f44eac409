"""Clause 4 under rule ``nearest`` where no quadratic V serves: first theta, then c along the rims.

Where wheel i is nearest the body moves with ``n_i . v + lambda_i omega = 0``, ``lambda_i = n_i . J p_i``; all such
motions can be imposed.  The law ``omega = -k theta`` brings theta to zero, whatever c does.  With ``omega = 0`` what is
left is translation along the rim, ``v = +-|c| d_i``, with a sign for each cell: a planar field of constant directions
on the cones at the equilibrium.  If module ``fan`` shows that every Filippov solution of this
field leads to the equilibrium (by sliding inward along rays between cells, or by full turns that contract), then so
does the whole law: the field is homogeneous of degree one, so it has a homogeneous Lyapunov function (Bernuau, Efimov,
Perruquetti and Polyakov, J. Franklin Inst. 351, 2014), and turning adds no more than a multiple of ``|theta|``, which
decays by itself.

No constant signs help where a cone holds the direction of its own rim and no ray between it and the next such cone
can be slid along inward.  Where full turns exist and their gain is exactly one, to first order every input keeps a
function ``V_0(c)``.  The case that occurs is an omniwheel drive: all nearest rims tangential, ``d_i . p_i = 0``.  There
``V_0 = r = c . p_i/|p_i|``; let ``s = c . J p_i/|p_i|``, ``z = s/r``.  Exact kinematics turn c with the body: ``r' =
-omega s``.  With ``s' = r``, any mu > 0 and ``Theta = theta - mu r z^2/2`` the law ``omega = mu s - Theta`` gives
``r' = -mu s^2 + Theta s`` and ``Theta' = -Theta`` up to terms of second order.  Let m > 0 be the mean of z^2 over a
turn, chi' = z^2 - m its periodic integral, and ``R = r + mu r^2 chi(z)``; then ``R' = -mu m r^2 + Theta s`` up to terms
of third order, so ``R^2 + Theta^2`` decreases strictly near the equilibrium along every solution: R and Theta are
continuous across the rays between cells, and every solution crosses these in the sense of the turn.  With leading-order
kinematics r stays, and there is no such law.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum

from nonsmooth.analysis.cells.fan import CellCone, Cone
from nonsmooth.analysis.cells.moves import slide_speed
from nonsmooth.proofs.clauses.translation.fan_stability import FanResult, decide_cones
from nonsmooth.proofs.verdicts import Translation
from nonsmooth.symbolic.constraints import Twist
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.plane import around, cross, dot
from nonsmooth.symbolic.scene import Wheel

LAW = (
    "u_w = d_w . (v + omega J p_w) for w = i, j with omega = -k theta, v = k |c| e - (n_i . J p_i) omega n_i, "
    "e = {} where that wheel is nearest"
)
SLOW_LAW = (
    "u_w = d_w . (v + omega J p_w) for w = i, j with v = (k - omega) r J p_i/|p_i|, omega = k (s/l - Theta), "
    "Theta = theta - s^2/(2 r l), (r, s) = (c . p_i, c . J p_i)/|p_i|, any length l"
)


class Descent(StrEnum):
    """How c comes home while theta is held."""

    SLIDES = "slides along rays between cells"
    TURNS = "full turns that contract"
    SLOW_TURNS = "full turns of gain one, while the body turns to and fro, like 1/t (exact kinematics)"

    @property
    def reason(self) -> str:
        """How theta and c come home."""
        if self is Descent.SLOW_TURNS:
            return f"all nearest rims are tangential, and c comes home by {self}"
        return f"theta decays by itself, and then c comes home by {self}"


@dataclass(frozen=True)
class CascadeLaw:
    """A sign for every cone, with what shows that it serves.

    Attributes:
        signs: of the translation ``v = sign |c| d_i``, one for each nearest wheel, counterclockwise.
        wheels: the nearest wheels.
        descent: how c comes home.
        fan: the decision about the field of these translations, with the cones in which they are nearest.
    """

    signs: tuple[int, ...]
    wheels: tuple[Wheel, ...]
    descent: Descent
    fan: FanResult

    def __str__(self) -> str:
        if self.descent is Descent.SLOW_TURNS:
            return SLOW_LAW
        signs = ", ".join(
            f"{'+' if s > 0 else '-'}d_{wheel.index}" for s, wheel in zip(self.signs, self.wheels, strict=True)
        )
        return LAW.format(signs)

    def check(self) -> bool:
        """Verify the fan of the field that the signs make, and that it leads home as is said."""
        cones = self.fan.cones
        if not len(cones) == len(self.wheels) == len(self.signs):
            return False
        if _field(cones, self.wheels, self.signs) != cones or not self.fan.check():
            return False
        turns = bool(self.fan.gains)
        if self.descent is Descent.SLOW_TURNS:
            radial = any(dot(wheel.direction, wheel.position) for wheel in self.wheels)
            return turns and not radial and self.fan.verdict is Translation.UNDECIDED
        return self.fan.verdict is Translation.ASYMPTOTICALLY_STABLE and turns == (self.descent is Descent.TURNS)


def find_cascade(fan: Sequence[CellCone]) -> CascadeLaw | None:
    """The first choice of signs that serves, for the cones of an array with two inputs in each; None without."""
    sectors, wheels = _sectors(fan)
    if not sectors:
        return None  # one wheel is the nearest all around: only its rim's line can be followed
    for signs in _proposals(sectors, wheels):
        found = _judged(_field(sectors, wheels, signs), wheels, signs)
        if found is not None:
            return found
    return None


def _sectors(fan: Sequence[CellCone]) -> tuple[list[Cone], tuple[Wheel, ...]]:
    """The cones joined where the same wheel is nearest, with their nearest wheels."""
    nearest = [cone.cell.states[0].rows[0].wheel for cone in fan]
    starts = [k for k, wheel in enumerate(nearest) if wheel != nearest[k - 1]]
    sectors = [Cone(fan[k].start, fan[following].start, ()) for k, following in around(starts)]
    return sectors, tuple(nearest[k] for k in starts)


def _field(fan: Sequence[Cone], wheels: Sequence[Wheel], signs: Sequence[int]) -> tuple[Cone, ...]:
    """The cones with the translation along the rim of their nearest wheel."""
    zero = wheels[0].direction[0] * 0
    return tuple(
        Cone(cone.start, cone.end, (Twist(wheel.direction[0] * s, wheel.direction[1] * s, zero),))
        for cone, wheel, s in zip(fan, wheels, signs, strict=True)
    )


def _judged(cones: Sequence[Cone], wheels: tuple[Wheel, ...], signs: tuple[int, ...]) -> CascadeLaw | None:
    """The law of these signs, where the field of translations leads home or keeps to turns of gain one."""
    result = decide_cones(cones)
    if result.verdict is Translation.ASYMPTOTICALLY_STABLE:
        return CascadeLaw(signs, wheels, Descent.TURNS if result.gains else Descent.SLIDES, result)
    turning = result.verdict is Translation.UNDECIDED and bool(result.gains)
    tangential = not any(dot(wheel.direction, wheel.position) for wheel in wheels)
    return CascadeLaw(signs, wheels, Descent.SLOW_TURNS, result) if turning and tangential else None


# ---- signs worth trying ------------------------------------------------------------------


class _Rays:
    """How the rims lie beside each ray; ray k is the last of cone k and the first of the next."""

    def __init__(self, fan: Sequence[Cone], wheels: Sequence[Wheel]) -> None:
        self.count = len(fan)
        self.rays = [cone.end for cone in fan]
        self.rims = [wheel.direction for wheel in wheels]
        self.first = [sign(cross(d, cone.start)) for d, cone in zip(self.rims, fan, strict=True)]
        self.last = [sign(cross(d, cone.end)) for d, cone in zip(self.rims, fan, strict=True)]
        # where a closed cone holds its own rim's direction, no translation crosses that line; inward on both sides
        held = [a * b <= 0 for a, b in zip(self.first, self.last, strict=True)]
        self.inward = {k: -1 if fan[k].holds(self.rims[k]) else 1 for k in range(self.count) if held[k]}

    def slide(self, k: int) -> int:
        """Sign of the radial speed where both neighbours of a ray push onto it; 0 where that is none."""
        zero, after = self.rays[k][0] * 0, (k + 1) % self.count
        signs = self.inward.get(k, -self.last[k]), self.inward.get(after, self.first[after])
        pushes = zip((self.rims[k], self.rims[after]), signs, strict=True)
        before, behind = (Twist(d[0] * s, d[1] * s, zero) for d, s in pushes)
        speed = slide_speed(self.rays[k], before, behind)
        return 0 if speed is None else sign(speed)

    def towards(self, target: int, start: int, stop: int) -> dict[int, int]:
        """Signs of the cones from ``start`` up to ``stop`` (cyclic) that lead to a ray between them."""
        cones = [k % self.count for k in range(start, stop if stop > start else stop + self.count)]
        turn = cones.index(target) + 1
        return {k: -self.last[k] for k in cones[:turn]} | {k: self.first[k] for k in cones[turn:]}


def _proposals(fan: Sequence[Cone], wheels: Sequence[Wheel]) -> Iterator[tuple[int, ...]]:
    """Full turns in both senses; in each arc between held directions, all cones towards one inward slide."""
    rays = _Rays(fan, wheels)
    slides = [rays.slide(k) for k in range(rays.count)]
    if not rays.inward:
        yield tuple(-a for a in rays.first)
        yield tuple(rays.first)
        inward, outward = (next((k for k, s in enumerate(slides) if s == side), None) for side in (-1, 1))
        if inward is not None and outward is not None:
            signs = rays.towards(inward, outward + 1, outward + 1)
            yield tuple(signs[k] for k in range(rays.count))
        return
    held = sorted(rays.inward)
    signs = dict(rays.inward)
    for start, stop in zip(held, [*held[1:], held[0] + rays.count], strict=True):
        target = next((k % rays.count for k in range(start, stop) if slides[k % rays.count] < 0), None)
        if target is None:
            return
        signs |= rays.towards(target, start, stop) | {start: rays.inward[start]}
    yield tuple(signs[k] for k in range(rays.count))
