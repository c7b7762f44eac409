"""Denominators of a system in many states are proved positive on the checked cube before anything is decided there."""

from __future__ import annotations

from flint import fmpq

from nonsmooth.proofs.checker.polynomials import unit
from nonsmooth.proofs.kernel.cells import BeyondReachError, patterns, rational, rational_terms, scaled
from nonsmooth.proofs.sums_of_squares.ansatz import Condition
from nonsmooth.proofs.sums_of_squares.prove import prove_positive
from nonsmooth.symbolic.piecewise import PiecewiseExpression
from nonsmooth.symbolic.scene_error import SceneError
from nonsmooth.symbolic.switched_system import SwitchedSystem, signs_by_factors


def require_denominators(system: SwitchedSystem) -> None:
    """Refuse denominators that are not proved positive on the checked cube.

    Raises:
        SceneError: for such a denominator.
    """
    for formula in system.denominators:
        if not _is_positive(system, formula):
            expected = "a denominator that is proved not to vanish on the checked cube (a smaller check.radius?)"
            raise SceneError(system.origin, "system.rhs", expected, formula.text)


def _is_positive(system: SwitchedSystem, formula: PiecewiseExpression) -> bool:
    states, count = system.displaced(system.states), len(system.states)
    asked = SwitchedSystem(system.name, system.field, system.states, (formula,), system.check, system.source)
    surfaces = tuple(s for s in asked.surfaces(states) if s.degree)
    bounds = tuple({unit(count, k): fmpq(1)} for k in range(count))
    try:
        rho = rational(system.check.radius)
        for signs in patterns(surfaces, system.check.radius):
            (piece,) = asked.velocity(signs_by_factors(dict(zip(surfaces, signs, strict=True))), states)
            guards = tuple(scaled(rational_terms(s * e), rho) for s, e in zip(surfaces, signs, strict=True))
            condition = Condition(scaled(rational_terms(piece), rho), {}, guards, bounds, count, at_origin=True)
            if prove_positive(condition) is None:
                return False
    except BeyondReachError:
        return False
    return True
