"""Denominators of a plain system are proved positive on the checked square before anything is decided there."""

from __future__ import annotations

from nonsmooth.analysis.cells.switched_cells import TooManyCells, smooth_pieces, square_regions
from nonsmooth.proofs.inequalities.prover import Proof, Sense, prove
from nonsmooth.symbolic.expression import ExpressionError
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.piecewise import PiecewiseExpression, SignOf
from nonsmooth.symbolic.scene_error import SceneError
from nonsmooth.symbolic.switched_system import PLANE, SwitchedSystem, require_plane


def require_denominators(system: SwitchedSystem) -> None:
    """Refuse denominators that are not proved positive on the checked square.

    Raises:
        SceneError: for such a denominator.
    """
    if not system.denominators:
        return
    require_plane(system)
    for formula in system.denominators:
        if not _is_positive(system, formula):
            expected = "a denominator that is proved not to vanish on the checked square (a smaller check.radius?)"
            raise SceneError(system.origin, "system.rhs", expected, formula.text)


def _is_positive(system: SwitchedSystem, formula: PiecewiseExpression) -> bool:
    values = dict(zip(system.states, system.displaced(PLANE), strict=True))

    def evaluate(sign_of: SignOf) -> Polynomial:
        return formula.polynomial(values, sign_of)

    try:
        pieces = list(smooth_pieces(square_regions(system.check.radius), evaluate))
    except (TooManyCells, ExpressionError):
        return False
    return all(isinstance(prove(Sense.POSITIVE, piece, region), Proof) for region, piece in pieces)
