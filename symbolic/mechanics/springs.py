"""Equal springs under a rigid plate, without tension: the loads of a scene that states no others."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from nonsmooth.symbolic.mechanics.constraints import Triple, cofactors, gram, inner, scaled
from nonsmooth.symbolic.mechanics.load_model import Arithmetic, LoadModel, Three, X
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.mechanics.unknown_loads import UnknownLoads
from nonsmooth.symbolic.numbers.number import Number


@dataclass(frozen=True)
class EqualSprings(LoadModel):
    """``form_i = G_A^-1 m_i``: the least ``sum N_i^2`` that carries the weight and balances moments."""

    @property
    def words(self) -> str:
        """Their name in scene files."""
        return "elastic (identical springs, no tension)"

    def forms(
        self, moments: Sequence[Three[X]], carrying: Collection[int], arithmetic: Arithmetic[X]
    ) -> list[Three[X]] | None:
        """None for wheels on one line."""
        if len(carrying) < 3:
            return None
        columns = arithmetic.inverse(*gram([moments[k] for k in sorted(carrying)]))
        if columns is None:
            return None
        x, y, z = columns
        return [(inner(x, m), inner(y, m), inner(z, m)) for m in moments]

    def on(self, places: Sequence[int]) -> EqualSprings:
        """As all of them."""
        return self


def exact_inverse(a: Triple, b: Triple, c: Triple) -> tuple[Triple, Triple, Triple] | None:
    """The columns of the inverse of the matrix with rows a, b, c, by its cofactors."""
    x, y, z = cofactors(a, b, c)
    determinant = inner(a, x)
    if not determinant:
        return None
    share = determinant.inverse()
    return scaled(x, share), scaled(y, share), scaled(z, share)


EXACT: Arithmetic[Number] = Arithmetic(lambda number: number, exact_inverse, lambda number: number.sign())


def exact_moments(scene: Scene) -> list[Triple]:
    """``(1, p_i)`` of all wheels."""
    return [(scene.field.one, *wheel.position) for wheel in scene.wheels]


def load_model(scene: Scene) -> LoadModel:
    """The loads of the wheels of a scene that carry, which are known.

    Raises:
        TypeError: for loads that the scene leaves open.
        ValueError: where some wheels are idle, and it is not known what the others carry without them.
    """
    loads = scene.contact.loads
    if isinstance(loads, UnknownLoads):
        raise TypeError(f"required loads that are known, received {loads.words}")
    if loads is None:
        return EqualSprings()
    own = loads.on(scene.carrying_places) if scene.idle else loads
    if own is None:
        raise ValueError(f"required loads that are known of some wheels alone, received {loads.words}")
    return own
