"""A load model in one file: springs of known stiffness, which need not be equal."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from nonsmooth.symbolic.mechanics.contact_states import inner, scaled
from nonsmooth.symbolic.mechanics.load_model import Arithmetic, LoadModel, Three, X
from nonsmooth.symbolic.numbers.number import Number


@dataclass(frozen=True)
class StiffSprings(LoadModel):
    """``N_i = k_i m_i . G_A^-1 (1, c)``, ``G_A = sum over A of k_j m_j m_j^T``: the least ``sum N_i^2/k_i``.

    Attributes:
        stiffness: k_i of every wheel.
    """

    stiffness: tuple[Number, ...]

    @property
    def words(self) -> str:
        """For people."""
        return f"springs of stiffness {', '.join(map(str, self.stiffness))}"

    def on(self, places: Sequence[int]) -> StiffSprings:
        """With the stiffness of these wheels."""
        return StiffSprings(tuple(self.stiffness[k] for k in places))

    def forms(
        self, moments: Sequence[Three[X]], carrying: Collection[int], arithmetic: Arithmetic[X]
    ) -> list[Three[X]] | None:
        """None for wheels on one line."""
        if not carrying:
            return None
        stiffness = [arithmetic.number(k) for k in self.stiffness]

        def row(r: int) -> Three[X]:
            pressed = [scaled(moments[j], stiffness[j] * moments[j][r]) for j in sorted(carrying)]
            x, y, z = (sum(entries[1:], entries[0]) for entries in zip(*pressed, strict=True))
            return x, y, z

        columns = arithmetic.inverse(row(0), row(1), row(2))
        if columns is None:
            return None
        x, y, z = columns
        return [scaled((inner(x, m), inner(y, m), inner(z, m)), k) for m, k in zip(moments, stiffness, strict=True)]
