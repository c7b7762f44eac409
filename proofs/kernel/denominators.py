"""Denominators of a plain system are proved positive on the checked cube before anything is decided there.

Then the field times them has the same paths, at other speeds.  For what is said of the whole space they must be
positive there.
"""

from __future__ import annotations

from flint import fmpq

from nonsmooth.analysis.cells.switched_cells import TooManyCells, smooth_pieces, square_regions
from nonsmooth.proofs.checker.polynomials import unit
from nonsmooth.proofs.inequalities.forms import Sense
from nonsmooth.proofs.inequalities.prover import Proof, prove
from nonsmooth.proofs.kernel.cells import BeyondReachError, patterns, rational, rational_terms, scaled
from nonsmooth.proofs.sums_of_squares.ansatz import Condition
from nonsmooth.proofs.sums_of_squares.prove import prove_positive
from nonsmooth.symbolic.formulas.expression import ExpressionError
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression, SignOf
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.systems.switched_system import PLANE, SwitchedSystem, signs_by_factors


def require_denominators(system: SwitchedSystem) -> None:
    """Refuse denominators that are not proved positive on the checked cube, in two states a square.

    Raises:
        SceneError: for such a denominator.
    """
    in_plane, radius = len(system.states) == len(PLANE), system.check.radius
    where = "square" if in_plane else "cube"
    for formula in system.denominators:
        if not (_is_positive_on_square(system, formula) if in_plane else _is_positive(system, formula, radius)):
            expected = f"a denominator that is proved not to vanish on the checked {where} (a smaller check.radius?)"
            raise SceneError(system.origin, "system.rhs", expected, formula.text)


def are_positive_everywhere(system: SwitchedSystem) -> bool:
    """Whether the denominators are proved positive in the whole space."""
    return all(_is_positive(system, formula, None) for formula in system.denominators)


def _is_positive_on_square(system: SwitchedSystem, formula: PiecewiseExpression) -> bool:
    values = dict(zip(system.states, system.displaced(PLANE), strict=True))

    def evaluate(sign_of: SignOf) -> Polynomial:
        return formula.polynomial(values, sign_of)

    try:
        pieces = list(smooth_pieces(square_regions(system.check.radius), evaluate))
    except (TooManyCells, ExpressionError):
        return False
    return all(isinstance(prove(Sense.POSITIVE, piece, region), Proof) for region, piece in pieces)


def _is_positive(system: SwitchedSystem, formula: PiecewiseExpression, radius: Number | None) -> bool:
    """On the cube of a half-width, or in the whole space."""
    states, count = system.displaced(system.states), len(system.states)
    asked = SwitchedSystem(system.name, system.field, system.states, (formula,), system.check, system.source)
    surfaces = tuple(s for s in asked.surfaces(states) if s.degree)
    bounds = () if radius is None else tuple({unit(count, k): fmpq(1)} for k in range(count))
    try:
        rho = fmpq(1) if radius is None else rational(radius)
        for signs in patterns(surfaces, radius):
            (piece,) = asked.velocity(signs_by_factors(dict(zip(surfaces, signs, strict=True))), states)
            guards = tuple(scaled(rational_terms(s * e), rho) for s, e in zip(surfaces, signs, strict=True))
            condition = Condition(scaled(rational_terms(piece), rho), {}, guards, bounds, count, at_origin=True)
            if prove_positive(condition) is None:
                return False
    except BeyondReachError:
        return False
    return True
