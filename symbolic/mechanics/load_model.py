"""Loads that are known, in any arithmetic: affine in the centre of mass while the same wheels carry.

With ``m_i = (1, p_i)`` a model says ``N_i(c) = form_i . (1, c)`` for every wheel i, as long as a set A of wheels
carries.  Equal springs under a rigid plate: ``form_i = G_A^-1 m_i``, ``G_A = sum over A of m_i m_i^T``
(:class:`nonsmooth.symbolic.mechanics.springs.EqualSprings`).  A new model is a class on :class:`LoadModel`; regions of
loads, enclosures, floats and paths follow from its forms.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from typing import Any, Generic, NamedTuple, TypeAlias, TypeVar

from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_text import brief_text

X = TypeVar("X", bound=Any)  # numbers of one arithmetic
Three: TypeAlias = tuple[X, X, X]


class Arithmetic(NamedTuple, Generic[X]):
    """What loads need beside sums and products.

    Attributes:
        number: an exact number in this arithmetic.
        inverse: the columns of the inverse of a symmetric matrix (3, 3), by its rows; None where it may have none.
        sign: of a load: -1, 0 or 1.
    """

    number: Callable[[Any], X]
    inverse: Callable[[Three[X], Three[X], Three[X]], Sequence[Three[X]] | None]
    sign: Callable[[X], int]


class LoadModel(ABC):
    """A law of the loads, total weight 1.  Where wheels lift off, it balances moments: ``sum N_i p_i = c``.

    Attributes:
        lifts_off: whether a wheel whose form is negative carries nothing, and leaves its share to the others; else such
            a centre of mass is refused.
    """

    lifts_off: bool = True

    @property
    @abstractmethod
    def words(self) -> str:
        """What it is, for people."""

    @abstractmethod
    def forms(
        self, moments: Sequence[Three[X]], carrying: Collection[int], arithmetic: Arithmetic[X]
    ) -> list[Three[X]] | None:
        """The forms of all wheels while some carry; None where these do not fix the loads.

        Args:
            moments: ``m_i`` of all wheels.
            carrying: the places of A among them.
            arithmetic: of the moments.
        """

    @abstractmethod
    def on(self, places: Sequence[int]) -> LoadModel | None:
        """The law of the wheels at some places, in this order, where the others carry nothing and touch nothing.

        None where it is not known what these carry without the others; a law that lets wheels lift off knows.
        """

    def moved(self, x: Any, y: Any) -> LoadModel:
        """The law after wheels and centre of mass have moved by (x, y)."""
        return self

    def scaled(self, factor: Any) -> LoadModel:
        """The law after all lengths have grown by a factor."""
        return self


def carried_loads(
    model: LoadModel,
    moments: Sequence[Three[X]],
    carrying: frozenset[int],
    point: Sequence[X],
    arithmetic: Arithmetic[X],
) -> tuple[frozenset[int], list[X]] | None:
    """The wheels that carry at a point, and the values of all forms there; None where no set fixes the loads.

    Wheels in tension are dropped and wheels in reach added until there is neither.

    Args:
        model: which lets wheels lift off.
        moments: of all wheels.
        carrying: where the search begins.
        point: the centre of mass.
        arithmetic: of them.
    """
    seen = set()
    while carrying not in seen:
        seen.add(carrying)
        forms = model.forms(moments, carrying, arithmetic)
        if forms is None:
            return None
        values = [a + b * point[0] + c * point[1] for a, b, c in forms]
        tension = [i for i in carrying if arithmetic.sign(values[i]) < 0]
        contact = [i for i in range(len(moments)) if i not in carrying and arithmetic.sign(values[i]) > 0]
        if not (tension or contact):
            return carrying, values
        if tension:
            carrying = carrying - {min(tension, key=lambda i: values[i])}
        else:
            carrying = carrying | {max(contact, key=lambda i: values[i])}
    return None


# ---- loads that are known only to lie in a set ---------------------------------------------------
#
# *Admissible* at a centre of mass c is every ``N >= 0`` with ``sum N_i = 1`` and ``sum N_i p_i = c`` (total weight 1):
# a polytope.  A *scatter* bounds how far the springs under a rigid body are from equal, which leaves a smaller set: a
# wheel in contact carries ``N_i = k_i (m_i . y - h_i)``, ``m_i = (1, p_i)``, y the pose of the body, with ::
#
#     |h_i| <= height times the mean deflection 1/(n k),      |k_i/k - 1| <= stiffness.
#
# The sets themselves: :mod:`nonsmooth.analysis.cells.load_sets`.


class LoadScatter(NamedTuple):
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
