"""Equilibria of arrays, and of the continuous idealization, against quadrature, sampling and damped motion."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from nonsmooth.analysis.bodies.continuum import (
    HeadingEffect,
    MomentFreeHeading,
    NoIdealizationError,
    Prediction,
    footprints,
    idealization,
    moments,
    polygon_wrench,
    predict,
    predictions,
)
from nonsmooth.analysis.cells.box import build_box_partition
from nonsmooth.analysis.cells.equilibria import EquilibriumPlace, RestPlace, find_equilibria, shared_sides
from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.proofs.findings import Translation
from nonsmooth.proofs.theorem4 import check_cells
from nonsmooth.symbolic.files.scene_document import rectangle
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.body import ContinuousField, Disc, PolygonShape
from nonsmooth.symbolic.mechanics.contact_states import Twist
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from tests.conftest import Arrays
from tests.four_wheel import ROLL, SIDE
from tests.hulls import hull_holds_zero
from tests.thorough import few, keep


def holds_zero(partition: Partition, point: Point) -> bool:
    """0 in the hull of the velocities at a point, by an independent linear program."""
    return hull_holds_zero(t.pose_rate(point) for cell in partition.cells_at(point) for t in cell.twists)


def places(found: tuple[RestPlace, ...]) -> set[tuple[str, frozenset[tuple[str, str]]]]:
    return {(str(e.place), frozenset((str(x), str(y)) for x, y in e.points)) for e in found}


def test_four_wheel_rests_at_the_origin_alone(arrays: Arrays) -> None:
    found = find_equilibria(build_nearest_partition(arrays.four_wheel()))
    assert places(found) == {("vertex", frozenset({("0", "0")}))}


def test_with_side_friction_first_both_axes_are_equilibria(arrays: Arrays) -> None:
    found = find_equilibria(build_nearest_partition(arrays.four_wheel(SIDE)))
    ends = [("1/2", "0"), ("-1/2", "0"), ("0", "1/2"), ("0", "-1/2")]
    assert places(found) == {("segment", frozenset({("0", "0"), end})) for end in ends}


def test_the_rest_area_of_rule_box_is_one_diamond(arrays: Arrays) -> None:
    (area,) = find_equilibria(build_box_partition(arrays.four_wheel((1, Fraction(1, 5)))))
    assert area.place is EquilibriumPlace.AREA
    assert {(str(x), str(y)) for x, y in area.points} == {("1/5", "0"), ("-1/5", "0"), ("0", "1/5"), ("0", "-1/5")}


def test_a_shifted_array_has_its_equilibrium_where_the_array_is(arrays: Arrays) -> None:
    scene = arrays.four_wheel()
    shift = (scene.field(1) / 4, scene.field(1) / 8)
    wheels = tuple(replace(w, position=(w.position[0] + shift[0], w.position[1] + shift[1])) for w in scene.wheels)
    (found,) = find_equilibria(build_nearest_partition(replace(scene, wheels=wheels)))
    assert found.points == (shift,)


def test_a_cell_may_turn_about_a_point_of_its_own(arrays: Arrays) -> None:
    """Three tangential rims: every cell turns about the origin, which all of them share."""
    scene = arrays.scene(arrays.inward([(1, 0), (-1, 0), (0, 1), (0, -1)], turn=(0, 1)), friction=(1, Fraction(1, 10)))
    found = find_equilibria(build_box_partition(replace(scene, check=replace(scene.check, radius=scene.field(1) / 4))))
    assert (str(EquilibriumPlace.CENTRE), frozenset({("0", "0")})) in places(found)


def test_two_cells_may_turn_about_a_point_of_their_common_side() -> None:
    """One twist on both sides of the axle: velocities are parallel along it, and vanish at one point of it alone."""
    (found,) = find_equilibria(build_nearest_partition(load_scene("differential-drive")))
    assert (found.place, found.cells) == (EquilibriumPlace.SIDE, (1, 2))
    assert not any(found.points[0])
    (seen,) = check_cells(load_scene("differential-drive", at="1/16,0")).equilibria or ()
    assert list(map(str, seen.found.points[0])) == ["-1/16", "0"]


@pytest.mark.parametrize("count", keep(1, [100, 300]))
def test_motions_that_tie_in_a_cell_may_cancel_along_a_line_or_everywhere(arrays: Arrays, count: int) -> None:
    """Isotropic friction leaves two twists per cell; where they oppose each other the body may rest."""
    partition = build_nearest_partition(arrays.four_wheel((1, 1)))
    for equilibrium in find_equilibria(partition):
        n = len(equilibrium.points)
        assert holds_zero(partition, tuple(sum(p[k] for p in equilibrium.points) / n for k in (0, 1)))
    scanned = np.random.default_rng(0).uniform(-0.5, 0.5, (count, 2))
    areas = [e for e in find_equilibria(partition) if e.place is EquilibriumPlace.AREA]
    assert not areas
    assert not any(holds_zero(partition, (Fraction(x), Fraction(y))) for x, y in scanned)


@few(1)
@pytest.mark.parametrize("seed", range(200))
def test_every_equilibrium_of_a_random_array_is_one_and_none_is_missed(arrays: Arrays, seed: int) -> None:
    rng = np.random.default_rng(seed)
    scene = arrays.random(seed, int(rng.integers(3, 7)))
    partition = build_nearest_partition(scene)
    found = find_equilibria(partition)
    for equilibrium in found:
        n = len(equilibrium.points)
        middle = (sum(p[0] for p in equilibrium.points) / n, sum(p[1] for p in equilibrium.points) / n)
        assert holds_zero(partition, middle)
    isolated = {p for e in found if len(e.points) == 1 for p in e.points}
    segments = [e for e in found if len(e.points) > 1]
    for cell in partition.cells:
        for vertex in cell.polygon.vertices:
            known = vertex in isolated or any(vertex in e.points or _on(e, vertex) for e in segments)
            assert known == holds_zero(partition, vertex)


def _on(equilibrium: RestPlace, point: Point) -> bool:
    (x1, y1), (x2, y2) = equilibrium.points[0], equilibrium.points[-1]
    ax, ay, bx, by = point[0] - x1, point[1] - y1, point[0] - x2, point[1] - y2
    return bool(ax * by == ay * bx and ax * bx + ay * by <= 0)


def opposed_rates(first: Twist, second: Twist, point: np.ndarray) -> tuple[float, float]:
    """Cross and inner product of two velocities, in floats."""
    u, v = ([float(w.vx) - float(w.omega) * point[1], float(w.vy) + float(w.omega) * point[0]] for w in (first, second))
    return u[0] * v[1] - u[1] * v[0], u[0] * v[0] + u[1] * v[1]


@pytest.mark.parametrize("seed", range(20))
def test_equilibria_on_sides_against_a_scan(arrays: Arrays, seed: int) -> None:
    """Where two velocities become parallel along a side, the point is listed iff they oppose each other."""
    rng = np.random.default_rng(seed)
    scene = arrays.with_friction(arrays.random(seed, int(rng.integers(3, 7))), ROLL)
    partition = build_nearest_partition(scene)
    found = [
        np.array([float(x) for x in e.points[0]])
        for e in find_equilibria(partition)
        if e.place is EquilibriumPlace.SIDE
    ]
    crossings = opposed = 0
    for side in shared_sides(partition):
        a, b = side.first.twists[0], side.second.twists[0]
        start, end = (np.array([float(x) for x in p]) for p in (side.start, side.end))
        at_start, at_end = (opposed_rates(a, b, p)[0] for p in (start, end))
        if at_start * at_end >= 0 or max(abs(at_start), abs(at_end)) < 1e-9:  # no zero between, or zero throughout
            continue
        crossings += 1
        point = start + (end - start) * at_start / (at_start - at_end)
        cross, product = opposed_rates(a, b, point)
        assert abs(cross) < 1e-9 * max(1, abs(at_start), abs(at_end))  # linear along the side
        assert any(np.hypot(*(point - p)) < 1e-9 for p in found) == (product < 0)
        opposed += product < 0
    assert crossings > 0
    assert opposed == len(found)


# ---- verdicts of their own -----------------------------------------------------------------------


def test_each_isolated_equilibrium_is_judged_about_its_own_point(arrays: Arrays) -> None:
    """Checked beside its middle, the four-wheel array has its one equilibrium where a direct check has it."""
    scene = arrays.four_wheel()
    beside = replace(scene, check=replace(scene.check, equilibrium=(scene.field(1) / 8, scene.field(1) / 16)))
    (other,) = check_cells(beside).others or ()
    direct = check_cells(scene)
    assert other.found.points == ((-scene.field(1) / 8, -scene.field(1) / 16),)
    assert (other.translation, other.rotation) == (direct.translation.verdict, direct.rotation.verdict)


@few(1)
@pytest.mark.parametrize("seed", range(12))
def test_judged_verdicts_equal_a_check_at_the_point(arrays: Arrays, seed: int) -> None:
    scene = arrays.random(seed, 5)
    isolated = [judged for judged in check_cells(scene).others or () if judged.translation is not None]
    assert isolated
    for judged in isolated:
        x, y = judged.found.points[0]
        at = (scene.check.equilibrium[0] + x, scene.check.equilibrium[1] + y)
        there = check_cells(replace(scene, check=replace(scene.check, equilibrium=at)))
        assert (judged.translation, judged.rotation) == (there.translation.verdict, there.rotation.verdict)


# ---- the border of the square ---------------------------------------------------------------------


def beside_the_point(scene: Scene, x: Fraction, y: Fraction, radius: Fraction) -> Scene:
    """The array checked at (x, y) on a square of a half-width."""
    at = (scene.field.zero + x, scene.field.zero + y)
    return replace(scene, check=replace(scene.check, equilibrium=at, radius=scene.field(1) * radius))


@pytest.mark.parametrize(("x", "y"), [(1, 1), (1, -1), (-1, 1), (1, 0), (0, -1), (1, Fraction(1, 3))])
def test_an_equilibrium_on_the_border_is_found_whatever_the_radius(arrays: Arrays, x: Fraction, y: Fraction) -> None:
    """The middle of the four-wheel array at a corner, or on a side, of the square, and well inside a larger one."""
    scene, quarter = arrays.four_wheel(), Fraction(1, 4)
    for radius in (quarter, quarter * Fraction(5, 4)):
        checked = check_cells(beside_the_point(scene, x * quarter, y * quarter, radius))
        (other,) = checked.others or ()
        assert other.found.points == ((scene.field.zero - x * quarter, scene.field.zero - y * quarter),)
        assert other.translation is Translation.ASYMPTOTICALLY_STABLE


@few(3)
@pytest.mark.parametrize(("x", "y"), [(1, 1), (-1, 1), (1, 0), (0, 1), (1, Fraction(1, 2))])
def test_equilibria_along_the_border_are_those_of_the_plane(arrays: Arrays, x: Fraction, y: Fraction) -> None:
    """With side friction first both axes rest: sides of the square may lie on them.  By the hull on a larger square."""
    quarter = Fraction(1, 4)
    scene = beside_the_point(arrays.four_wheel(SIDE), x * quarter, y * quarter, quarter).recentred()
    large = build_nearest_partition(replace(scene, check=replace(scene.check, radius=scene.field(1) / 2)))
    listed = [judged.found for judged in check_cells(scene).others or ()]
    seen = 0
    for share in (Fraction(k, 8) for k in range(-8, 9)):
        for own in ((1, share), (-1, share), (share, 1), (share, -1)):
            point = (scene.field.zero + quarter * own[0], scene.field.zero + quarter * own[1])
            known = any(point in e.points or (len(e.points) > 1 and _on(e, point)) for e in listed)
            assert known == holds_zero(large, point)
            seen += known
    assert seen


# ---- The continuous idealization: force, moment and equilibria against quadrature, sampling and damped motion.

QUADRATURE = 1e-12  # Gauss-Legendre on pieces without the singular centre, or in coordinates that take it away
SAMPLED = 0.02  # Monte Carlo with 200 000 points
DIFFERENCE = 1e-8  # central differences of closed forms
ROOT = 1e-12  # force and moment at a pose that was found
MOTION = 1e-6  # heading after damped motion

FIELD = NumberField()
RADIAL, ELLIPTIC = ((-1, 0), (0, -1)), ((-1, 0), (0, -2))
SPIRAL, SADDLE = ((-4, 3), (-3, -4)), ((-1, 0), (0, 3))
MATRICES = [RADIAL, ELLIPTIC, SPIRAL, SADDLE]
SQUARE = [(0, 0), (1, 0), (1, 1), (0, 1)]
TRIANGLE = [(0, 0), (3, 0), (0, 1)]
ELL = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 3), (0, 3)]
SHAPES = [SQUARE, TRIANGLE, ELL]


def polygon(points: list[tuple[int, int]]) -> PolygonShape:
    """Measured from the centroid, which is found here as the limit of a fan of triangles."""
    fan = [(points[0], points[k], points[k + 1]) for k in range(1, len(points) - 1)]
    areas = [Fraction((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]), 2) for a, b, c in fan]
    weighted = [[s * Fraction(a[k] + b[k] + c[k], 3) for s, (a, b, c) in zip(areas, fan, strict=True)] for k in (0, 1)]
    x, y = (sum(values, Fraction(0)) / sum(areas, Fraction(0)) for values in weighted)
    return PolygonShape(tuple((FIELD(px - x), FIELD(py - y)) for px, py in points))


def field(matrix: tuple[tuple[int, int], tuple[int, int]], speed: int | None = 1) -> ContinuousField:
    (a, b), (c, d) = matrix
    exact = ((FIELD(a), FIELD(b)), (FIELD(c), FIELD(d)))
    return ContinuousField("test", exact, None if speed is None else FIELD(speed), (FIELD.zero, FIELD.zero))


def floats_of(rows: Sequence[tuple[Number, Number]]) -> list[list[float]]:
    return [[float(x), float(y)] for x, y in rows]


def floats(shape: PolygonShape) -> Floats:
    return np.array(floats_of(shape.vertices))


def turned(vertices: Floats, theta: float) -> Floats:
    c, s = math.cos(theta), math.sin(theta)
    return vertices @ np.array([[c, s], [-s, c]])


def force_at(matrix: Floats, points: Floats, speed: float | None) -> Floats:
    f = points @ matrix.T
    return f if speed is None else speed * f / np.hypot(*f.T)[:, None]


def swept(matrix: Floats, vertices: Floats, centroid: Floats, speed: float | None) -> tuple[Floats, float]:
    """Force and moment by Gauss-Legendre in (r, t) on the signed triangles over the sides, in 16 pieces each."""
    nodes, weights = np.polynomial.legendre.leggauss(40)
    nodes, weights = (nodes + 1) / 2, weights / 2
    t, u = ((nodes[None, :] + np.arange(16)[:, None]) / 16).ravel(), np.tile(weights / 16, 16)
    force, moment = np.zeros(2), 0.0
    for a, b in zip(vertices, np.roll(vertices, -1, axis=0), strict=True):
        side = a + t[:, None] * (b - a)
        for r, w in zip(nodes, weights, strict=True):
            p = r * side
            f = force_at(matrix, p, speed) * (w * u * r * (a[0] * b[1] - a[1] * b[0]))[:, None]
            force += f.sum(axis=0)
            arm = p - centroid
            moment += float((arm[:, 0] * f[:, 1] - arm[:, 1] * f[:, 0]).sum())
    return force, moment


# ---- moments and closed forms --------------------------------------------------------------------


def test_second_moments_of_known_shapes() -> None:
    box = moments(rectangle(FIELD(Fraction(3, 2)), FIELD(Fraction(1, 2))))
    assert [str(value) for value in (box.area, box.xx, box.yy, box.xy)] == ["3", "9/4", "1/4", "0"]
    triangle = moments(polygon(TRIANGLE))  # b h^3/36, h b^3/36, -b^2 h^2/72
    assert [str(value) for value in (triangle.area, triangle.xx, triangle.yy)] == ["3/2", "3/4", "1/12"]
    assert triangle.xy == Fraction(-9, 72)
    disc = moments(Disc(FIELD(2)))
    assert [str(disc.area), str(disc.xx)] == ["4", "4"]
    assert (box.unit, disc.unit, disc.are_isotropic) == (1, math.pi, True)


def test_an_angle_is_two_rectangles() -> None:
    """Parallel axes (Huygens and Steiner) for the L of a 2 x 1 and a 1 x 2 rectangle."""
    found, centroid = moments(polygon(ELL)), (Fraction(3, 4), Fraction(5, 4))
    parts = [((Fraction(1), Fraction(1, 2)), 2, 1), ((Fraction(1, 2), Fraction(2)), 1, 2)]
    xx = yy = xy = Fraction(0)
    for (x, y), w, h in parts:
        dx, dy = x - centroid[0], y - centroid[1]
        xx += Fraction(h * w**3, 12) + w * h * dx * dx
        yy += Fraction(w * h**3, 12) + w * h * dy * dy
        xy += w * h * dx * dy
    assert [found.area - 4, found.xx - xx, found.yy - yy, found.xy - xy] == [0, 0, 0, 0]


@few(3)
@pytest.mark.parametrize("shape", SHAPES, ids=["square", "triangle", "ell"])
@pytest.mark.parametrize("matrix", MATRICES, ids=["radial", "elliptic", "spiral", "saddle"])
def test_closed_forms_against_quadrature(
    matrix: tuple[tuple[int, int], tuple[int, int]], shape: list[tuple[int, int]]
) -> None:
    a, vertices = np.array(matrix, dtype=float), floats(polygon(shape))
    for place in ([0.0, 0.0], [0.3, -0.2], [5.0, 4.0]):  # the field's centre inside, and far outside
        centroid = np.array(place)
        at = turned(vertices, 0.7) + centroid
        found = polygon_wrench(a, 1.5, at, centroid)
        force, moment = swept(a, at, centroid, 1.5)
        assert found.force == pytest.approx(force, abs=QUADRATURE * 10)
        assert found.moment == pytest.approx(moment, abs=QUADRATURE * 10)
        step = 1e-6 * np.eye(2)
        moved = [
            polygon_wrench(a, 1.5, at + s, centroid + s).force - polygon_wrench(a, 1.5, at - s, centroid - s).force
            for s in step
        ]
        assert found.stiffness == pytest.approx(np.array(moved).T / 2e-6, abs=DIFFERENCE)


def test_a_side_through_the_centre_and_a_corner_on_it() -> None:
    """The singular point of the field lies on the border; the limit is approached from beside it."""
    a, vertices = np.array(ELLIPTIC, dtype=float), floats(polygon(SQUARE))
    for place in ([0.5, 0.0], [0.5, 0.5]):
        on, beside = (polygon_wrench(a, 1.0, vertices + p, p) for p in (np.array(place), np.array(place) + 1e-9))
        assert np.isfinite(on.stiffness).all()
        assert on.force == pytest.approx(beside.force, abs=1e-7)
        assert on.moment == pytest.approx(beside.moment, abs=1e-7)


def test_sampled_force_and_moment() -> None:
    """Points of the bounding box that a ray leaves an odd number of times: no side is swept from a centre."""
    rng, centroid = np.random.default_rng(11), np.array([0.2, 0.4])
    vertices = turned(floats(polygon(ELL)), 0.4) + centroid
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    points = rng.uniform(low, high, (200_000, 2))
    inside = np.zeros(len(points), dtype=bool)
    for p, q in zip(vertices, np.roll(vertices, -1, axis=0), strict=True):
        spans = (p[1] > points[:, 1]) != (q[1] > points[:, 1])
        inside ^= spans & (points[:, 0] < p[0] + (points[:, 1] - p[1]) / (q[1] - p[1]) * (q[0] - p[0]))
    f = force_at(np.array(ELLIPTIC, dtype=float), points[inside], 1.0) * np.prod(high - low) / len(points)
    arm = points[inside] - centroid
    found = polygon_wrench(np.array(ELLIPTIC, dtype=float), 1.0, vertices, centroid)
    assert found.force == pytest.approx(f.sum(axis=0), abs=SAMPLED)
    assert found.moment == pytest.approx((arm[:, 0] * f[:, 1] - arm[:, 1] * f[:, 0]).sum(), abs=SAMPLED)


def test_a_disc_is_a_polygon_of_very_many_sides() -> None:
    """No moment about the centre, and a stiffness that returns where the disc does; radial: -pi r."""
    angle = 2 * np.pi * np.arange(20_000) / 20_000
    vertices = 0.7 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    for matrix in (RADIAL, ELLIPTIC, SADDLE):
        for speed in (2, -2):
            found = polygon_wrench(np.array(matrix, dtype=float), speed, vertices, np.zeros(2))
            assert abs(found.moment) <= ROOT
            returns = bool((np.linalg.eigvals(found.stiffness).real < 0).all())
            assert predict(field(matrix, speed), Disc(FIELD(Fraction(7, 10)))).attracts is returns
    radial = polygon_wrench(np.array(RADIAL, dtype=float), 1.0, vertices, np.zeros(2))
    assert radial.stiffness == pytest.approx(-0.7 * math.pi * np.eye(2), abs=1e-6)


# ---- predictions ---------------------------------------------------------------------------------


def stable_headings(found: Prediction) -> list[float]:
    return [heading.theta for heading in found.headings if heading.stable]


@pytest.mark.parametrize("speed", [None, 1])
def test_a_rectangle_lies_along_the_weaker_pull(speed: int | None) -> None:
    """M = (a - b)/2 (S_xx - S_yy) sin 2 theta for f = (-a x, -b y): equilibria 0 and pi/2, one stable."""
    wide, tall = rectangle(FIELD(2), FIELD(1)), rectangle(FIELD(1), FIELD(2))
    for matrix, weaker_along_x in ((ELLIPTIC, True), (((-2, 0), (0, -1)), False)):
        for shape, wide_shape in ((wide, True), (tall, False)):
            found = predict(field(matrix, speed), shape)
            first, second = found.headings
            assert (first.theta, second.theta) == pytest.approx((0, math.pi / 2), abs=ROOT)
            assert (first.stable, second.stable) == ((True, False) if weaker_along_x == wide_shape else (False, True))
            assert (found.rotation, found.attracts, found.offset) == (HeadingEffect.ORIENTS, True, 0)


@pytest.mark.parametrize("shape", [TRIANGLE, ELL])
def test_the_moment_of_a_linear_field(shape: list[tuple[int, int]]) -> None:
    """Kavraki's closed form against quadrature at every heading, and its zeros against the predicted headings."""
    body, a = polygon(shape), np.array(ELLIPTIC, dtype=float)
    second, vertices = moments(body), floats(body)
    xx, yy, xy = (float(value) for value in (second.xx, second.yy, second.xy))

    def moment(theta: float) -> float:
        return (a[1, 1] - a[0, 0]) * ((xx - yy) / 2 * math.sin(2 * theta) + xy * math.cos(2 * theta))

    for theta in np.linspace(0, 3, 7).tolist():
        force, found = swept(a, turned(vertices, theta), np.zeros(2), None)
        assert found == pytest.approx(moment(theta), abs=QUADRATURE * 100)
        assert force == pytest.approx(np.zeros(2), abs=QUADRATURE * 100)
    headings = predict(field(ELLIPTIC, None), body).headings
    assert len(headings) == 2
    for heading in headings:
        assert moment(heading.theta) == pytest.approx(0, abs=ROOT)
        assert (moment(heading.theta + 0.01) < 0) == heading.stable


def test_a_square_is_turned_by_a_field_of_constant_size_only() -> None:
    """Its second moments are isotropic, so a linear field leaves it alone; the fourth harmonic does not."""
    square = rectangle(FIELD(1), FIELD(1))
    assert predict(field(ELLIPTIC, None), square).rotation is HeadingEffect.KEEPS
    found = predict(field(ELLIPTIC), square)
    assert [h.theta for h in found.headings] == pytest.approx([0, math.pi / 4, math.pi / 2, 3 * math.pi / 4], abs=ROOT)
    assert [h.stable for h in found.headings] == [False, True, False, True]


def test_a_disc_keeps_its_heading() -> None:
    for matrix in (RADIAL, ELLIPTIC, SADDLE):
        for speed in (None, 1):
            found = predict(field(matrix, speed), Disc(FIELD(1)))
            assert (found.rotation, found.headings) == (HeadingEffect.KEEPS, ())
            assert found.attracts == (matrix is not SADDLE)


@pytest.mark.parametrize("shape", keep(1, [ELL, TRIANGLE]))
def test_a_radial_field_has_a_pivot_and_no_heading(shape: list[tuple[int, int]]) -> None:
    """The body point at the field's centre is the same at every heading, and the moment there vanishes."""
    body = polygon(shape)
    found = predict(field(RADIAL), body)
    assert (found.rotation, found.attracts) == (HeadingEffect.KEEPS, True)
    assert found.offset > 0.05
    a, vertices = np.array(RADIAL, dtype=float), floats(body)
    result = solve_ivp(
        lambda t, c: polygon_wrench(a, 1.0, vertices + c, c).force, (0, 60), [0.5, 0.5], rtol=1e-10, atol=1e-12
    )
    pivot = result.y[:, -1]
    assert np.hypot(*pivot) == pytest.approx(found.offset, abs=MOTION)
    for theta in (0.5, 2.0, 4.0):
        place = turned(pivot[None], theta)[0]
        there = polygon_wrench(a, 1.0, turned(vertices, theta) + place, place)
        assert there.force == pytest.approx(np.zeros(2), abs=MOTION)
        assert there.moment == pytest.approx(0, abs=MOTION)


@pytest.mark.parametrize("speed", [None, 1])
def test_a_spiral_turns_everything(speed: int | None) -> None:
    for shape in (Disc(FIELD(1)), rectangle(FIELD(2), FIELD(1)), polygon(ELL)):
        found = predict(field(SPIRAL, speed), shape)
        assert (found.rotation, found.attracts, found.headings) == (HeadingEffect.TURNS, True, ())
    outward = ((4, 3), (-3, 4))
    assert predict(field(outward, speed), Disc(FIELD(1))).attracts is False
    for shape in (Disc(FIELD(1)), rectangle(FIELD(2), FIELD(1)), polygon(ELL)):  # no pull inward at all: it circles
        assert predict(field(((0, 3), (-3, 0)), speed), shape).attracts is False


@few(1)
@pytest.mark.parametrize("shape", [TRIANGLE, ELL, SQUARE])
def test_damped_motion_ends_at_a_stable_heading(shape: list[tuple[int, int]]) -> None:
    """c' = F, theta' = M from several poses, knowing nothing of equilibria; the stable headings are all reached."""
    body, a = polygon(shape), np.array(ELLIPTIC, dtype=float)
    found, vertices = predict(field(ELLIPTIC), body), floats(body)
    assert [h.stable for h in found.headings] in ([True, False] * 2, [False, True] * 2, [True, False], [False, True])

    def motion(t: float, pose: Floats) -> list[float]:
        wrench = polygon_wrench(a, 1.0, turned(vertices, pose[2]) + pose[:2], pose[:2])
        return [*wrench.force, 20 * wrench.moment]

    reached = set()
    for start in ([0.4, 0.1, 0.1], [-0.2, 0.5, 1.2], [0.1, 0.1, 2.4]):
        end = solve_ivp(motion, (0, 400), start, method="LSODA", rtol=1e-9, atol=1e-11).y[:, -1]
        off = [abs(math.remainder(end[2] - heading, math.pi)) for heading in stable_headings(found)]
        assert min(off) <= MOTION
        reached.add(int(np.argmin(off)))
    assert reached == set(range(len(off)))


def test_at_a_heading_that_was_found_force_and_moment_vanish() -> None:
    """By quadrature, at the position where damped translation ends."""
    body, a = polygon(ELL), np.array(ELLIPTIC, dtype=float)
    for heading in predict(field(ELLIPTIC), body).headings:
        vertices = turned(floats(body), heading.theta)
        place = solve_ivp(
            lambda t, c, v=vertices: polygon_wrench(a, 1.0, v + c, c).force, (0, 60), [0, 0], rtol=1e-10, atol=1e-12
        ).y[:, -1]
        force, moment = swept(a, vertices + place, place, 1.0)
        assert [*force, moment] == pytest.approx([0, 0, 0], abs=MOTION)


def test_a_field_backwards_drives_away_and_swaps_headings() -> None:
    shape = rectangle(FIELD(2), FIELD(1))
    there, back = predict(field(ELLIPTIC, 1), shape), predict(field(ELLIPTIC, -1), shape)
    assert (there.attracts, back.attracts) == (True, False)
    assert [h.stable for h in back.headings] == [not h.stable for h in there.headings]


@pytest.mark.parametrize(("matrix", "speed"), [(((0, 0), (0, -1)), 1), (RADIAL, 0)])
def test_singular_and_zero_fields_are_refused(matrix: tuple[tuple[int, int], tuple[int, int]], speed: int) -> None:
    with pytest.raises(ValueError, match="regular linear field"):
        predict(field(matrix, speed), Disc(FIELD(1)))


# ---- scenes --------------------------------------------------------------------------------------


def scene_of(folder: Path, rest: str, wheels: str = "[ring]\ncount = 4\n") -> Scene:
    file = folder / "my.toml"
    file.write_text(f'[friction]\nmu_roll = 1\nmu_side = "1/2"\n{wheels}{rest}')
    return load_scene(file)


def test_what_scenes_stand_for() -> None:
    four, elliptic = idealization(load_scene("four-wheel")), idealization(load_scene("elliptic"))
    assert (four.kind, str(four.speed), elliptic.kind, str(elliptic.speed)) == ("radial", "1", "elliptic", "1")
    assert elliptic.matrix is not None
    assert floats_of(elliptic.matrix) == [[-1, 0], [0, -2]]
    box, disc = footprints(load_scene("rectangle"))
    assert isinstance(box, PolygonShape)
    assert floats(box).tolist() == [[-2, -1], [2, -1], [2, 1], [-2, 1]]
    assert isinstance(disc, Disc)
    assert 5 <= disc.radius * disc.radius <= Fraction(51, 10)


def test_the_field_stays_where_it_is_when_a_scene_is_recentred() -> None:
    """The checked point becomes the origin; the field's centre and the wheels move together."""
    moved = load_scene("four-wheel", at="1/4,0").recentred()
    assert moved.continuum is not None
    assert floats_of([moved.continuum.centre]) == [[-0.25, 0]]
    assert idealization(moved) is moved.continuum  # its wheels still follow it


def test_only_directions_matter(tmp_path: Path) -> None:
    """Numbers beyond the range of floats cancel: a field of constant size is the same for all multiples of A and s."""
    law = '[field]\nkind = "elliptic"\na = 1e350\nb = 2e350\nspeed = 1e350\n'
    box = '[body]\nshape = "rectangle"\nwidth = 2\nheight = 1\n'
    (found,) = predictions(scene_of(tmp_path, f"{law}{box}"))
    assert found.headings == predict(field(ELLIPTIC), rectangle(FIELD(1), FIELD(Fraction(1, 2)))).headings


def test_outward_wheels_drive_away() -> None:
    for found in predictions(load_scene("outward")):
        assert (found.field.kind, found.attracts, found.rotation) == ("outward", False, HeadingEffect.KEEPS)


def test_an_object_of_the_scene_is_used(tmp_path: Path) -> None:
    law = '[field]\nkind = "elliptic"\nb = 2\nspeed = "magnitude"\n'
    (found,) = predictions(scene_of(tmp_path, f'{law}[body]\nshape = "rectangle"\nwidth = 3\nheight = 1\n'))
    assert isinstance(found.footprint, PolygonShape)
    assert floats(found.footprint).tolist() == [[-1.5, -0.5], [1.5, -0.5], [1.5, 0.5], [-1.5, 0.5]]
    assert found.headings == (MomentFreeHeading(0.0, True), MomentFreeHeading(math.pi / 2, False))


def test_wheels_in_line_are_covered_by_a_disc_alone(tmp_path: Path) -> None:
    wheels = "[[wheel]]\nposition = [1, 0]\n[[wheel]]\nposition = [-1, 0]\n"
    (found,) = predictions(scene_of(tmp_path, "", wheels))
    assert isinstance(found.footprint, Disc)
    assert found.footprint.radius == 1


@pytest.mark.parametrize(
    ("rest", "wheels", "named"),
    [
        ('[field]\nkind = "squeeze"\n', "[grid]\nrows = 2\ncolumns = 2\n", "squeeze"),
        ('[field]\nkind = "expression"\nx = "-x"\ny = "-y"\n', "[ring]\ncount = 3\n", "expression"),
        ("", "[[wheel]]\nposition = [1, 0]\n[[wheel]]\nposition = [0, 1]\nheading = [1, 0]\n", r"wheel\[2\]"),
        ("", "[[wheel]]\nposition = [1, 0]\n[[wheel]]\nposition = [0, 1]\nspeed = 2\n", r"wheel\[2\]"),
        ('[field]\nkind = "elliptic"\na = 0\n', "[grid]\nrows = 2\ncolumns = 2\n", "vanishes at its centre"),
        ("", "[ring]\ncount = 4\nradius = 1e80\n", "length from"),
        ('[field]\nkind = "elliptic"\nb = 1e9\n', "[grid]\nrows = 2\ncolumns = 2\n", "ratio"),
    ],
)
def test_scenes_that_stand_for_no_field(rest: str, wheels: str, named: str, tmp_path: Path) -> None:
    with pytest.raises(NoIdealizationError, match=named):
        predictions(scene_of(tmp_path, rest, wheels))
