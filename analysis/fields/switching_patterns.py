"""A plain system as the list of its switching surfaces and its modes, one for each sign pattern that occurs.

The cells of :mod:`nonsmooth.analysis.fields.switched_cells` are cut only where a formula asks for a sign; here every
cell is cut by every surface, so that each mode has the signs of all of them.  Between lines, only patterns of open
cells are met; beside a curve a pattern is kept unless the coefficients of its surfaces exclude it.

This is the slow literal definition of a switched system, with which the tests and the study ``precision`` compare the
cells; no verdict uses it.
"""

from __future__ import annotations

from dataclasses import dataclass

from nonsmooth.analysis.fields.switched_cells import Velocity, plane, smooth_pieces
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.piecewise import SignOf
from nonsmooth.symbolic.surfaces import switching_factors
from nonsmooth.symbolic.system import SystemScene


@dataclass(frozen=True)
class SwitchedSystem:
    """Surfaces ``h_k = 0`` and one smooth field for each pattern of signs.

    Attributes:
        surfaces: irreducible polynomials in the displacement (x, y), leading coefficient 1.
        modes: fields by the signs of the surfaces.
    """

    surfaces: tuple[Polynomial, ...]
    modes: dict[tuple[int, ...], Velocity]


def build_switched_system(scene: SystemScene) -> SwitchedSystem:
    """Surfaces and modes of a plain system in the whole plane.

    Raises:
        TooManyCells: for formulas with very many surfaces.
        SceneError: where a mode is no polynomial.
    """
    surfaces = switching_surfaces(scene)

    def evaluate(sign_of: SignOf) -> tuple[tuple[int, ...], Velocity]:
        return tuple(sign_of(surface) for surface in surfaces), scene.velocity(sign_of)

    return SwitchedSystem(surfaces, dict(mode for _, mode in smooth_pieces(plane(scene), evaluate)))


def switching_surfaces(scene: SystemScene) -> tuple[Polynomial, ...]:
    """Every surface on which a formula switches somewhere in the plane, in the order of the formulas."""
    found: dict[Polynomial, None] = {}

    def evaluate(sign_of: SignOf) -> Velocity:
        def asked(surface: Polynomial) -> int:
            found.update(dict.fromkeys(switching_factors(surface)[1] if surface else ()))
            return sign_of(surface)

        return scene.velocity(asked)

    list(smooth_pieces(plane(scene), evaluate))
    return tuple(found)
