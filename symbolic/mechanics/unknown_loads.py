"""Normal forces that are known only to lie in a set.

*Admissible* at a centre of mass c is every ``N >= 0`` with ``sum N_i = 1`` and ``sum N_i p_i = c`` (total weight 1): a
polytope.  A *scatter* bounds how far the springs under a rigid body are from equal, which leaves a smaller set: a wheel
in contact carries ``N_i = k_i (m_i . y - h_i)``, ``m_i = (1, p_i)``, y the pose of the body, with ::

    |h_i| <= height times the mean deflection 1/(n k),      |k_i/k - 1| <= stiffness.

The sets themselves: :mod:`nonsmooth.analysis.cells.load_sets`.
"""

from __future__ import annotations

from dataclasses import dataclass

from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_text import brief_text


@dataclass(frozen=True)
class LoadScatter:
    """How far the springs are from equal; not both zero.

    Attributes:
        height: largest difference of a wheel's height from the common one, as a share of the mean deflection.
        stiffness: largest relative difference of a stiffness from the common one, below 1.
    """

    height: Number
    stiffness: Number


@dataclass(frozen=True)
class UnknownLoads:
    """Every load of a set: the admissible ones, or with a scatter those of springs that are not quite equal."""

    scatter: LoadScatter | None = None

    @property
    def words(self) -> str:
        """Which loads are meant, for people."""
        if self.scatter is None:
            return "any (every N >= 0 that carries the weight and balances moments)"
        parts = {"heights": self.scatter.height, "stiffnesses": self.scatter.stiffness}
        named = " and ".join(f"{name} scattered by {brief_text(share)}" for name, share in parts.items() if share)
        return f"elastic, {named}"
