"""Where the conditions on a V are looked at: a square about the equilibrium, or the plane."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from nonsmooth.analysis.cells.region import Region
from nonsmooth.analysis.cells.switched_cells import (
    FieldCell,
    LyapunovCell,
    lyapunov_cells,
    plane,
    square_regions,
    system_cells,
)
from nonsmooth.proofs.systems.decay_rate import SLACK, simple_below
from nonsmooth.proofs.systems.ray_moves import are_cones
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_text import brief_text
from nonsmooth.symbolic.systems.switched_system import PLANE, SwitchedSystem

SHRINKING = Fraction(1, 16)  # of the checked square, where V fails on all of it


WHOLE = {1: "the line", len(PLANE): "the plane"}


@dataclass(frozen=True)
class Domain:
    """Where the conditions on a V are proved: a cube about the equilibrium, in two states a square, or the whole space.

    Attributes:
        radius: half the side of the cube; None for the whole space.
    """

    radius: Number | None

    @property
    def rational(self) -> Domain:
        """The same, or a cube that is a little smaller: certificates know half-widths without roots."""
        if self.radius is None or self.radius.as_rational() is not None:
            return self
        return Domain(self.radius.field(simple_below(Fraction(float(self.radius)) * (1 - SLACK))))

    def text(self, states: Sequence[str]) -> str:
        """In words, with the names of the states."""
        if self.radius is None:
            return WHOLE.get(len(states), "the whole space")
        return cube_text(self.radius, states)

    def kind(self, states: Sequence[str]) -> str:
        """In one word."""
        whole, bounded = ("plane", "square") if len(states) == len(PLANE) else ("space", "cube")
        return whole if self.radius is None else bounded


def cube_text(radius: Number | Fraction, states: Sequence[str]) -> str:
    """A cube about the equilibrium in words."""
    bounded = ", ".join(f"abs({name})" for name in states)
    return f"{bounded} <= {radius if isinstance(radius, Fraction) else brief_text(radius)}"


def domains(scene: SwitchedSystem, lyapunov: PiecewiseExpression, cells: Sequence[FieldCell]) -> list[Domain]:
    """Where V is tried, in order; a system of cones with homogeneous V looks the same at every distance.

    Args:
        scene: in two states.
        lyapunov: V.
        cells: of the plane.
    """
    bent = lyapunov_cells(cells, lyapunov, scene.states, scene.origin)
    if are_cones(cells) and all(cell.potential.is_homogeneous for cell in bent):
        return [Domain(None)]
    return [Domain(scene.check.radius * factor) for factor in (1, SHRINKING)]


def domain_regions(scene: SwitchedSystem, radius: Number | None) -> tuple[Region, ...]:
    """The square of a half-width, or the plane, in regions."""
    return plane(scene) if radius is None else square_regions(radius)


def given_cells(scene: SwitchedSystem, domain: Domain) -> tuple[LyapunovCell, ...]:
    """The cells of a domain, cut further where the scene's V bends."""
    return scene_cells(scene, domain_regions(scene, domain.radius))


def scene_cells(scene: SwitchedSystem, regions: Sequence[Region]) -> tuple[LyapunovCell, ...]:
    """The same of some regions."""
    return lyapunov_cells(system_cells(scene, regions), scene.check.lyapunov, scene.states, scene.origin)


def plane_cells(scene: SwitchedSystem) -> tuple[FieldCell, ...]:
    """The cells of the whole plane."""
    return system_cells(scene, plane(scene))
