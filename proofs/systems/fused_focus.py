"""A fused focus: both fields touch a straight switching line at the equilibrium from inside; solutions turn about it.

Let xi be the line's form and eta a coordinate along it.  With ``xi' = a eta + b xi + q eta^2 + ...`` and
``eta' = -s c + d eta + ...`` on the side where xi has the sign s, and ``a c > 0`` on both sides, a solution that leaves
the line at ``eta_0`` comes back, through the side s, at distance ``eta_0 + k_s eta_0^2 + ...`` with

    k_s = 2/3 ((b + d)/|c| + s q/|a|).

To leading order (weights 2 and 1) the turn is a tie; ``k = k_+ + k_-`` decides: positive is unstable, negative is
asymptotically stable (Filippov 1988, sec. 19; Coll, Gasull and Prohens 2001).
"""

from __future__ import annotations

from dataclasses import dataclass

from nonsmooth.analysis.cells.switched_cells import PlaneField
from nonsmooth.proofs.systems.tangent_fan import Frame, TangentFan, build_tangent_fan
from nonsmooth.symbolic.number_text import brief_text
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.switched_system import SwitchedSystem


@dataclass(frozen=True)
class FusedFocus:
    """A full turn about a fused focus.

    Attributes:
        coefficient: k.
    """

    coefficient: Number

    @property
    def sign(self) -> int:
        """Of k: what the turn does to small distances."""
        return self.coefficient.sign()

    def __str__(self) -> str:
        k = brief_text(self.coefficient)
        return f"a full turn takes a small distance s on the switching line to s + k s^2, k = {k}"


def fused_focus(system: SwitchedSystem, frame: Frame) -> FusedFocus | None:
    """The turn about the equilibrium where the first form of the frame is the only surface there; None elsewhere."""
    fan = build_tangent_fan(system, frame=frame)
    if fan is None or not _only_switches_on_second_axis(fan):
        return None
    sides = [_side(fan, s) for s in (1, -1)]
    kept = [side for side in sides if side is not None]
    if len(kept) < len(sides) or kept[0][0] != kept[1][0]:
        return None
    return FusedFocus((kept[0][1] + kept[1][1]) * 2 / 3)


def _only_switches_on_second_axis(fan: TangentFan) -> bool:
    """Whether one straight surface, the second axis, passes through the point."""
    return all(
        not surfaces or (len(surfaces) == 1 and surfaces[0].degree == 1 and not cone.start[0])
        for cone, surfaces in zip(fan.cones, fan.surfaces, strict=True)
    )


def _side(fan: TangentFan, s: int) -> tuple[int, Number] | None:
    """The sense of the turn and ``(b + d)/|c| + s q/|a|`` on one side; None where the field does not touch inside."""
    field = next(cone.field for cone in fan.cones if sign(cone.start[0] + cone.end[0]) == s)
    a, b, q, offset = (_coefficient(field, 0, e) for e in ((0, 1), (1, 0), (0, 2), (0, 0)))
    c, d = _coefficient(field, 1, (0, 0)) * -s, _coefficient(field, 1, (0, 1))
    if offset or sign(a) * sign(c) <= 0:
        return None
    return sign(a), (b + d) / abs(c) + q * s / abs(a)


def _coefficient(field: PlaneField, row: int, exponents: tuple[int, int]) -> Number:
    return field[row].terms.get(exponents, field[row].field.zero)
