"""The claims about a function V of a plain system, or about all functions of a basis, as the checker derives them."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from fractions import Fraction
from typing import Any

from nonsmooth.proofs.checker.cells import Cell, Face, Inclusion, SurfaceSigns, System
from nonsmooth.proofs.checker.lyapunov import Lyapunov
from nonsmooth.proofs.checker.polynomials import Polynomial
from nonsmooth.proofs.checker.positivity import Claim, Proofs


class Collected(Proofs):
    """Claims that are noted when they are asked, and shown later."""

    def __init__(self) -> None:
        super().__init__({})
        self.claims: list[Claim] = []

    def show(self, claim: Claim) -> None:
        """Note a claim."""
        self.claims.append(claim)
        self.note_form(claim)


class Functions(Lyapunov):
    """The claims about each of some functions, on common cells and faces.

    Attributes:
        number: of the function that is V.
    """

    def __init__(self, system: System, cells: dict[str, Any], functions: Sequence[str | list[list[str]]]) -> None:
        self.collected = Collected()
        super().__init__(Inclusion(system, cells, list(functions), self.collected), self.collected)
        self.number = 0
        self._known: dict[Hashable, Any] = {}  # of all functions: guards and pushes

    def listed(self, cell: Cell) -> Polynomial:
        """The function with the number, on a cell."""
        return cell.functions[self.number]

    def _guards(self, face: Face, signs: SurfaceSigns, cell: Cell) -> dict[str, Polynomial] | None:
        """The guards on a face, which are the same for all functions."""
        key = face.zero, tuple(signs.items()), self.below
        if key not in self._known:
            self._known[key] = super()._guards(face, signs, cell)
        found: dict[str, Polynomial] | None = self._known[key]
        return found

    def _pushes(self, face: Face, field: Sequence[Polynomial]) -> tuple[Polynomial, ...]:
        """The pushes of a field of a cell on a face, which are the same for all functions."""
        key = face.zero, id(field)
        if key not in self._known:
            self._known[key] = super()._pushes(face, field)
        found: tuple[Polynomial, ...] = self._known[key]
        return found

    def claims(self, number: int = 0, *, positive: bool = True, strict: bool = True) -> list[Claim]:
        """What Lyapunov's theorem asks of a function: that it is positive, and that it falls."""
        self.number = number
        self.proofs = self.collected = Collected()
        if positive:
            self.show_positive()
        self.show_falls("", self.zero, strict=strict)
        return self.collected.claims

    def claims_by_square(self, speed: Fraction) -> list[Claim]:
        """That ``V' <= -speed V^2`` where V is not positive, of the first function."""
        self.number, self.below = 0, Fraction(0)
        self.proofs = self.collected = Collected()
        self.show_falls_by_square(speed)
        return self.collected.claims
