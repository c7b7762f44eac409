"""Rule ``box``, and the convex polygons that its cells are."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from itertools import combinations, pairwise, product
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import pytest
from flint import arb
from scipy.optimize import linprog
from scipy.spatial import ConvexHull, HalfspaceIntersection

from nonsmooth.analysis.cells import arrangement as arrangement_module
from nonsmooth.analysis.cells import cell_complex
from nonsmooth.analysis.cells import outline as outline_module
from nonsmooth.analysis.cells.arrangement import Arrangement, SlopeOfD
from nonsmooth.analysis.cells.box import build_box_partition, rest_cells
from nonsmooth.analysis.cells.loads import Affine, load_regions, value_at
from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.cells.outline import Form
from nonsmooth.analysis.cells.partition import AREA_ROOTS, Cell, Partition, RefusalError
from nonsmooth.analysis.cells.polygon import HalfPlane, Point, Polygon, intersection, square
from nonsmooth.analysis.cells.slopes import Slopes
from nonsmooth.analysis.fields.contact_model import contact_model
from nonsmooth.analysis.minimizers.agreement import PointLocator
from nonsmooth.analysis.minimizers.box_minimizers import forces_at
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.analysis.minimizers.minimum import Functional, Minima, balance_forces
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.contact_states import Twist, cross_product, regular_states, scene_rows
from nonsmooth.symbolic.mechanics.scene import Contact, LoadTable, Scene
from nonsmooth.symbolic.numbers.lazy import Lazy
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.plane import hull_holds_zero
from nonsmooth.symbolic.numbers.rounded import Rounded, rounded
from tests.conftest import Arrays, WheelData
from tests.four_wheel import CORNERS
from tests.hulls import stands
from tests.oracles.measured_tables import MeasuredTable
from tests.thorough import few, keep

# Relative to D: the linear program's own feasibility tolerance is 1e-7 absolute, its optimum is a vertex and so
# accurate to rounding.
OPTIMUM_AGREEMENT = 1e-9
# Of 40 random arrays those that stand on their wheels; where the others tip, test_load_regions.py says.
STANDING = [0, 2, 3, 4, 5, 6, 7, 8, 9, 10, 13, 16, 17, 18, 19, 22, 24, 26, 28, 29, 31, 32, 33, 35, 36, 37, 39]


def opposite(side: HalfPlane) -> HalfPlane:
    """The closed complement."""
    return HalfPlane((-side.normal[0], -side.normal[1]), -side.offset, side.label)


def weights_at(scene: Scene, point: Point) -> list[Number]:
    """``mu_k N_i / |D_i|`` of every scaled row at a point, exactly."""
    region = next(r for r in load_regions(scene) if r.polygon.contains(point))
    result = []
    for row in scene_rows(scene):
        friction = row.wheel.friction.roll if row.kind == "R" else row.wheel.friction.side
        result.append(value_at(region.forces[row.wheel.index - 1], point) * friction / row.wheel.length)
    return result


def dissipation(scene: Scene, weights: list[Number], twist: Twist) -> Number:
    total: Number = scene.field.zero
    for row, weight in zip(scene_rows(scene), weights, strict=True):
        total = total + weight * abs(row.residual(twist))
    return total


def linear_program_optimum(scene: Scene, weights: list[Number]) -> float:
    a = np.array([[float(x) for x in row.normal] for row in scene_rows(scene)])
    b = np.array([float(row.rhs) for row in scene_rows(scene)])
    w = np.array([float(x) for x in weights])
    identity = np.eye(len(b))
    result = linprog(
        np.r_[np.zeros(3), w],
        A_ub=np.block([[a, -identity], [-a, -identity]]),
        b_ub=np.r_[b, -b],
        bounds=[(None, None)] * 3 + [(0, None)] * len(b),
    )
    return float(result.fun)


def check_cells(arrays: Arrays, scene: Scene, rng: np.random.Generator, most: int = 40) -> Partition:
    """Cells tile, and each twist attains the optimum of an independent linear program inside its cell."""
    partition = build_box_partition(scene)
    assert partition.tiles
    for k in rng.permutation(len(partition.cells))[:most]:
        cell = partition.cells[k]
        point = arrays.interior_point(cell.polygon, rng)
        weights = weights_at(scene, point)
        assert all(weight.sign() >= 0 for weight in weights)
        optimum = linear_program_optimum(scene, weights)
        for twist in cell.twists:
            assert abs(float(dissipation(scene, weights, twist)) - optimum) <= OPTIMUM_AGREEMENT * max(optimum, 1.0)
    return partition


@pytest.mark.parametrize(
    ("side", "cells"),
    [(Fraction(1, 2), 5), (Fraction(1, 5), 13), (Fraction(1, 10), 13), (Fraction(1, 100), 13), (1, 1), (2, 1)],
)
def test_four_wheel_cells_and_rest_area(arrays: Arrays, side: Fraction, cells: int) -> None:
    scene = arrays.four_wheel((1, side))
    partition = build_box_partition(scene)
    assert len(partition.cells) == cells
    assert partition.area_error == 0
    (rest,) = rest_cells(partition)
    # rest iff |x| + |y| <= mu_S/mu_R: the diamond, cut by the square where the ratio exceeds 1/2
    if side <= Fraction(1, 2):
        assert {tuple(map(str, v)) for v in rest.polygon.vertices} == {
            (str(x), str(y)) for x, y in [(side, 0), (0, side), (-side, 0), (0, -side)]
        }
    else:
        assert rest.polygon.area == 1


@pytest.mark.parametrize("side", [Fraction(1, 5), Fraction(1, 10), Fraction(1, 100), Fraction(1, 10**6)])
def test_the_papers_states_are_among_the_minimizers_and_fill_the_square_as_side_friction_vanishes(
    arrays: Arrays, side: Fraction
) -> None:
    scene = arrays.four_wheel((1, side))
    paper = {state.twist for state in build_nearest_partition(scene).states}
    partition = build_box_partition(scene)
    owned = [cell for cell in partition.cells if cell.twists[0] in paper]
    assert {cell.twists[0] for cell in owned} == paper
    assert sum(cell.polygon.area for cell in owned) == 1 - 2 * side


@few(1)
@pytest.mark.parametrize("count", range(3, 9))
def test_rings_against_a_linear_program(arrays: Arrays, count: int) -> None:
    scene = arrays.ring(count, (1, Fraction(1, 5)), Fraction(1, 4))
    assert check_cells(arrays, scene, np.random.default_rng(count)).area_error == 0


@few(1)
@pytest.mark.parametrize(("rows", "radius"), keep(2, [(2, Fraction(2, 5)), (3, Fraction(1, 2)), (4, Fraction(5, 4))]))
def test_grids_against_a_linear_program(arrays: Arrays, rows: int, radius: Fraction) -> None:
    scene = arrays.grid(rows, rows, (1, Fraction(1, 5)), radius)
    assert check_cells(arrays, scene, np.random.default_rng(rows)).area_error == 0


def random_scene(arrays: Arrays, seed: int, count: int = 0) -> Scene:
    """So many wheels, by default four to seven, and a square small enough that most bodies stand."""
    scene = arrays.random(seed, count or int(np.random.default_rng(seed).integers(4, 8)))
    return replace(scene, check=replace(scene.check, radius=scene.field(1) / (16 if count else 8)))


@pytest.mark.parametrize("seed", STANDING)
def test_random_arrays_against_a_linear_program(arrays: Arrays, seed: int) -> None:
    scene = random_scene(arrays, seed)
    assert check_cells(arrays, scene, np.random.default_rng(seed), most=15).area_error == 0


def test_the_seeds_are_those_of_arrays_that_stand(arrays: Arrays) -> None:
    assert [seed for seed in range(40) if stands(random_scene(arrays, seed))] == STANDING


@pytest.mark.parametrize(("seed", "count"), [(1, 8), (2, 9), (1, 10)])
def test_over_many_roots_the_area_is_a_small_ball_around_zero(arrays: Arrays, seed: int, count: int) -> None:
    """There exact quotients would take too long; that the cells tile is decided all the same."""
    scene = random_scene(arrays, seed, count)
    area_error = check_cells(arrays, scene, np.random.default_rng(seed), most=15).area_error
    assert len(scene.field.radicands) > AREA_ROOTS
    assert isinstance(area_error, arb)
    assert area_error.contains(0)
    assert float(area_error.rad()) < 1e-50


@pytest.mark.parametrize("seed", range(6))
def test_the_walk_finds_what_enumerating_all_triples_finds(arrays: Arrays, seed: int) -> None:
    """The literal definition: the best of all regular triples at a point."""
    rng = np.random.default_rng(seed)
    scene = arrays.with_friction(arrays.four_wheel(turn=arrays.circle_point(Fraction(seed, 7))), (1, Fraction(1, 3)))
    partition = build_box_partition(scene)
    twists = {state.twist for state in regular_states(scene)}
    for cell in partition.cells:
        point = arrays.interior_point(cell.polygon, rng)
        weights = weights_at(scene, point)
        best = min(dissipation(scene, weights, twist) for twist in twists)
        assert dissipation(scene, weights, cell.twists[0]) == best


@pytest.mark.parametrize("name", ["ring-5", "grid-4x4"])
def test_slopes_that_are_handed_on_are_those_that_are_built(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    """The slope back along an edge is minus the slope along it."""
    learn, found = Slopes.learn, list[SlopeOfD]()

    def learned(self: Slopes, slope: SlopeOfD, before: Form) -> SlopeOfD | None:
        back = learn(self, slope, before)
        if back is not None:
            assert back.exact == self._arrangement.slopes_along(back.pair, self._signs)[back.sense < 0]
            found.append(back)
        return back

    monkeypatch.setattr(Slopes, "learn", learned)
    cells = build_box_partition(load_scene(name, rule="box")).cells
    assert len(found) > len(cells)


@pytest.mark.parametrize("scale", [1, 10**9 + 7])
def test_edges_along_one_line_have_one_way(arrays: Arrays, scale: int) -> None:
    """Products of whole numbers that are short, and of others that 64 bits do not hold."""
    places = product((-scale - 2, scale, scale + 2), (-2 * scale, 3, 2 * scale + 1))
    scene = arrays.scene([WheelData(place, (1 - place[0], 2 - place[1])) for place in places], (1, 1), scale)
    arrangement = Arrangement(scene, load_regions(scene)[0])
    pairs = np.array(list(combinations(range(len(arrangement.rows)), 2)))
    ways = arrangement.lines.ways(pairs)
    assert ways is not None
    assert arrangement.lines.ways(pairs[:9]) == ways[:9]
    edges = [arrangement.lines.edge(tuple(pair)) for pair in pairs.tolist()]
    for way, edge in zip(ways, edges, strict=True):
        assert any(way) == any(edge)
        assert not any(cross_product(way, edge))
        assert math.gcd(*way) == (1 if any(way) else 0)
    alike = {max(way, tuple(-entry for entry in way)) for way in ways}
    assert len(set(ways)) == len(alike) < len(ways)


@pytest.mark.parametrize(("side", "cells", "first", "most"), [(2, 13, 0, 26), (6, 157, 60, 300)])
def test_ties_are_left_out_where_floats_or_whole_numbers_decide(
    arrays: Arrays, monkeypatch: pytest.MonkeyPatch, side: int, cells: int, first: int, most: int
) -> None:
    """Of symmetric arrays hundreds of lines touch a cell at its corners; few of them are built, most on demand."""
    build, pairs = Arrangement.slopes_along, list[tuple[int, int]]()

    def built(self: Arrangement, pair: tuple[int, int], signs: np.ndarray) -> tuple[Affine, Affine]:
        pairs.append(pair)
        return build(self, pair, signs)

    monkeypatch.setattr(Arrangement, "slopes_along", built)
    friction = (1, Fraction(1, 5))
    scene = arrays.four_wheel(friction) if side == 2 else arrays.grid(side, side, friction)
    partition = build_box_partition(scene)
    assert len(partition.cells) == cells
    assert len(pairs) <= first
    assert partition.tiles
    assert len(pairs) <= most


def test_twists_tie_only_on_shared_sides(arrays: Arrays) -> None:
    """Theorem 2: on a common side both twists minimize D, and so does their midpoint."""
    scene = arrays.four_wheel((1, Fraction(1, 5)))
    partition = build_box_partition(scene)
    met = 0
    for first, second in combinations(partition.cells, 2):
        common = [v for v in first.polygon.vertices if second.polygon.contains(v)]
        if len(common) == 2:
            met += 1
            (x1, y1), (x2, y2) = common
            weights = weights_at(scene, ((x1 + x2) / 2, (y1 + y2) / 2))
            a, b = first.twists[0], second.twists[0]
            middle = Twist(*((p + q) / 2 for p, q in zip(a, b, strict=True)))
            values = {dissipation(scene, weights, twist) for twist in (a, b, middle)}
            assert len(values) == 1
    assert met >= len(partition.cells) - 1


def test_equal_isotropic_wheels_tie_on_the_whole_square(arrays: Arrays) -> None:
    """Theorem 1's exception: two equal wheels, equal loads, isotropic friction."""
    wheels = [w._replace(friction=(1, 1)) for w in arrays.inward([(1, 0), (-1, 0)])]
    scene = arrays.scene(wheels)
    half, zero = scene.field(1) / 2, scene.field.zero
    scene = replace(scene, contact=Contact("box", LoadTable(((half, zero, zero),) * 2)))
    partition = build_box_partition(scene)
    assert partition.area_error == 0
    weights = weights_at(scene, (zero, zero))
    (cell,) = partition.cells
    assert len(cell.states) > 1
    assert cell.polygon.area == 1
    assert len(cell.twists) > 1
    assert len({dissipation(scene, weights, twist) for twist in cell.twists}) == 1


@pytest.mark.parametrize("exponent", [-12, -6, 6, 12])
def test_extreme_friction_ratios(arrays: Arrays, exponent: int) -> None:
    side = Fraction(10) ** exponent
    partition = build_box_partition(arrays.four_wheel((1, side)))
    assert partition.area_error == 0
    assert len(partition.cells) == (13 if exponent < 0 else 1)


@pytest.mark.parametrize("scale", [Fraction(1, 10**9), 10**9])
def test_extreme_scales_change_nothing(arrays: Arrays, scale: Fraction) -> None:
    scene = arrays.four_wheel((1, Fraction(1, 5)))
    wheels = tuple(replace(w, position=(w.position[0] * scale, w.position[1] * scale)) for w in scene.wheels)
    scaled = replace(scene, wheels=wheels, check=replace(scene.check, radius=scene.check.radius * scale))
    partition = build_box_partition(scaled)
    assert partition.area_error == 0
    assert sorted(c.polygon.area / scale / scale for c in partition.cells) == sorted(
        c.polygon.area for c in build_box_partition(scene).cells
    )


def test_wheels_that_almost_coincide(arrays: Arrays) -> None:
    """Rows that differ by 1e-12: floats decide nothing about them."""
    corner = arrays.inward([(1 + Fraction(1, 10**12), 1)])
    wheels = arrays.inward(CORNERS)
    scene = arrays.scene([*wheels, *corner], (1, Fraction(1, 5)))
    check_cells(arrays, scene, np.random.default_rng(0))


def test_wheels_may_stand_at_one_place(arrays: Arrays) -> None:
    """Files refuse that, and a certificate may say it: the two wheels nearest to the point give no three free rows."""
    nearest = arrays.inward([(Fraction(1, 2), Fraction(1, 2))])
    scene = arrays.scene([*nearest, *nearest, *arrays.inward(CORNERS)], (1, Fraction(1, 5)))
    check_cells(arrays, scene, np.random.default_rng(0))


def test_arrays_without_enough_friction_are_refused(arrays: Arrays) -> None:
    with pytest.raises(RefusalError, match="not determined"):
        build_box_partition(arrays.four_wheel((1, 0)))


@pytest.mark.parametrize("name", ["four-wheel", "ring-5", "elliptic", "grid-4x4"])
def test_the_explicit_minimizer_proves_itself_at_random_points(name: str) -> None:
    """Forces at the located twist: inside the box, in balance, and without a duality gap."""
    scene = load_scene(name, rule="box", radius="1/4")
    points = np.random.default_rng(0).uniform(-0.25, 0.25, (60, 2))
    model, twists = contact_model(scene), PointLocator(build_box_partition(scene)).twists(points)
    loads = loads_at(model, points)
    forces = np.array([forces_at(model, load, twist) for load, twist in zip(loads, twists, strict=True)])
    balanced = balance_forces(Functional.BOX, model, loads, forces)
    assert Minima(Functional.BOX, model, loads, twists, balanced).check().all()


# ---- Convex polygons and their clipping: one test body over floats, fractions and exact field numbers.

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
        parts = [part for part in (polygon.clipped(cut), polygon.clipped(opposite(cut))) if part is not None]
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
    assert polygon.clipped(opposite(cut)) is None


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


@few(2)
@pytest.mark.parametrize("seed", [28, 15, *range(15), *range(16, 28), *range(29, 40)])
def test_no_cell_of_a_measured_table_is_left_to_rounding(tmp_path: Path, seed: int) -> None:
    """Whether two sides lie on one line is the same question for all angles so close: its quotients are not."""
    file = tmp_path / "table.toml"
    file.write_text(MeasuredTable.random(seed, "box", off=seed % 10).toml, encoding="utf-8")
    scene = load_scene(file)
    assert any(isinstance(entry, Rounded) for wheel in scene.wheels for entry in wheel.direction)
    assert build_box_partition(scene.recentred()).cells
    assert scene.field.rounded_signs == 0


@few(2)
@pytest.mark.parametrize("seed", [0, 3, 4, 5, 7, 8, 9, 10, 11])  # of several cells
def test_floats_of_a_measured_table_hold_for_all_angles_so_close(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, seed: int
) -> None:
    """The balls of all slopes that bound cells lie within the stated errors, and exact signs alone find the same."""
    file = tmp_path / "table.toml"
    file.write_text(MeasuredTable.random(seed, "box", off=seed % 10).toml, encoding="utf-8")
    cells = build_box_partition(load_scene(file).recentred()).cells
    slopes = [side.origin for cell in cells for side in vars(cell)["_found"][1].sides if side.origin is not None]
    for slope in slopes:
        values, sizes, error = slope.filtered
        assert error == outline_module.ROUNDED
        for value, size, number in zip(values, sizes, slope.exact, strict=True):
            assert abs(number.ball() - value) <= error * size
    assert len(slopes) > len(cells)

    monkeypatch.setattr(outline_module, "ROUNDED", math.nan)
    monkeypatch.setattr(arrangement_module, "ROUNDED", math.nan)
    exactly = build_box_partition(load_scene(file).recentred()).cells
    assert [_twists(cell) for cell in exactly] == [_twists(cell) for cell in cells]
    assert [len(cell.polygon.vertices) for cell in exactly] == [len(cell.polygon.vertices) for cell in cells]


def _twists(cell: Cell) -> list[list[float]]:
    return [[float(entry) for entry in twist] for twist in cell.twists]


@pytest.mark.parametrize("centre", [0.0, 3e5, -1e-9])
def test_squares_hold_all_places_that_are_close(centre: float) -> None:
    """Those whose coordinates differ by the doubt at most, in whatever squares; where one is beyond floats, all."""
    doubt, rng = 2.0**-20, np.random.default_rng(0)
    drawn = centre + doubt * (rng.integers(-4, 5, (400, 2)) + rng.uniform(-1e-9, 1e-9, (400, 2)))
    drawn[::50] = math.inf, math.nan
    sorted_places = cell_complex._Places(doubt)
    for number, (x, y) in enumerate(drawn.tolist()):
        close = set(sorted_places.close((x, y)))
        with np.errstate(invalid="ignore"):
            apart = np.abs(drawn[:number] - (x, y)) > doubt
        apart[~np.isfinite(drawn[:number])] = False
        asked = ~apart.any(axis=1) if math.isfinite(x) else np.ones(number, dtype=bool)
        assert close >= set(np.flatnonzero(asked).tolist())
        sorted_places.add((x, y))
    assert len(close) < 300
