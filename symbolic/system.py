"""Plain switched systems in the plane: right-hand sides with ``sign`` and ``Abs``, and what is to be checked of them.

``x' = f(x)`` with f polynomial on each cell that the switching surfaces cut; on the surfaces the values of f are
ignored (Filippov 1988, sec. 4).  Inside, the states are the displacements (x, y) from the checked equilibrium.
"""

from __future__ import annotations

from dataclasses import dataclass

from nonsmooth.symbolic.expression import ExpressionError
from nonsmooth.symbolic.files.scene_values import requirement
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.piecewise import PiecewiseExpression, SignOf
from nonsmooth.symbolic.scene import Vector
from nonsmooth.symbolic.scene_error import SceneError

PLANE = ("x", "y")


@dataclass(frozen=True)
class SystemCheck:
    """What is checked: the equilibrium ``c*``, and the square ``|x - x*|, |y - y*| <= radius`` about it.

    ``lyapunov`` is V in the displacement from ``c*``, written with the states' names; ``is_default`` where the scene
    names none, so that it is the sum of their squares.
    """

    equilibrium: Vector
    radius: Number
    lyapunov: PiecewiseExpression
    is_default: bool = False

    @property
    def named_lyapunov(self) -> str | None:
        """The V that the scene names."""
        return None if self.is_default else self.lyapunov.text


@dataclass(frozen=True)
class SystemScene:
    """A switched system with everything a check needs; numbers live in one field.

    Attributes:
        name: of the scene.
        field: the number field.
        states: the two names.
        rhs: the two right-hand sides.
        check: what is checked.
        source: where it came from (a file or a built-in name).
    """

    name: str
    field: NumberField
    states: tuple[str, str]
    rhs: tuple[PiecewiseExpression, PiecewiseExpression]
    check: SystemCheck
    source: str = ""

    @property
    def origin(self) -> str:
        """Where the scene came from, for messages: its file or built-in name, else its own name."""
        return self.source or self.name

    def velocity(self, sign_of: SignOf) -> tuple[Polynomial, Polynomial]:
        """The smooth field for the given signs of the inner expressions, in the displacement (x, y).

        Raises:
            SceneError: where a piece is no polynomial.
        """
        plane = self._plane()
        values = {name: v + c for name, v, c in zip(self.states, plane, self.check.equilibrium, strict=True)}
        pieces: list[Polynomial] = []
        for k, formula in enumerate(self.rhs, 1):
            try:
                pieces.append(formula.polynomial(values, sign_of))
            except ExpressionError as error:
                expected = requirement(error)
                raise SceneError(self.origin, f"system.rhs[{k}]", expected, formula.text) from None
        return pieces[0], pieces[1]

    def potential(self, lyapunov: PiecewiseExpression, sign_of: SignOf) -> Polynomial:
        """A smooth piece of V in the displacement (x, y).

        Raises:
            ExpressionError: where it is no polynomial.
        """
        return lyapunov.polynomial(dict(zip(self.states, self._plane(), strict=True)), sign_of)

    def _plane(self) -> tuple[Polynomial, Polynomial]:
        x, y = (Polynomial.variable(self.field, PLANE, name) for name in PLANE)
        return x, y
