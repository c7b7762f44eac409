"""Where the conditions on a V are looked at: a square about the equilibrium, or the plane."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from nonsmooth.analysis.cells.region import Region
from nonsmooth.analysis.cells.switched_cells import (
    FieldCell,
    lyapunov_cells,
    plane,
    square_regions,
    system_cells,
)
from nonsmooth.proofs.systems.ray_moves import are_cones
from nonsmooth.symbolic.number_text import brief_text
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.piecewise import PiecewiseExpression
from nonsmooth.symbolic.switched_system import SwitchedSystem

SHRINKING = Fraction(1, 16)  # of the checked square, where V fails on all of it


@dataclass(frozen=True)
class Domain:
    """Where the conditions on a V are proved: the square ``|x|, |y| <= radius`` about the equilibrium, or the plane.

    Attributes:
        radius: half the side of the square; None for the plane.
    """

    radius: Number | None

    def text(self, states: Sequence[str]) -> str:
        """In words, with the names of the states."""
        bounded = ", ".join(f"abs({name})" for name in states)
        return "the plane" if self.radius is None else f"{bounded} <= {brief_text(self.radius)}"


def domain_names(scene: SwitchedSystem, lyapunov: PiecewiseExpression) -> list[Domain]:
    """Where V is tried, in order; a system of cones with homogeneous V looks the same at every distance."""
    cells = lyapunov_cells(plane_cells(scene), lyapunov, scene.states, scene.origin)
    if are_cones(cells) and all(cell.potential.is_homogeneous for cell in cells):
        return [Domain(None)]
    return [Domain(scene.check.radius * factor) for factor in (1, SHRINKING)]


def domains(scene: SwitchedSystem, lyapunov: PiecewiseExpression) -> list[tuple[Region, ...]]:
    """The regions of :func:`domain_names`."""
    names = domain_names(scene, lyapunov)
    return [plane(scene) if d.radius is None else square_regions(d.radius) for d in names]


def plane_cells(scene: SwitchedSystem) -> tuple[FieldCell, ...]:
    """The cells of the whole plane."""
    return system_cells(scene, plane(scene))
