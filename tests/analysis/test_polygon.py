"""Convex polygons and their clipping: one test body over floats, fractions and exact field numbers."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np
import pytest
from scipy.spatial import ConvexHull, HalfspaceIntersection

from nonsmooth.analysis.cells.polygon import HalfPlane, Polygon, intersection, square
from nonsmooth.symbolic.numbers.lazy import Lazy
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.plane import hull_holds_zero
from nonsmooth.symbolic.numbers.rounded import rounded

Embed: TypeAlias = Callable[[Fraction | int], Any]

FIELD = NumberField()
ROOT = FIELD.sqrt(2)
KINDS: dict[str, Embed] = {
    "float": float,
    "fraction": Fraction,
    "rational element": FIELD.rational,
    "irrational element": lambda q: FIELD.rational(q) * (1 + ROOT),  # a scaled copy of the same picture
    "lazy": lambda q: Lazy.of(FIELD.rational(q)),
}
SEEDS = range(12)

# Coordinates are below 4 and a dozen clips are made: rounding stays below 1e-13 unless lines are nearly parallel,
# which the coarse normals (integers up to 9) exclude.
ROUNDING = 1e-11


@pytest.fixture(params=KINDS)
def number(request: pytest.FixtureRequest) -> Embed:
    return KINDS[request.param]


def cuts(seed: int, count: int = 6) -> list[tuple[tuple[int, int], Fraction]]:
    """Random half-planes (normal, offset) that leave a neighbourhood of the origin."""
    rng = np.random.default_rng(seed)
    found = []
    for _ in range(count):
        a, b = rng.integers(-9, 10, 2).tolist()
        found.append(((a or 1, b), Fraction(int(rng.integers(1, 60)), 7)))
    return found


def half_plane(number: Embed, normal: tuple[int, int], offset: Fraction | int) -> HalfPlane:
    """Normals are pure numbers, offsets lengths: only these are scaled by an irrational unit."""
    one = number(1) / number(1)
    return HalfPlane((one * normal[0], one * normal[1]), number(offset))


def clipped_square(number: Embed, seed: int) -> Polygon:
    polygon: Polygon | None = square((number(0), number(0)), number(1))
    for normal, offset in cuts(seed):
        assert polygon is not None
        polygon = polygon.clipped(half_plane(number, normal, offset / 5))
    assert polygon is not None
    return polygon


def same(a: Any, b: Any) -> bool:
    """Equal: exactly for exact numbers, to rounding for floats."""
    return abs(a - b) < ROUNDING if isinstance(a, float) else bool(a == b)


@pytest.mark.parametrize("scale", [Fraction(1, 10**310), Fraction(1, 10**150), 1, 10**150, 10**310])
@pytest.mark.parametrize("beyond", [Fraction(0), Fraction(1, 3), Fraction(1, 10**9), Fraction(1, 10**40)])
def test_floats_never_decide_a_side_wrongly(scale: Fraction | int, beyond: Fraction) -> None:
    for embed in (FIELD.rational, KINDS["irrational element"], KINDS["lazy"]):
        line = HalfPlane((embed(3 * scale), embed(-7 * scale)), embed(-scale) * 1)
        x, y = Fraction(2), Fraction(1)  # on it
        for away in (beyond, -beyond):
            assert line.side((embed(x), embed(y) + away)) == line.slack((embed(x), embed(y) + away)).sign()


def test_what_rounding_decides_is_counted() -> None:
    near = rounded(FIELD.one, Fraction(1, 1000))
    before = FIELD.rounded_signs
    assert HalfPlane((FIELD.one, FIELD.zero), near).side((FIELD.one, FIELD.zero)) == 0
    assert FIELD.rounded_signs == before + 1


@pytest.mark.parametrize("seed", SEEDS)
def test_a_line_splits_the_area_without_loss(number: Embed, seed: int) -> None:
    polygon = clipped_square(number, seed)
    for normal, offset in cuts(seed + 1000):
        cut = half_plane(number, normal, offset / 20 - 1)
        parts = [part for part in (polygon.clipped(cut), polygon.clipped(cut.opposite())) if part is not None]
        total = parts[0].area if len(parts) == 1 else parts[0].area + parts[1].area
        assert same(total, polygon.area)
        assert all(sign(part.area) > 0 for part in parts)


@pytest.mark.parametrize("seed", SEEDS)
def test_vertices_are_where_neighbouring_sides_meet(number: Embed, seed: int) -> None:
    polygon = clipped_square(number, seed)
    zero = number(0)
    for k, vertex in enumerate(polygon.vertices):
        for m, side in enumerate(polygon.sides):
            slack = side.slack(vertex)
            if m in (k, (k - 1) % len(polygon.sides)):
                assert same(slack, zero)
            else:
                assert sign(slack) > 0


@pytest.mark.parametrize("seed", SEEDS)
def test_vertices_turn_left_everywhere(number: Embed, seed: int) -> None:
    vertices = clipped_square(number, seed).vertices
    for (ax, ay), (bx, by), (cx, cy) in zip(
        vertices, vertices[1:] + vertices[:1], vertices[2:] + vertices[:2], strict=True
    ):
        assert sign((bx - ax) * (cy - by) - (by - ay) * (cx - bx)) > 0


@pytest.mark.parametrize("seed", SEEDS)
def test_a_point_belongs_iff_it_satisfies_every_inequality(number: Embed, seed: int) -> None:
    polygon = clipped_square(number, seed)
    planes = [half_plane(number, normal, offset / 5) for normal, offset in cuts(seed)]
    rng = np.random.default_rng(seed)
    for x, y in rng.integers(-55, 56, (60, 2)).tolist():
        point = number(Fraction(x, 50)), number(Fraction(y, 50))
        in_square = abs(x) <= 50 and abs(y) <= 50
        assert polygon.contains(point) == (in_square and all(sign(p.slack(point)) >= 0 for p in planes))


@pytest.mark.parametrize("seed", SEEDS)
def test_clips_agree_with_qhull(seed: int) -> None:
    polygon = clipped_square(Fraction, seed)
    rows: list[list[float]] = [[1, 0, -1], [-1, 0, -1], [0, 1, -1], [0, -1, -1]]
    rows += [[a, b, -float(offset) / 5] for (a, b), offset in cuts(seed)]
    corners = HalfspaceIntersection(np.array(rows), np.zeros(2)).intersections
    hull = ConvexHull(corners)
    assert float(polygon.area) == pytest.approx(hull.volume, abs=ROUNDING)  # the "volume" of a plane hull is its area
    vertices = np.array([[float(x), float(y)] for x, y in polygon.vertices])
    distances = np.linalg.norm(vertices[:, None] - corners[None], axis=2)
    assert distances.min(axis=0).max() < ROUNDING
    assert distances.min(axis=1).max() < ROUNDING


@pytest.mark.parametrize("seed", SEEDS)
def test_the_order_of_clips_does_not_matter(number: Embed, seed: int) -> None:
    polygon = clipped_square(number, seed)
    backwards: Polygon | None = square((number(0), number(0)), number(1))
    for normal, offset in reversed(cuts(seed)):
        assert backwards is not None
        backwards = backwards.clipped(half_plane(number, normal, offset / 5))
    assert backwards is not None
    assert same(backwards.area, polygon.area)
    assert len(backwards.vertices) == len(polygon.vertices)
    for x, y in polygon.vertices:
        assert sum(same(x, u) and same(y, v) for u, v in backwards.vertices) == 1


@pytest.mark.parametrize(
    ("normal", "offset"),
    [((1, 0), 1), ((1, 0), 2), ((1, 1), 2), ((1, 1), 5)],
    ids=["along a side", "beside", "through a corner", "beyond a corner"],
)
def test_a_line_that_cuts_nothing_changes_nothing(number: Embed, normal: tuple[int, int], offset: int) -> None:
    polygon = square((number(0), number(0)), number(1))
    cut = half_plane(number, normal, offset)
    assert polygon.clipped(cut) is polygon
    assert polygon.clipped(cut.opposite()) is None


def test_a_diagonal_through_two_corners_leaves_a_triangle(number: Embed) -> None:
    polygon = square((number(0), number(0)), number(1))
    cut = half_plane(number, (1, -1), 0)
    triangle = polygon.clipped(cut)
    assert triangle is not None
    assert len(triangle.vertices) == 3
    assert triangle.sides.count(cut) == 1
    assert same(2 * triangle.area, polygon.area)


def test_labels_tell_which_line_each_side_lies_on(number: Embed) -> None:
    polygon = square((number(0), number(0)), number(1))
    one = number(1) / number(1)
    cut = polygon.clipped(HalfPlane((one, one), number(1), "1|2"))
    assert cut is not None
    assert sorted(side.label for side in cut.sides) == ["1|2", "domain", "domain", "domain", "domain"]
    assert polygon.sides[0].opposite().label == "domain"


def test_the_square_has_its_centre_and_area(number: Embed) -> None:
    polygon = square((number(3), number(-2)), number(Fraction(1, 2)))
    assert same(polygon.centre[0], number(3))
    assert same(polygon.centre[1], number(-2))
    assert same(polygon.area, number(1) * number(1))
    assert polygon.contains((number(Fraction(7, 2)), number(Fraction(-3, 2))))
    assert not polygon.contains((number(Fraction(18, 5)), number(-2)))


@pytest.mark.parametrize("seed", SEEDS)
def test_the_centre_is_strictly_inside(number: Embed, seed: int) -> None:
    polygon = clipped_square(number, seed)
    assert all(sign(side.slack(polygon.centre)) > 0 for side in polygon.sides)


def test_intersection_lies_on_both_lines(number: Embed) -> None:
    lines = [half_plane(number, normal, offset) for normal, offset in (((2, 3), 5), ((-1, 4), 2), ((7, 1), -3))]
    for first, second in pairwise(lines):
        point = intersection(first, second)
        assert same(first.slack(point), number(0))
        assert same(second.slack(point), number(0))


def test_exact_clipping_survives_a_sliver_that_floats_lose() -> None:
    """The strip between x = 0 and x = 10^-40 has an area; in floats its two sides coincide far from 0."""
    tiny = Fraction(1, 10**40)
    strip: Polygon | None = square((Fraction(1), Fraction(0)), Fraction(1))
    for cut in (HalfPlane((Fraction(1), Fraction(0)), 1 + tiny), HalfPlane((Fraction(-1), Fraction(0)), Fraction(-1))):
        assert strip is not None
        strip = strip.clipped(cut)
    assert strip is not None
    assert strip.area == 2 * tiny


def test_a_hull_holds_zero_unless_an_open_half_plane_holds_all() -> None:
    """Against the definition: some vector has all others strictly to its right, or along it."""
    rng = np.random.default_rng(3)
    seen = {True: 0, False: 0}
    for _ in range(2_000):
        vectors = [(int(x), int(y)) for x, y in rng.integers(-2, 3, (int(rng.integers(1, 7)), 2))]
        beside = any(
            all((v[0] * w[1] - v[1] * w[0], -v[0] * w[0] - v[1] * w[1]) < (0, 0) for w in vectors) for v in vectors
        )
        assert hull_holds_zero(vectors) is not beside
        seen[beside] += 1
    assert min(seen.values()) > 200
