"""What the report of a plain system is about: the system with its verdict, and its cells."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property

from nonsmooth.analysis.cells.switched_cells import FieldCell, square_regions, system_cells
from nonsmooth.analysis.fields.stated_field import StatedField, stated_field
from nonsmooth.proofs.findings import Record
from nonsmooth.proofs.inequalities.curved_regions import ClosureMembership, closure_membership
from nonsmooth.proofs.kernel.cells import SignCells, adjoining, build_cells
from nonsmooth.proofs.system_decision import StabilityResult, decide_system
from nonsmooth.proofs.systems.findings import ExaminedFunction, Method, PlaneFunction
from nonsmooth.proofs.systems.ray_moves import values_at_origin
from nonsmooth.reports.checks.phase_portrait import PhasePortrait
from nonsmooth.reports.checks.subject import (
    BACCIOTTI_CERAGIOLI,
    FILIPPOV,
    HOMOGENEITY,
    SHEVITZ_PADEN,
    Reference,
    ReportSubject,
)
from nonsmooth.reports.checks.system_results import SystemCheckResult
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem, signs_by_factors


class SystemSubject(ReportSubject):
    """A plain system in any number of states."""

    scene: SwitchedSystem
    left_out = ()

    @cached_property
    def result(self) -> StabilityResult:
        """The stability of the checked point."""
        return decide_system(self.scene)

    @property
    def headline(self) -> str:
        """The stability of the checked point."""
        return str(self.result.verdict)

    @property
    def shown(self) -> ExaminedFunction | None:
        """The V that shows the verdict, else the scene's; None where none is looked at."""
        function: ExaminedFunction | None = self.result.function or self.result.given
        return function

    @cached_property
    def seen(self) -> SwitchedSystem:
        """The system whose cells are told; with the velocities of states, in roots, where V falls along these."""
        roots = self.scene.by_roots and self.result.scene.by_roots  # nothing is decided where there are none
        return roots.unscaled if roots and self.result.is_in_time_of_states else self.scene

    @property
    def is_in_plane(self) -> bool:
        """Whether it has two states and no roots of them: then cells are polygons of the states, and can be drawn."""
        return self.scene.is_planar and not self.scene.by_roots

    @cached_property
    def polygons(self) -> tuple[FieldCell, ...]:
        """The cells of the checked square in the plane, measured from the checked point."""
        return system_cells(self.scene, square_regions(self.scene.check.radius))

    @cached_property
    def sign_cells(self) -> SignCells:
        """The cells of the checked cube in any number of states, by the signs of switching surfaces.

        Raises:
            BeyondReachError: where there are too many.
        """
        return build_cells(self.seen, self.seen.check.radius, irrational=True)

    def fields(self) -> Iterator[tuple[str, list[StatedField]]]:
        """The signs of each of these cells, with the one stated field, or with every one that may act.

        Raises:
            BeyondReachError: where there are too many.
        """
        system, cells = self.seen, self.sign_cells
        stated = (system,) if system.rewriting.names else system.members
        for cell in cells.cells:
            sign_of = signs_by_factors(dict(zip(cells.surfaces, cell.signs, strict=True)))
            signs = " ".join("+" if sign > 0 else "-" for sign in cell.signs)
            yield signs, [stated_field(member, system.states, sign_of) for member in stated]

    def values_at_point(self) -> list[tuple[Number, ...]]:
        """The values at the checked point of the velocities in all cells that may touch it: mixtures of these are F.

        Where roots of states scale the velocities they are those of the stated right-hand sides.

        Raises:
            BeyondReachError: where there are too many cells.
        """
        if self.is_in_plane:
            near = (cell for cell in self.polygons if closure_membership(cell.region) is not ClosureMembership.NO)
            return list(values_at_origin(near))
        system = self.scene.by_roots.unscaled if self.scene.by_roots else self.scene
        cells, number = build_cells(system, system.check.radius, irrational=True), system.field
        velocities = (velocity for cell in adjoining(cells) for velocity in cell.velocities)
        return list(dict.fromkeys(tuple(number(part.at_origin) for part in velocity) for velocity in velocities))

    @cached_property
    def portrait(self) -> PhasePortrait:
        """Cells, borders and picture, in the plane.

        Raises:
            SceneError: under arbitrary switching.
        """
        return PhasePortrait(self.scene)

    @property
    def records(self) -> Record:
        """The verdict, and the phase portrait of one field in the plane."""
        is_drawn = self.is_in_plane and self.scene.has_one_field
        portrait = self.portrait.facts() if is_drawn else None
        return {"check": SystemCheckResult(self.result).facts(), "phase_portrait": portrait}

    @property
    def works(self) -> list[Reference]:
        """Filippov, the authors of the derivatives of V, and of leading terms where these decide."""
        works = [FILIPPOV]
        if isinstance(self.shown, PlaneFunction):
            works.append(SHEVITZ_PADEN)
        if self.shown is not None:
            works.append(BACCIOTTI_CERAGIOLI)
        return [*works, HOMOGENEITY] if self.result.by(Method.LEADING) is not None else works
