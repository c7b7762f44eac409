"""Plain switched systems as fields to simulate: smooth modes in floats, or constant motions on exact cells."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from math import prod

import numpy as np

from nonsmooth.analysis.fields.sign_field import SignField, Signs
from nonsmooth.analysis.fields.smooth_field import Surface, Vector, Velocity
from nonsmooth.analysis.fields.switched_cells import FieldCell, square_regions, system_cells
from nonsmooth.analysis.fields.switched_field import ConstantField, piecewise_constant
from nonsmooth.analysis.fields.switching_patterns import build_switched_system
from nonsmooth.analysis.partitions.polygon import HalfPlane, square
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.surfaces import switching_factors
from nonsmooth.symbolic.system import PLANE, SystemScene


def system_field(scene: SystemScene) -> SignField:
    """The modes of a plain system in the displacement from its equilibrium, in floats.

    Raises:
        TooManyCells: for formulas with very many surfaces.
        SceneError: where a mode is no polynomial.
    """
    system = build_switched_system(scene)
    surfaces = tuple(_surface(surface) for surface in system.surfaces)
    modes = {signs: _velocity(*velocity) for signs, velocity in system.modes.items()}

    def flow(signs: Signs) -> Velocity:
        if signs not in modes:  # a pattern without a cell: relays with hysteresis pass through such
            modes[signs] = _velocity(
                *scene.velocity(partial(_sign_by_factors, dict(zip(system.surfaces, signs, strict=True))))
            )
        return modes[signs]

    return SignField(scene.states, surfaces, flow, size=float(scene.check.radius))


def _sign_by_factors(signs: Mapping[Polynomial, int], inner: Polynomial) -> int:
    """Sign of an inner expression for given signs of the surfaces; what no cell ever asks for counts as positive."""
    if not inner:
        return 0
    total, factors = switching_factors(inner)
    return total * prod(signs.get(factor, 1) for factor in factors)


def constant_system(scene: SystemScene, *, exact: bool = False) -> ConstantField | None:
    """A plain system on its checked square as constant motions on polygons; None where it is not of that kind."""
    cells = system_cells(scene, square_regions(scene.check.radius))
    pieces = []
    for cell in cells:
        rates = [component.constant_value for component in cell.velocities[0]]
        if cell.region.guards or any(rate is None for rate in rates):
            return None
        pieces.append((_half_planes(cell), (*rates, scene.field.zero)))
    zero = scene.field.zero
    return piecewise_constant(square((zero, zero), scene.check.radius), pieces, exact=exact)


def _half_planes(cell: FieldCell) -> list[HalfPlane]:
    return [HalfPlane((-a, -b), c) for a, b, c in cell.region.sides]


def _surface(surface: Polynomial) -> Surface:
    value, slopes = float_form(surface), [float_form(surface.derivative(name)) for name in PLANE]
    return Surface(f"{surface}", value, lambda x: np.array([slope(x) for slope in slopes]), surface.degree <= 1)


def _velocity(first: Polynomial, second: Polynomial) -> Velocity:
    f, g = float_form(first), float_form(second)
    return lambda t, x: np.array([f(x), g(x)])


def float_form(polynomial: Polynomial) -> Callable[[Vector], float]:
    """A polynomial in floats, each coefficient rounded once."""
    terms = [(float(c), *exponents) for exponents, c in polynomial.terms.items()]
    return lambda x: float(sum(c * x[0] ** a * x[1] ** b for c, a, b in terms))
