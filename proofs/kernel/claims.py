"""The claims about a function V of a plain system, or about all functions of a basis, as the checker derives them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from nonsmooth.proofs.checker.cells import Cell, Inclusion, System
from nonsmooth.proofs.checker.lyapunov import Lyapunov
from nonsmooth.proofs.checker.polynomials import Polynomial
from nonsmooth.proofs.checker.positivity import Claim, Proofs
from nonsmooth.proofs.checker.work import BUDGET


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

    def __init__(self, system: System, cells: dict[str, Any], functions: Sequence[str]) -> None:
        BUDGET.grant(1 << 60)  # nobody forged this: it is the search's own question
        self.collected = Collected()
        super().__init__(Inclusion(system, cells, list(functions), self.collected), self.collected)
        self.number = 0

    def potential(self, cell: Cell) -> Polynomial:
        """The function with the number, on a cell."""
        return cell.functions[self.number]

    def claims(self, number: int = 0, *, positive: bool = True, strict: bool = True) -> list[Claim]:
        """What Lyapunov's theorem asks of a function: that it is positive, and that it falls."""
        self.number = number
        self.proofs = self.collected = Collected()
        if positive:
            self.show_positive()
        self.show_falls("", self.zero, strict=strict)
        return self.collected.claims
