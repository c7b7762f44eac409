"""Switched equations ``x' = f(x)`` in any number of states, as they are needed to follow a solution.

The right-hand sides are polynomials that switch where inner expressions of ``sign`` and ``Abs`` change sign.  What a
check decides is planar (:mod:`nonsmooth.symbolic.system`); a solution can be followed in any dimension.

The switching surfaces are found by asking every right-hand side with every answer of the signs it asks for.  Answers
are not tested for being possible together, so a surface may be listed that switches nothing: harmless, since the field
is the same on both sides.  It fails for very many surfaces in one formula (:data:`MAX_PATTERNS`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from nonsmooth.symbolic.expression import ExpressionError
from nonsmooth.symbolic.files.scene_values import requirement
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.piecewise import PiecewiseExpression
from nonsmooth.symbolic.scene_error import Fact, SceneError
from nonsmooth.symbolic.surfaces import switching_factors

MAX_PATTERNS = 4_096  # sign patterns of one right-hand side: twelve surfaces that cross

Signs = Mapping[Polynomial, int]


class UnknownSign(Exception):
    """A surface whose sign is asked for and not given."""

    def __init__(self, surface: Polynomial) -> None:
        super().__init__(surface)
        self.surface = surface


@dataclass(frozen=True)
class SwitchedEquations:
    """Right-hand sides in named states; numbers live in one field.

    Attributes:
        name: of the scene.
        field: the number field.
        states: their names.
        rhs: one formula per state.
        radius: half-width of the square that a check looks at: the typical size of the states.
        source: where it came from (a file or a built-in name).
    """

    name: str
    field: NumberField
    states: tuple[str, ...]
    rhs: tuple[PiecewiseExpression, ...]
    radius: Number
    source: str = ""

    @property
    def origin(self) -> str:
        """What messages call it: its file, else its name."""
        return self.source or self.name

    def velocity(self, signs: Signs) -> tuple[Polynomial, ...]:
        """The smooth field, in the states, for the given signs of the surfaces.

        Raises:
            UnknownSign: for a surface without a sign.
            SceneError: where a piece is no polynomial.
        """
        return tuple(self._piece(k, signs) for k in range(len(self.rhs)))

    def surfaces(self) -> tuple[Polynomial, ...]:
        """Every surface on which some right-hand side may switch, each once, with leading coefficient 1.

        Raises:
            SceneError: for too many patterns, or where no piece is a polynomial.
        """
        found: dict[Polynomial, None] = {}
        for k in range(len(self.rhs)):
            found.update(dict.fromkeys(self._surfaces_of(k)))
        return tuple(found)

    def _surfaces_of(self, k: int) -> list[Polynomial]:
        found: dict[Polynomial, None] = {}
        waiting: list[dict[Polynomial, int]] = [{}]
        ended, refusal = 0, None
        while waiting:
            signs = waiting.pop()
            try:
                self._piece(k, signs)
            except UnknownSign as unknown:
                found[unknown.surface] = None
                waiting += [{**signs, unknown.surface: -1}, {**signs, unknown.surface: 1}]
                if len(waiting) + ended > MAX_PATTERNS:
                    expected = "a formula with fewer switching surfaces"
                    raise self._error(k, expected, Fact(f"over {MAX_PATTERNS} sign patterns")) from None
                continue
            except SceneError as error:  # perhaps of a pattern that no state has
                refusal = error
                continue
            ended += 1
        if not ended and refusal is not None:
            raise refusal
        return list(found)

    def _piece(self, k: int, signs: Signs) -> Polynomial:
        def sign_of(expression: Polynomial) -> int:
            if not expression:
                return 0
            total, factors = switching_factors(expression)
            for factor in factors:
                if factor not in signs:
                    raise UnknownSign(factor)
                total *= signs[factor]
            return total

        try:
            return self.rhs[k].polynomial(self._variables(), sign_of)
        except ExpressionError as error:
            raise self._error(k, requirement(error), self.rhs[k].text) from None

    def _variables(self) -> dict[str, Polynomial]:
        return {name: Polynomial.variable(self.field, self.states, name) for name in self.states}

    def _error(self, k: int, expected: str, received: object) -> SceneError:
        return SceneError(self.origin, f"system.rhs[{k + 1}]", expected, received)
