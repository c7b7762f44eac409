"""The field of a cell as it was stated: a polynomial in the states and in sines and cosines of them.

Cells of a system with sines hold the polynomials that enclose its field; pictures, borders and tables show the field
itself.  Without sines it is the one polynomial field of the cell.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from types import ModuleType
from typing import Any

import numpy as np

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.cells.switched_cells import FieldCell, LyapunovCell, sign_on
from nonsmooth.symbolic.formulas.enclosed_functions import INVERSE, NORM
from nonsmooth.symbolic.formulas.piecewise import SignOf
from nonsmooth.symbolic.numbers.plane_arrays import Floats, Mask
from nonsmooth.symbolic.numbers.polynomial import BEYOND_FLOATS, Polynomial
from nonsmooth.symbolic.systems.switched_system import PLANE, SwitchedSystem


@dataclass(frozen=True)
class StatedWave:
    """A sine, or another function that is enclosed.

    Attributes:
        kind: its name.
        argument: a polynomial in the displacement from the checked point.
    """

    kind: str
    argument: Polynomial

    def text(self, states: Sequence[str]) -> str:
        """As a formula, with the names of the states."""
        argument = replace(self.argument, variables=tuple(states))
        return f"({argument})**(-1/2)" if self.kind == INVERSE else f"{self.kind}({argument})"


@dataclass(frozen=True)
class StatedField:
    """The rates of all states inside a cell; pictures and values at places are those of two.

    Attributes:
        rates: polynomials in the displacement from the checked point and in one variable for each of the waves.
        waves: what these variables are.
    """

    rates: tuple[Polynomial, ...]
    waves: tuple[StatedWave, ...] = ()

    def names(self, states: Sequence[str]) -> tuple[str, ...]:
        """The variables of the rates as formulas."""
        return (*states, *(wave.text(states) for wave in self.waves))

    def texts(self, states: Sequence[str]) -> list[str]:
        """The rates as formulas."""
        names = self.names(states)
        return [str(replace(rate, variables=names)) for rate in self.rates]

    def at(self, place: Point) -> tuple[Any, Any]:
        """The rates at a place: exact numbers, or floats where there are sines and cosines."""
        first, second = self.rates
        if not self.waves:
            return first(place), second(place)
        values = [float(c) for c in place]
        values += [wave_value(wave.kind, float(wave.argument(place)), math) for wave in self.waves]
        return _float_value(first, values), _float_value(second, values)


def wave_value(kind: str, argument: Any, library: ModuleType) -> Any:
    """A function that is enclosed in floats, by a library; of roots of squares, which rounded may be negative, too."""
    if kind not in (NORM, INVERSE):
        return getattr(library, kind)(argument)
    root = library.sqrt(abs(argument))
    return root if kind == NORM else 1 / (root + np.finfo(float).tiny)


def _float_value(polynomial: Polynomial, values: Sequence[float]) -> float:
    terms = polynomial.terms.items()
    return math.fsum(
        float(c) * math.prod(v**e for v, e in zip(values, exponents, strict=True)) for exponents, c in terms
    )


def stated_fields(system: SwitchedSystem, cells: Sequence[FieldCell]) -> tuple[StatedField, ...]:
    """The field of each cell.

    Args:
        system: in two states, with one stated field.
        cells: its cells.
    """
    if not system.rewriting.names:
        return tuple(StatedField(cell.velocities[0]) for cell in cells)
    return tuple(stated_field(system, PLANE, partial(sign_on, cell.region)) for cell in cells)


def stated_field(system: SwitchedSystem, displacement: tuple[str, ...], sign_of: SignOf) -> StatedField:
    """The field where switching expressions have given signs.

    Args:
        system: in any number of states, with one stated field.
        displacement: names of the displacement from the checked point.
        sign_of: the sign of an expression in these; inside switching parts there are no sines.
    """
    variables = (*displacement, *(wave.name for wave in system.rewriting.names))
    number, centre, states = system.field, system.check.equilibrium, system.displaced(displacement)
    named = system.named(
        [Polynomial.variable(number, variables, v) + c for v, c in zip(displacement, centre, strict=True)]
    )
    named |= {wave.name: Polynomial.variable(number, variables, wave.name) for wave in system.rewriting.names}

    def sign_in_states(expression: Polynomial) -> int:
        terms = {exponents[: len(displacement)]: c for exponents, c in expression.terms.items()}
        return sign_of(Polynomial(expression.field, displacement, terms))

    rates = tuple(part.polynomial(named, sign_in_states) for part in system.rewriting.named_rhs or system.rhs)
    waves = (StatedWave(wave.kind, system.argument_of(wave, states, sign_of)) for wave in system.rewriting.names)
    return StatedField(rates, tuple(waves))


# ---- values at many places -----------------------------------------------------------------------
#
# In floats, for pictures and samples.


def polynomial_values(polynomial: Polynomial, xs: Floats, ys: Floats) -> Floats:
    """A polynomial in two variables at many places, of any shape."""
    return _values(polynomial, [xs, ys])


def rate_values(field: StatedField, xs: Floats, ys: Floats) -> tuple[Floats, Floats]:
    """The rates of both states at many places, of any shape."""
    values = [xs, ys]
    for wave in field.waves:
        argument = polynomial_values(wave.argument, xs, ys)
        values.append(wave_value("arctan" if wave.kind == "atan" else wave.kind, argument, np))
    first, second = (_values(rate, values) for rate in field.rates)
    return first, second


@BEYOND_FLOATS
def _values(polynomial: Polynomial, variables: list[Floats]) -> Floats:
    """A polynomial in any number of variables at many places."""
    total = np.zeros_like(variables[0])
    for exponents, c in polynomial.terms.items():
        term = np.full_like(variables[0], float(c))
        for variable, exponent in zip(variables, exponents, strict=True):
            term = term * variable**exponent if exponent else term
        total += term
    return total


def inside(cell: FieldCell, xs: Floats, ys: Floats) -> Mask:
    """Which places lie in a closed cell."""
    kept = np.ones(xs.shape, dtype=bool)
    for a, b, c in cell.region.sides:
        kept &= float(a) * xs + float(b) * ys + float(c) >= 0
    for guard in cell.region.guards:
        kept &= polynomial_values(guard, xs, ys) >= 0
    return kept


def potential_values(cells: Iterable[LyapunovCell], places: Floats) -> Floats:
    """V at places in the displacement from the checked point; infinite outside all cells.

    Args:
        cells: of the domain of V.
        places: (m, 2).

    Returns:
        (m,) values.
    """
    xs, ys = places[:, 0], places[:, 1]
    values = np.full(len(places), np.inf)
    for cell in cells:
        here = inside(cell, xs, ys)
        values[here] = polynomial_values(cell.potential, xs[here], ys[here])
    return values
