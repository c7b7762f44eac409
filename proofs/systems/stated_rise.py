"""Whether a V increases along the field as it is stated, where the right-hand sides only enclose that field.

Sines and cosines of states lie between polynomials (:mod:`nonsmooth.symbolic.sine_enclosures`).  What holds along all
of these holds along the field; a point at which V increases along one of them refutes nothing.  Here the derivative of
V along the stated field is evaluated in balls, inside cells at such a point or beside it: where a ball is positive, V
increases along the solution through its place.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import product
from typing import Any

from flint import arb, ctx

from nonsmooth.symbolic.expression import ExpressionError
from nonsmooth.symbolic.numbers.lazy import evaluated
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.piecewise import PiecewiseExpression, parse_piecewise
from nonsmooth.symbolic.switched_system import SwitchedSystem

BITS = 128
ASIDE = Fraction(1, 256)  # of the half-width: how far beside a point cells are looked into
MOST_STATES = 6  # up to which all sides of a point are looked at


NOT_OF_THE_FIELD = "V increases along polynomials between which sines lie; along the field itself that is not shown"


class _OnSurfaceError(Exception):
    """A place at which some formula switches."""


def rising_place(
    system: SwitchedSystem, lyapunov: PiecewiseExpression, point: Sequence[Any]
) -> tuple[Number, ...] | None:
    """A point or a place beside it at which V is shown to increase along the stated field; None shows nothing.

    Args:
        system: with sines or cosines of states.
        lyapunov: V in the displacement from the checked point, with the states' names.
        point: such a displacement, in the checked cube.
    """
    if not system.named_rhs:
        return None
    with ctx.workprec(BITS):
        return next((tuple(p) for p in _places(system, point) if _rate_at(system, lyapunov, p) > 0), None)


def _places(system: SwitchedSystem, point: Sequence[Any]) -> Iterator[list[Number]]:
    """The point, and places of the cube on all sides of it."""
    centre = [system.field(evaluated(c)) for c in point]
    yield centre
    sides = product((1, -1), repeat=len(centre)) if len(centre) <= MOST_STATES else ()
    for side in sides:
        steps = [system.check.radius * (ASIDE * s / (k + 2)) for k, s in enumerate(side)]
        yield [c * (1 - ASIDE) + step for c, step in zip(centre, steps, strict=True)]


def _rate_at(system: SwitchedSystem, lyapunov: PiecewiseExpression, place: Sequence[Number]) -> arb:
    """A ball around ``grad V . f`` at a place; the whole line where a formula switches there, or is no polynomial."""
    names = (*system.states, *(wave.name for wave in system.names))
    displacement = {name: Polynomial.variable(system.field, names, name) for name in names}
    centre = dict(zip(system.states, system.check.equilibrium, strict=True))
    stated = {name: part + centre[name] if name in centre else part for name, part in displacement.items()}

    def sign_of(expression: Polynomial) -> int:  # what switches holds no sines
        terms = {exponents[: len(place)]: c for exponents, c in expression.terms.items()}
        found = sign(Polynomial(system.field, system.states, terms)(place))
        if not found:
            raise _OnSurfaceError
        return found

    try:
        rates = [part.polynomial(stated, sign_of) for part in system.named_rhs]
        potential = lyapunov.polynomial(displacement, sign_of)
        waves = _waves(system, stated, place)
    except (_OnSurfaceError, ExpressionError):
        return arb(0, "inf")
    values = [*(c.ball() for c in place), *waves]
    slopes = [potential.derivative(name) for name in system.states]
    return sum((_ball(slope * rate, values) for slope, rate in zip(slopes, rates, strict=True)), arb(0))


def _waves(system: SwitchedSystem, stated: Mapping[str, Polynomial], place: Sequence[Number]) -> list[arb]:
    """Balls around the sines and cosines at a place."""
    found = []
    values = [*place, *(system.field.zero for _ in system.names)]  # no wave stands in the argument of another
    for wave in system.names:
        formula = parse_piecewise(wave.argument, system.states)
        argument = system.field(formula.polynomial(stated, _no_sign)(values)).ball()
        found.append(argument.sin() if wave.kind == "sin" else argument.cos())
    return found


def _no_sign(expression: Polynomial) -> int:
    raise ExpressionError(f"required no switching, received {expression}")


def _ball(polynomial: Polynomial, values: Sequence[arb]) -> arb:
    total = arb(0)
    for exponents, c in polynomial.terms.items():
        term = c.ball()
        for value, exponent in zip(values, exponents, strict=True):
            term = term * value**exponent
        total += term
    return total
