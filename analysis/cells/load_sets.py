"""The loads that a scene leaves open, at its checked point: a polytope, exactly.

All are centred, c = 0, with total weight 1 and ``m_i = (1, p_i)``.

*Admissible* loads, ``N >= 0, sum N_i = 1, sum N_i p_i = 0``: the hull of its vertices, of which each is carried by a
triangle of wheels around the point, by two wheels on both sides of it, or by a wheel right under it.

*Springs that are not quite equal.*  In contact ``N_i = k_i (m_i . y - h_i) = k m_i . y + e_i``, where with
``k_i = k (1 + t_i)`` ::

    e_i = N_i t_i/(1 + t_i) - k h_i,     |e_i| <= top_i s/(1 - s) + height/n     for |t_i| <= s, N_i <= top_i.

Sum and moments determine y, so ``N = N_elastic + Q e`` with ``Q = I - M G^-1 M^T``: a zonotope over a box of e.  It
bounds what springs reach as long as no wheel lifts off.  A wheel off the ground has ``m_i . y < h_i``, as if its height
were beyond the box: so loads after lift-off need not lie in the zonotope cut at ``N >= 0`` (where equal springs lift a
wheel already and scatter little, that cut is empty).  Where the zonotope lies in ``N > 0`` no wheel lifts: grow the
scatter from nothing; the solution of the springs moves continuously, and while it is positive it lies in the zonotope,
so it stays positive.  Elsewhere a wheel may lift, and all admissible loads are taken instead.

What holds for every load of such a *bound* holds for all that springs reach.  A witness must be *reached*: it is taken
from the zonotope over ``|e_i| <= least_i s/(1 + s) + height/n``, which every scatter attains where no wheel lifts, with
both parts scaled down until none does.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from math import comb
from typing import NamedTuple, TypeAlias

from nonsmooth.analysis.cells.loads import LoadError, elastic_loads_at, require_support
from nonsmooth.analysis.cells.polygon import checked_square
from nonsmooth.symbolic.mechanics.contact_states import Triple, inner
from nonsmooth.symbolic.mechanics.load_model import LoadScatter, UnknownLoads
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.mechanics.springs import spring_forms
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.plane import Vector, cross, dot

Loads: TypeAlias = tuple[Number, ...]  # of all wheels, in the order of the scene

MOST_TRIANGLES = 20_000  # of wheels that are tried for vertices: 50 wheels, some seconds
REFINEMENTS = 2  # of the bounds ``top_i``, which are 1 at first
LIFTS = "springs that differ so much may lift a wheel off, so all admissible loads are taken"


class LoadPolytope(ABC):
    """A polytope of loads at the checked point."""

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
class AdmissibleLoads(LoadPolytope):
    """Every load that carries the weight and balances moments.

    Attributes:
        vertices: of the polytope.
    """

    vertices: tuple[Loads, ...]

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
class SpringLoads(LoadPolytope):
    """The zonotope ``centre + sum_k [-1, 1] generators_k``.

    Attributes:
        centre: the elastic loads of equal springs.
        generators: columns of Q, each times the half-width of the box of e; none where the centre is all.
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
    def reach(self) -> Loads:
        """How far every load may be from the centre."""
        zero = self.centre[0].field.zero
        return tuple(sum((abs(generator[i]) for generator in self.generators), zero) for i in range(len(self.centre)))

    @cached_property
    def least(self) -> Loads:
        """The centre less all generators."""
        return tuple(n - reach for n, reach in zip(self.centre, self.reach, strict=True))

    @cached_property
    def largest(self) -> Loads:
        """The centre and all generators."""
        return tuple(n + reach for n, reach in zip(self.centre, self.reach, strict=True))

    def lowest(self, prices: Sequence[Number]) -> Loads:
        """Every generator against the prices."""
        total = self.centre
        for generator in self.generators:
            side = -priced(prices, generator).sign()
            total = tuple(n + side * entry for n, entry in zip(total, generator, strict=True))
        return total


class LoadSet(NamedTuple):
    """The loads that a scene leaves open at its point.

    Attributes:
        bound: holds all of them: what holds for every load of it holds for them.
        reached: all of it is among them: where witnesses are taken from.
        remark: what was done about lift-off, a sentence; empty where there is nothing to say.
    """

    bound: LoadPolytope
    reached: LoadPolytope
    remark: str = ""


def load_set(scene: Scene) -> LoadSet:
    """The loads that a centred scene leaves open at its point.

    Raises:
        LoadError: where the square leaves the support polygon, for wheels on one line, and for too many wheels.
        TypeError: for a scene whose loads are known.
    """
    unknown = scene.contact.loads
    if not isinstance(unknown, UnknownLoads):
        raise TypeError(f"required a scene with unknown loads, received {unknown}")
    require_support(scene, checked_square(scene))
    if unknown.scatter is None:
        every = admissible_loads(scene)
        return LoadSet(every, every)
    return _loads_of_springs(scene, unknown.scatter)


def admissible_loads(scene: Scene) -> AdmissibleLoads:
    """The polytope of all loads at the point of a centred scene.

    Raises:
        LoadError: for so many wheels that its vertices are not listed.
    """
    positions = scene.positions
    if comb(len(positions), 3) > MOST_TRIANGLES:
        raise LoadError(f"contact.loads: required at most 50 wheels for unknown loads, received {len(positions)}")
    return AdmissibleLoads(tuple(_vertices(positions)))


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


def _loads_of_springs(scene: Scene, scatter: LoadScatter) -> LoadSet:
    """The zonotopes that bound and that are reached, or all admissible loads where a wheel may lift off."""
    forms = spring_forms(scene.positions)
    centre = tuple(form[0] for form in forms)
    if min(centre).sign() <= 0:  # equal springs lift a wheel off already
        known = elastic_loads_at(scene, scene.check.equilibrium)
        return LoadSet(admissible_loads(scene), SpringLoads(known, ()), LIFTS)
    columns, heights = _projection(scene, forms), scatter.height / len(centre)
    tops = [scene.field.one] * len(centre)
    for _ in range(REFINEMENTS):
        slack = scatter.stiffness / (1 - scatter.stiffness)
        outer = _springs(centre, columns, [top * slack + heights for top in tops])
        tops = [min(top, largest) for top, largest in zip(tops, outer.largest, strict=True)]
    lifts = min(outer.least).sign() <= 0
    share = scatter.stiffness / (1 + scatter.stiffness)
    if not lifts:
        return LoadSet(outer, _springs(centre, columns, [least * share + heights for least in outer.least]))
    grounded = _springs(centre, columns, _reached_widths(centre, columns, share, heights))
    return LoadSet(admissible_loads(scene), grounded, LIFTS)


def _reached_widths(centre: Loads, columns: Sequence[Loads], share: Number, heights: Number) -> Sequence[Number]:
    """Half-widths of a box of e that a scatter attains with at least half of the least elastic load on every wheel."""
    half = min(centre) / 2
    widest = [half * share + heights] * len(centre)
    reach = max(_springs(centre, columns, widest).reach)
    return widest if reach <= half else [width * half / reach for width in widest]


def _springs(centre: Loads, columns: Sequence[Loads], widths: Sequence[Number]) -> SpringLoads:
    """The zonotope over the box of these half-widths."""
    generators = zip(columns, widths, strict=True)
    return SpringLoads(centre, tuple(tuple(entry * width for entry in column) for column, width in generators))


def _projection(scene: Scene, forms: Sequence[Triple]) -> list[Loads]:
    """The columns of Q."""
    one, zero = scene.field.one, scene.field.zero
    moments = [(one, *wheel.position) for wheel in scene.wheels]
    rows = range(len(moments))
    return [tuple((one if i == k else zero) - inner(moments[i], forms[k]) for i in rows) for k in rows]
