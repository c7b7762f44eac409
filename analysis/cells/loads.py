"""Normal forces, exactly: affine in the centre of mass on polygons of the plane.

Elastic loads (identical springs under a rigid plate, no tension) solve ``min |N|^2`` subject to
``sum N_i = 1, sum N_i p_i = c, N >= 0`` (total weight 1).  With ``m_i = (1, p_i)`` the optimality conditions are
``N_i = max(0, m_i . y)``, so for a set A of loaded wheels ``N_i = m_i^T G_A^-1 (1, c)``, ``G_A = sum_A m_i m_i^T``:
affine in c.  The plane inside the support polygon splits into convex regions by A; crossing a side of a region
mostly changes A by one wheel, which is how the regions are found.  Where wheels on one line carry the whole load on a
side, the body tilts about it and others change at once: floats propose the set beyond, and the exact conditions of its
region dispose.  Outside the support polygon the body tips, and for
collinear wheels the loads are undetermined: both are refused.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, partial
from itertools import product
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from flint import fmpq, fmpz

from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.cells.polygon import HalfPlane, Point, Polygon, checked_square
from nonsmooth.analysis.loads.spring_loads import loaded_wheels
from nonsmooth.symbolic.mechanics.body import square_rooms, support_polygon
from nonsmooth.symbolic.mechanics.contact_states import Triple
from nonsmooth.symbolic.mechanics.load_model import LoadModel, UnknownLoads, carried_loads
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.mechanics.springs import EXACT, EqualSprings, exact_moments, load_model
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.number_text import float_text, short_text
from nonsmooth.symbolic.numbers.plane import Vector, around, cross, minus, side_of
from nonsmooth.symbolic.numbers.plane_arrays import places_of

Affine: TypeAlias = tuple[Any, Any, Any]  # constant and coefficients of x and y

UNKNOWN = (
    'contact.loads: required loads that are known ("elastic", a table, or measured) to follow the motion, received {}'
)


ALL_AT_ONCE = (
    "check.radius: required a smaller square, received one crossed by a line of wheels that carries the whole "
    "load: beside it the loaded wheels change all at once, and what they change to is not found"
)
STEPS_BESIDE = (2.0**-6, 2.0**-10, 2.0**-14)  # of a side, or of the square: how far beside it floats look for loads
WAYS = ((1.0, 0.6), (-0.6, 1.0), (-1.0, -0.6), (0.6, -1.0))  # along no usual symmetry axis
MOST_BITS = 20_000_000  # of the common denominator of all positions, times their number: some seconds


class LoadError(RefusalError):
    """Normal forces that do not exist in the checked square; the message names the place."""


class TipsThereError(LoadError):
    """A centre of mass outside the support polygon of all wheels."""


class CollinearLoadError(LoadError):
    """A line of wheels that carries the whole load, where beside it no loads are found."""


class LoadRegion(NamedTuple):
    """A polygon on which every load is affine: ``N_i(c) = forces[i] . (1, c)``, zero for idle wheels.

    Attributes:
        polygon: part of the checked square.
        forces: one affine form per wheel, total weight 1.
        loaded: numbers of the wheels that carry load.
    """

    polygon: Polygon
    forces: tuple[Affine, ...]
    loaded: frozenset[int]


def value_at(form: Affine, point: Point) -> Any:
    """``a + b x + c y``."""
    return form[0] + form[1] * point[0] + form[2] * point[1]


def at_least_zero(form: Affine, label: str) -> HalfPlane:
    """The half-plane on which an affine form is non-negative."""
    return HalfPlane((-form[1], -form[2]), form[0], label)


def load_regions(scene: Scene, holding: Point | None = None, domain: Polygon | None = None) -> tuple[LoadRegion, ...]:
    """Split the checked square, or another domain, by the affine pieces of the loads.

    With a point, only the regions that hold it are sought: a hundred wheels have hundreds of regions.

    Raises:
        LoadError: where the body tips, wheels are collinear, a table gives a negative load, or loads are unknown.
    """
    domain = checked_square(scene) if domain is None else domain
    if isinstance(scene.contact.loads, UnknownLoads):
        raise LoadError(UNKNOWN.format(scene.contact.loads.words))
    model = load_model(scene)
    if not model.lifts_off:
        forms = tuple(model.forms(exact_moments(scene), range(len(scene.wheels)), EXACT) or ())
        _require_positive(scene, forms, domain)
        return (LoadRegion(domain, forms, frozenset(scene.numbers)),)
    regions = _Regions(scene, domain)
    everywhere = regions.of(regions.every)
    if everywhere is not None and everywhere.polygon is domain:  # no load is negative at its corners: it is supported
        return (everywhere,)
    require_support(scene, domain)
    return _elastic_regions(regions, holding)


def elastic_loads_at(scene: Scene, point: Point) -> tuple[Any, ...]:
    """Elastic loads at one centre of mass, exactly; total weight 1.

    Raises:
        LoadError: where the point lies outside the support polygon or on its border, or the wheels are collinear.
    """
    hull = support_polygon(scene.positions)
    if len(hull) < 3 or side_of(hull, point) <= 0:
        x, y = (float(value) for value in point)
        raise LoadError(f"required a centre of mass inside the support polygon, received ({x:g}, {y:g})")
    moments = exact_moments(scene)
    active, forces = _loads_at(EqualSprings(), moments, point)
    return tuple(force if i in active else scene.field.zero for i, force in enumerate(forces))


def _require_positive(scene: Scene, rows: Sequence[Affine], domain: Polygon) -> None:
    for wheel, form in zip(scene.wheels, rows, strict=True):
        for x, y in domain.vertices:
            if value_at(form, (x, y)).sign() < 0:
                raise LoadError(
                    "contact.loads: required loads >= 0 in the square, received a negative load "
                    f"of wheel {wheel.index} at ({x}, {y})"
                )


def require_support(scene: Scene, domain: Polygon) -> None:
    """Refuse squares that leave the support polygon.

    Raises:
        LoadError: naming the place, or that the wheels are collinear.
    """
    hull = support_polygon(scene.positions)
    if len(hull) < 3:
        raise LoadError(
            "contact.loads: required three wheels that are not collinear, "
            f"received {len(scene.wheels)} wheels on one line: elastic loads are undetermined"
        )
    for corner, following in around(hull):
        along = minus(following, corner)
        for vertex in domain.vertices:
            if cross(along, minus(vertex, corner)).sign() < 0:
                raise LoadError(_tipping_message(scene, hull, vertex))


def _tipping_message(scene: Scene, hull: Sequence[Vector], vertex: Point) -> str:
    """Name the support polygon, the point that leaves it and the largest radius that stays inside.

    Places are measured from the checked point, since the scene may have been moved there.
    """
    largest, at = min(square_rooms(hull, scene.check.equilibrium)), scene.check.equilibrium
    seen, *corners = (f"({float(x):g}, {float(y):g})" for x, y in (minus(place, at) for place in (vertex, *hull[:8])))
    polygon = f"{', '.join(corners)}{', ...' if len(hull) > 8 else ''}, measured from the checked point"
    if largest.sign() <= 0:
        return f"check.equilibrium: required a point inside the support polygon, received one that is not: {polygon}"
    exact, rounded = short_text(largest), float_text(largest)
    said = exact if exact.removeprefix("~") == rounded else f"{exact} ~ {rounded}"
    return (
        f"check.radius: required at most {said}, received {short_text(scene.check.radius)}: "
        f"at {seen} the body tips over its support polygon {polygon}"
    )


class _Regions:
    """The load regions of a square by their sets of loaded wheels, each built once; None for sets without area.

    Raises:
        LoadError: for too many wheels with too long coordinates.
    """

    def __init__(self, scene: Scene, domain: Polygon) -> None:
        self.scene, self.domain = scene, domain
        self.model, self.moments = load_model(scene), exact_moments(scene)
        _require_short(self.moments)
        self.every = frozenset(range(len(self.moments)))
        self.positions = places_of(scene.wheels)
        self.forms = cache(partial(self.model.forms, self.moments, arithmetic=EXACT))
        self._known: dict[frozenset[int], LoadRegion | None] = {}

    def of(self, active: frozenset[int] | None) -> LoadRegion | None:
        """The region of a set; None where it has no area in the square, or the wheels are on one line."""
        if active is None:
            return None
        if active not in self._known:
            self._known[active] = self._region(active)
        return self._known[active]

    def _region(self, active: frozenset[int]) -> LoadRegion | None:
        """The polygon on which exactly these wheels carry load; None where it has no area, or no loads are fixed."""
        forms = self.forms(active)
        if forms is None:
            return None
        zero, polygon = self.scene.field.zero, self.domain
        for i, form in enumerate(forms):
            bound = form if i in active else (-form[0], -form[1], -form[2])
            clipped = polygon.clipped(at_least_zero(bound, f"load {i}"))
            if clipped is None:
                return None
            polygon = clipped
        forces = tuple(form if i in active else (zero, zero, zero) for i, form in enumerate(forms))
        return LoadRegion(polygon, forces, frozenset(self.scene.wheels[i].index for i in active))

    def first(self, start: Point) -> frozenset[int]:
        """The loaded wheels of a region at a point, most often all."""
        forms = self.forms(self.every)
        if forms is not None and all(sign(value_at(form, start)) >= 0 for form in forms):
            return self.every
        try:
            return _loads_at(self.model, self.moments, start)[0]
        except CollinearLoadError:
            centre, reach = np.array(start, float), self.scene.check.half_width
            for step, way in product(STEPS_BESIDE, WAYS):
                active = loaded_wheels(self.positions, centre + step * reach * np.array(way))
                region = self.of(active)
                if active is not None and region is not None and region.polygon.contains(start):
                    return active
            raise

    def beyond(self, active: frozenset[int], polygon: Polygon, k: int) -> tuple[frozenset[int] | None, bool]:
        """The loaded wheels beyond side k of a region, and whether that is one wheel more or less, as it mostly is.

        Where several change at once, floats propose the set just beyond the middle of the side; None without a region.
        """
        wheel = int(polygon.sides[k].label.split()[1])
        if self.of(active ^ {wheel}) is not None:
            return active ^ {wheel}, True
        start, end = (np.array(polygon.vertices[n % len(polygon.vertices)], float) for n in (k, k + 1))
        along = end - start
        outward = np.array([along[1], -along[0]])
        for step in STEPS_BESIDE:
            proposed = loaded_wheels(self.positions, (start + end) / 2 + step * outward)
            if proposed != active and self.of(proposed) is not None:
                return proposed, False
        return None, False


def _elastic_regions(regions: _Regions, holding: Point | None) -> tuple[LoadRegion, ...]:
    """Walk from the region where the search starts to its neighbours until the square (or the point) is covered.

    Where floats proposed a neighbour the areas of all regions must add up.

    Raises:
        CollinearLoadError: where they do not.
    """
    domain = regions.domain
    found: dict[frozenset[int], LoadRegion] = {}
    waiting, is_whole = [regions.first(domain.centre if holding is None else holding)], True
    while waiting:
        active = waiting.pop()
        region = regions.of(active)
        if active in found or region is None:
            continue
        found[active] = region
        for k in _crossings(region.polygon, holding):
            neighbour, is_plain = regions.beyond(active, region.polygon, k)
            is_whole = is_whole and is_plain
            waiting += [] if neighbour is None else [neighbour]
    if is_whole:
        return tuple(found.values())
    if holding is not None:
        every = _elastic_regions(regions, None)
        return tuple(region for region in every if region.polygon.contains(holding))
    if sum((region.polygon.area for region in found.values()), regions.scene.field.zero) != domain.area:
        raise CollinearLoadError(ALL_AT_ONCE)
    return tuple(found.values())


def _crossings(polygon: Polygon, holding: Point | None) -> list[int]:
    """The sides of a region at which loads change their form (those that hold a point)."""
    sides = enumerate(polygon.sides)
    inner_sides = ((k, side) for k, side in sides if side.label.startswith("load"))
    return [k for k, side in inner_sides if holding is None or not sign(side.slack(holding))]


def _loads_at(model: LoadModel, moments: Sequence[Triple], point: Point) -> tuple[frozenset[int], list[Any]]:
    """Loaded wheels at a point, and the affine loads there of all wheels.

    Raises:
        LoadError: for too many wheels with too long coordinates.
        CollinearLoadError: where wheels on one line carry.
    """
    _require_short(moments)
    found = carried_loads(model, moments, frozenset(range(len(moments))), point, EXACT)
    if found is None:
        raise CollinearLoadError(ALL_AT_ONCE)
    return found


def _require_short(moments: Sequence[Triple]) -> None:
    """Refuse coordinates whose sums over all wheels are too long.

    Raises:
        LoadError: naming the length of their common denominator.
    """
    common, most = fmpz(1), MOST_BITS // len(moments)
    for moment in moments:
        for number in moment:
            for c in number.terms.values():
                common = common.lcm(c.q if isinstance(c, fmpq) else c.denom())
        if common.height_bits() > most:
            raise LoadError(
                f"wheels: required positions of {len(moments)} wheels with a common denominator of at most {most} bits "
                "for elastic loads, received a longer one"
            )
