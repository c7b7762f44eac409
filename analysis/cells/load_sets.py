"""The loads that a scene leaves open, at its checked point: a polytope, exactly.

All are centred, c = 0, with total weight 1 and ``m_i = (1, p_i)``.

*Admissible* loads, ``N >= 0, sum N_i = 1, sum N_i p_i = 0``: the hull of its vertices, of which each is carried by a
triangle of wheels around the point, by two wheels on both sides of it, or by a wheel right under it.

*Springs that are not quite equal.*  In contact ``N_i = k_i (m_i . y - h_i) = k m_i . y + e_i``, where with
``k_i = k (1 + t_i)`` ::

    e_i = N_i t_i/(1 + t_i) - k h_i,     |e_i| <= E_i = top_i s/(1 - s) + height/n     for |t_i| <= s, N_i <= top_i.

Sum and moments determine y, so ``N = N_elastic + Q e`` with ``Q = I - M G^-1 M^T``: a zonotope over the box of e.  With
equal stiffnesses it is what springs can reach, otherwise an outer bound.  It holds as long as no wheel lifts off.  A
wheel off the ground has ``m_i . y < h_i``, a height beyond the box: so loads after lift-off are *not* the zonotope cut
at ``N >= 0``.  Where the zonotope lies in ``N > 0`` no wheel lifts: grow the scatter from nothing; the solution of the
springs moves continuously, and while it is positive it lies in the zonotope, so it stays positive.  Elsewhere a wheel
may lift, and all admissible loads are taken instead.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from math import comb
from typing import TypeAlias

from nonsmooth.analysis.cells.loads import LoadError, require_support
from nonsmooth.analysis.cells.polygon import square
from nonsmooth.symbolic.constraints import inner
from nonsmooth.symbolic.measured_loads import spring_forms
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.plane import Vector, cross, dot
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.unknown_loads import LoadScatter, UnknownLoads

Loads: TypeAlias = tuple[Number, ...]  # of all wheels, in the order of the scene

MOST_TRIANGLES = 20_000  # of wheels that are tried for vertices: 50 wheels, some seconds
REFINEMENTS = 2  # of the bounds ``top_i``, which are 1 at first
LIFTS = "springs that differ so much may lift a wheel off, so all admissible loads are taken"


class LoadSet(ABC):
    """A polytope of loads at the checked point.

    Attributes:
        remark: what was done about lift-off, a sentence; empty where there is nothing to say.
    """

    remark: str = ""

    @property
    @abstractmethod
    def middle(self) -> Loads:
        """A load of the set under which every wheel carries."""

    @property
    @abstractmethod
    def corners(self) -> tuple[Loads, ...] | None:
        """Finitely many loads whose hull is the set; None where these are too many."""

    @property
    @abstractmethod
    def least(self) -> Loads:
        """The least load of every wheel, each for itself."""

    @property
    @abstractmethod
    def largest(self) -> Loads:
        """The largest load of every wheel, each for itself."""

    @abstractmethod
    def lowest(self, prices: Sequence[Number]) -> Loads:
        """A load of the set with the least ``sum prices_i N_i``."""


def priced(prices: Sequence[Number], loads: Loads) -> Number:
    """``sum prices_i N_i``."""
    return sum((p * n for p, n in zip(prices, loads, strict=True)), loads[0].field.zero)


@dataclass(frozen=True)
class AdmissibleLoads(LoadSet):
    """Every load that carries the weight and balances moments.

    Attributes:
        vertices: of the polytope.
    """

    vertices: tuple[Loads, ...]
    remark: str = ""

    @cached_property
    def middle(self) -> Loads:
        """The mean of the vertices; every wheel carries at one of them."""
        share = self.vertices[0][0].field.one / len(self.vertices)
        return tuple(share * sum(column[1:], column[0]) for column in zip(*self.vertices, strict=True))

    @property
    def corners(self) -> tuple[Loads, ...]:
        """The vertices."""
        return self.vertices

    @cached_property
    def least(self) -> Loads:
        """Over the vertices."""
        return tuple(min(column) for column in zip(*self.vertices, strict=True))

    @cached_property
    def largest(self) -> Loads:
        """Over the vertices."""
        return tuple(max(column) for column in zip(*self.vertices, strict=True))

    def lowest(self, prices: Sequence[Number]) -> Loads:
        """A vertex."""
        return min(self.vertices, key=lambda loads: priced(prices, loads))


@dataclass(frozen=True)
class SpringLoads(LoadSet):
    """The zonotope ``centre + sum_k [-1, 1] generators_k`` in ``N > 0``.

    Attributes:
        centre: the elastic loads of equal springs.
        generators: columns of Q, each times its ``E_k``.
    """

    centre: Loads
    generators: tuple[Loads, ...]

    @property
    def middle(self) -> Loads:
        """The elastic loads."""
        return self.centre

    @property
    def corners(self) -> None:
        """None: there may be 2^n."""
        return None

    @cached_property
    def _reach(self) -> Loads:
        zero = self.centre[0].field.zero
        return tuple(sum(map(abs, entries), zero) for entries in zip(*self.generators, strict=True))

    @cached_property
    def least(self) -> Loads:
        """The centre less all generators."""
        return tuple(n - reach for n, reach in zip(self.centre, self._reach, strict=True))

    @cached_property
    def largest(self) -> Loads:
        """The centre and all generators."""
        return tuple(n + reach for n, reach in zip(self.centre, self._reach, strict=True))

    def lowest(self, prices: Sequence[Number]) -> Loads:
        """Every generator against the prices."""
        signs = [-priced(prices, generator).sign() for generator in self.generators]
        return self._mixed([self.centre[0].field(sign) for sign in signs])

    def _mixed(self, shares: Sequence[Number]) -> Loads:
        rows = zip(self.centre, *self.generators, strict=True)
        return tuple(n + priced(shares, tuple(entries)) for n, *entries in rows)


def load_set(scene: Scene) -> LoadSet:
    """The loads that a centred scene leaves open at its point.

    Raises:
        LoadError: where the square leaves the support polygon, for wheels on one line, and for too many wheels.
        TypeError: for a scene whose loads are known.
    """
    unknown = scene.contact.loads
    if not isinstance(unknown, UnknownLoads):
        raise TypeError(f"required a scene with unknown loads, received {unknown}")
    require_support(scene, square(scene.check.equilibrium, scene.check.radius))
    if unknown.scatter is None:
        return admissible_loads(scene)
    springs = _spring_loads(scene, unknown.scatter)
    return admissible_loads(scene, LIFTS) if springs is None else springs


def admissible_loads(scene: Scene, remark: str = "") -> AdmissibleLoads:
    """The polytope of all loads at the point of a centred scene.

    Raises:
        LoadError: for so many wheels that its vertices are not listed.
    """
    positions = tuple(wheel.position for wheel in scene.wheels)
    if comb(len(positions), 3) > MOST_TRIANGLES:
        raise LoadError(f"contact.loads: required at most 50 wheels for unknown loads, received {len(positions)}")
    return AdmissibleLoads(tuple(_vertices(positions)), remark)


def _vertices(positions: Sequence[Vector]) -> Iterator[Loads]:
    """The loads of one wheel under the point, of two on both sides of it, of triangles around it."""
    one = positions[0][0].field.one
    for k, position in enumerate(positions):
        if not any(position):
            yield _shared(positions, {k: one})
    for i, j in combinations(range(len(positions)), 2):
        p, q = positions[i], positions[j]
        if not cross(p, q) and dot(p, q).sign() < 0:
            axis = 0 if p[0] else 1
            yield _shared(positions, {i: -q[axis] / (p[axis] - q[axis]), j: p[axis] / (p[axis] - q[axis])})
    for i, j, k in combinations(range(len(positions)), 3):
        areas = cross(positions[j], positions[k]), cross(positions[k], positions[i]), cross(positions[i], positions[j])
        if {area.sign() for area in areas} in ({1}, {-1}):
            whole = areas[0] + areas[1] + areas[2]
            yield _shared(positions, {n: area / whole for n, area in zip((i, j, k), areas, strict=True)})


def _shared(positions: Sequence[Vector], shares: dict[int, Number]) -> Loads:
    zero = positions[0][0].field.zero
    return tuple(shares.get(k, zero) for k in range(len(positions)))


def _spring_loads(scene: Scene, scatter: LoadScatter) -> SpringLoads | None:
    """The zonotope of a scatter; None where it reaches loads that are not positive."""
    one, count = scene.field.one, len(scene.wheels)
    moments = [(one, *wheel.position) for wheel in scene.wheels]
    forms = spring_forms([wheel.position for wheel in scene.wheels])
    centre = tuple(form[0] for form in forms)
    columns = [
        tuple((one if i == k else one * 0) - inner(moments[i], forms[k]) for i in range(count)) for k in range(count)
    ]
    heights, slack = scatter.height / count, scatter.stiffness / (1 - scatter.stiffness)
    tops = [one] * count
    for _ in range(REFINEMENTS):
        reaches = [top * slack + heights for top in tops]
        springs = SpringLoads(centre, tuple(_times(columns[k], reaches[k]) for k in range(count)))
        tops = [min(top, largest) for top, largest in zip(tops, springs.largest, strict=True)]
    return springs if all(n.sign() > 0 for n in springs.least) else None


def _times(column: Loads, factor: Number) -> Loads:
    return tuple(entry * factor for entry in column)
