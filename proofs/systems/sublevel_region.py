"""Regions of attraction that are certified by a level of V.

Solutions that start where ``V < c`` stay there and reach the point if V is at least c on the border of a cube about it,
and falls where ``V < c``.  Just above the largest certified c a point refutes: on the border with V below it, or inside
with ``V' >= 0``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression


@dataclass(frozen=True)
class SublevelRegion:
    """Starts that stay in the square and reach the equilibrium.

    Attributes:
        level: every solution from ``V < level`` stays there.
        refuted: a larger level for which that is not shown; None where none was looked at.
        point: a point with V at most the refuted level, on the border or with a V that does not fall; None where the
            larger level is merely undecided.
        radius: half the side of the square, a number of the system's field, or rational in many states.
        falls: whether V is proved to fall on all of the square.
        proofs: the evidence by the names of the checker's claims, where it is found in that form.
    """

    level: Fraction
    refuted: Fraction | None
    point: Any
    radius: Any
    falls: bool
    proofs: Mapping[str, Any] = field(default_factory=dict, hash=False)

    def __str__(self) -> str:
        return f"V < {self.level}"


@dataclass(frozen=True)
class ReshapedRegion:
    """Another V, whose region reaches farther than that of the V that decided.

    Attributes:
        formula: V, in the displacement under the states' names.
        region: every start with V below its level in the cube reaches the point.
        hypotheses: of theorem ``lyapunov``, whose evidence the region holds.
    """

    formula: PiecewiseExpression
    region: SublevelRegion
    hypotheses: dict[str, Any]
