"""The energy of masses whose springs join them, as a candidate for a V that does not rise.

Let each place x_i change at a multiple of a speed, ``x_i' = a_i v_i``, and ``v_i' = f_i(x) + ...`` with further terms
that hold speeds.  Of positive masses m_i with ``m_i/a_i df_i/dx_j = m_j/a_j df_j/dx_i`` the energy is

    V = U(x) + sum_i m_i v_i^2/2,    dU/dx_i = -m_i f_i/a_i,

and the further terms alone change it.  It is a proposal: whoever takes it proves what it says.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction

from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression, SignOf, no_sign, parse_piecewise
from nonsmooth.symbolic.formulas.trees import ExpressionError
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem


@dataclass(frozen=True)
class Place:
    """A state that changes at a multiple of another one.

    Attributes:
        name: of the state.
        number: of the state, from 0.
        speed: the number of the other one.
        slope: ``-f/a`` as a polynomial in the displacement: dU by this state, for a mass of one.
    """

    name: str
    number: int
    speed: int
    slope: Polynomial


def coupled_energy(system: SwitchedSystem) -> PiecewiseExpression | None:
    """V in the displacement; None where not every state is such a place or its speed, and for forces without a V.

    Nor is there one of a single mass, whose energy is a sum of functions of one state each.
    """
    with suppress(SceneError, ExpressionError):
        places = _places(system)
        masses = _masses(places) if len(places) > 1 else None
        if masses is None:
            return None
        states = system.coordinates()
        total = states[0] * 0
        for place in places:
            speed, mass = states[place.speed], masses[place.number]
            total = total + speed * speed * (mass / 2)
            for degree in range(place.slope.degree + 1):
                work = place.slope.part(degree) * states[place.number]
                total = total + work * (mass / (degree + 1))
        return parse_piecewise(str(total), system.states)
    return None


def _places(system: SwitchedSystem) -> list[Place]:
    """The states that change at multiples of others; none where there are others beside these."""
    speeds = {}
    for place, side in enumerate(system.rhs):
        terms = {} if side.switching_parts else side.polynomial(_named(system), no_sign).terms
        if len(terms) == 1 and sum(next(iter(terms))) == 1:
            ((exponents, rate),) = terms.items()
            speeds[place] = (exponents.index(1), rate)
    different = {speed for speed, _ in speeds.values()} - set(speeds)
    if len(different) < len(speeds) or 2 * len(speeds) != len(system.states):
        return []
    fields = [system.members[0].velocity(_beside(system, side), system.displaced(system.states)) for side in (1, -1)]
    places = []
    for place, (speed, rate) in speeds.items():
        force = (fields[0][speed] + fields[1][speed]) * Fraction(1, 2)  # so that dry friction drops out
        slope = force * (-1 / rate)
        still = {e: c for e, c in slope.terms.items() if not any(e[k] for k in different)}
        places.append(Place(system.states[place], place, speed, Polynomial(slope.field, slope.variables, still)))
    return places


def _named(system: SwitchedSystem) -> Mapping[str, Polynomial]:
    return system.named(system.displaced(system.states))


def _beside(system: SwitchedSystem, side: int) -> SignOf:
    """The signs of surfaces at the point, and one sign for all that vanish there."""
    origin = [system.field.zero] * len(system.states)
    return lambda surface: surface(origin).sign() or side


def _masses(places: list[Place]) -> dict[int, Number] | None:
    """The masses by the numbers of places, 1 for the first of those that springs join; None where there are none."""
    masses: dict[int, Number] = {}
    for first in places:
        if first.number in masses:
            continue
        masses[first.number] = first.slope.field.one
        waiting = [first]
        while waiting:
            place = waiting.pop()
            for other in places:
                ratio = _ratio(place.slope.derivative(other.name), other.slope.derivative(place.name))
                if ratio is None:
                    return None
                mass = masses[place.number] * ratio
                if not ratio:
                    continue
                if other.number not in masses:
                    masses[other.number] = mass
                    waiting.append(other)
                if masses[other.number] != mass:
                    return None
    return masses


def _ratio(one: Polynomial, other: Polynomial) -> Number | None:
    """The positive factor between two polynomials, 0 where both vanish; None where there is none."""
    if not one and not other:
        return one.field.zero
    if not one or not other:
        return None
    exponents = next(iter(one.terms))
    if exponents not in other.terms:
        return None
    ratio = one.terms[exponents] / other.terms[exponents]
    return ratio if ratio > 0 and one == other * ratio else None
