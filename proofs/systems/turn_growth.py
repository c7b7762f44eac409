"""How much a full turn about the equilibrium multiplies small distances, enclosed by balls.

Along a homogeneous field f without radial directions ``d log|c| / d angle = (c . f)/(c x f)``.  On a cone with rays a
and b and ``c = (1 - t) a + t b`` this is the integral over 0 < t < 1 of ``(c . f)(a x b) / ((c x f)(c . c))``, a
rational function without poles there, which is enclosed with all digits that are needed (arb: Johansson 2018).  The sum
over all cones, in the sense in which solutions turn, is the logarithm of the factor.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from flint import acb, acb_poly, arb, ctx

from nonsmooth.proofs.systems.tangent_fan import TangentCone, TangentFan, turning
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.polynomial import Polynomial, in_generators
from nonsmooth.symbolic.plane import cross, dot

PRECISIONS = (64, 128, 256)  # bits, tried in turn until the sign is clear


@dataclass(frozen=True)
class TurnGrowth:
    """A full turn.

    Attributes:
        sense: 1 counterclockwise, -1 clockwise.
        low: a lower bound of the factor.
        high: an upper bound of it.
        sign: of the factor's logarithm; 0 where it is not known.
    """

    sense: int
    low: str
    high: str
    sign: int

    def __str__(self) -> str:
        return f"a full turn multiplies small distances by a factor between {self.low} and {self.high}"


def turn_growth(fan: TangentFan) -> TurnGrowth | None:
    """The growth of a full turn; None where not all cones are turned through in one sense."""
    senses = {_sense(cone) for cone in fan.cones}
    if len(senses) != 1 or 0 in senses:
        return None
    sense = senses.pop()
    total = arb(0)
    for bits in PRECISIONS:
        with ctx.workprec(bits):
            total = sum((_integral(cone, sense) for cone in fan.cones), arb(0))
            if total > 0 or total < 0:
                break
    return growth_of_logarithm(total, sense)


def growth_of_logarithm(total: arb, sense: int) -> TurnGrowth:
    """The turn whose factor has an enclosed logarithm."""
    found = 1 if total > 0 else -1 if total < 0 else 0
    factor = total.exp()
    return TurnGrowth(sense, factor.lower().str(8, radius=False), factor.upper().str(8, radius=False), found)


def _sense(cone: TangentCone) -> int:
    """The sense in which the field turns; read off at both rays and inside, where it is known to keep its sign."""
    across = turning(cone.leading)[0]
    inner = (cone.start[0] + cone.end[0], cone.start[1] + cone.end[1])
    signs = {sign(across(ray)) for ray in (cone.start, inner, cone.end)}
    return signs.pop() if len(signs) == 1 else 0


def _integral(cone: TangentCone, sense: int) -> arb:
    rate = growth_on_chord(cone, sense)
    return arb(acb.integral(lambda t, _: rate(t), 0, 1).real)


def growth_on_chord(cone: TangentCone, sense: int) -> Callable[[acb], acb]:
    """``d log|c| / dt`` along ``c = (1 - t) start + t end`` for solutions that turn in the given sense."""
    across, radial = (_on_chord(form, cone) for form in turning(cone.leading))
    x, y = (Polynomial.variable(cone.leading[0].field, cone.leading[0].variables, name) for name in "xy")
    square = _on_chord(dot((x, y), (x, y)), cone)
    area = acb(_ball(cross(cone.start, cone.end))) * sense
    return lambda t: radial(t) * area / (across(t) * square(t))


def _on_chord(form: Polynomial, cone: TangentCone) -> acb_poly:
    """A form on ``(1 - t) start + t end``, with balls for coefficients."""
    terms = in_generators(form.terms, [cone.start, cone.end])
    share, rest = acb_poly([0, 1]), acb_poly([1, -1])
    total = acb_poly([0])
    for (first, second), c in terms.items():
        total += acb_poly([acb(_ball(form.field(c)))]) * rest ** int(first) * share ** int(second)
    return total


def _ball(number: Number) -> arb:
    return number.ball()
