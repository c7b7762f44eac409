"""Plain systems that behave like a given one: *scaled* by s, ``x' = s f(x/s)``, or *sped up* by k, ``x' = k f(x)``.

All changes are exact, and the verdict is the same.
"""

from __future__ import annotations

import re
from dataclasses import replace
from fractions import Fraction

from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression, parse_piecewise
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem, require_single


def scaled_system(
    system: SwitchedSystem, length: Fraction = Fraction(1), speed: Fraction = Fraction(1)
) -> SwitchedSystem:
    """``x' = k s f(x/s)`` for a length s and a speed k.

    Raises:
        SceneError: for arbitrary switching.
    """
    require_single(system)
    shrunk = {name: f"({name}/({length}))" for name in system.states}
    rhs = tuple(_parsed(f"({speed})*({length})*({_renamed(f, shrunk)})", system.states) for f in system.rhs)
    check = replace(
        system.check,
        equilibrium=tuple(x * length for x in system.check.equilibrium),
        radius=system.check.radius * length,
        lyapunov=_parsed(_renamed(system.check.lyapunov, shrunk), system.states),
        quotient=None,
    )
    return replace(system, rhs=rhs, check=check)


def with_rate_ratio(system: SwitchedSystem, ratio: Fraction) -> SwitchedSystem:
    """The first rate as it is, the others times r.

    Raises:
        SceneError: for arbitrary switching.
    """
    require_single(system)
    first, *others = system.rhs
    rhs = (first, *(_parsed(f"({ratio})*({other.text})", system.states) for other in others))
    return replace(system, rhs=rhs)


def _renamed(formula: PiecewiseExpression, names: dict[str, str]) -> str:
    pattern = re.compile(rf"\b({'|'.join(map(re.escape, names))})\b")
    return pattern.sub(lambda found: names[found[0]], formula.text)


def _parsed(text: str, states: tuple[str, ...]) -> PiecewiseExpression:
    return parse_piecewise(text, states)
