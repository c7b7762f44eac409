"""Places of rest beside what linear algebra finds of affine pieces, and their stability beside paths of SciPy."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from fractions import Fraction
from itertools import combinations, product

import numpy as np
import pytest
from flint import arb
from scipy.integrate import solve_ivp
from scipy.optimize import linprog, nnls

import nonsmooth as ns
from nonsmooth.proofs import decided_places as decided
from nonsmooth.proofs.findings import ContradictionError, Translation
from nonsmooth.proofs.rest_places import rest_places
from nonsmooth.proofs.rest_polytopes import RestKind, RestPolytope
from tests.plain import stated
from tests.thorough import keep

LINES = ("x + 2*y - 1/2", "x - y + 1/4")
NORMALS, OFFSETS = np.array([[1.0, 2.0], [1.0, -1.0]]), np.array([-0.5, 0.25])


class Pieces:
    """``x' = A x + b + c1 sgn(s1) + c2 sgn(s2) + d sgn(s1) sgn(s2)`` with whole eighths, s1 and s2 affine."""

    def __init__(self, seed: int) -> None:
        drawn = np.random.default_rng(seed)
        self.a, self.b, self.c1, self.c2, self.d = (drawn.integers(-8, 9, shape) / 8 for shape in ((2, 2), 2, 2, 2, 2))
        if seed % 2:
            self.d = np.zeros(2)

    def text(self) -> str:
        sides = []
        for k in range(2):
            s1, s2 = (f"sign({line})" for line in LINES)
            sides.append(
                f"({self.a[k, 0]})*x + ({self.a[k, 1]})*y + ({self.b[k]}) + ({self.c1[k]})*{s1} + ({self.c2[k]})*{s2}"
                f" + ({self.d[k]})*{s1}*{s2}"
            )
        return "; ".join(sides)

    def field(self, p: int, q: int, x: np.ndarray) -> np.ndarray:
        return self.a @ x + self.b + p * self.c1 + q * self.c2 + p * q * self.d

    def smoothed(self, t: float, x: np.ndarray) -> np.ndarray:
        p, q = np.tanh((NORMALS @ x + OFFSETS) / 1e-6)
        return self.field(p, q, x)

    def places(self) -> Iterator[tuple[str, np.ndarray]]:
        """Everything that rests within 2 of the origin, by solving linear and quadratic equations."""
        for p, q in product((1, -1), repeat=2):
            x = np.linalg.solve(self.a, self.field(p, q, np.zeros(2)) * -1)
            room = ((NORMALS @ x + OFFSETS) * [p, q]).min()
            if room > -1e-9:
                yield "cell" if room > 1e-9 else "boundary", x
        for k, other in ((0, 1), (1, 0)):
            start = -NORMALS[k] * OFFSETS[k] / (NORMALS[k] @ NORMALS[k])
            along = np.array([-NORMALS[k][1], NORMALS[k][0]])
            for side in (1, -1):
                both = [[(p, side), (side, p)][k] for p in (1, -1)]
                crossed = [
                    np.linalg.det([self.field(*signs, start + t * along) for signs in both]) for t in (-1.0, 0.0, 1.0)
                ]
                for t in np.roots(np.polyfit([-1, 0, 1], crossed, 2)):
                    x = start + t.real * along
                    f, g = (self.field(*signs, x) for signs in both)
                    first, second = NORMALS[k] @ f, NORMALS[k] @ g
                    if abs(t.imag) > 1e-9 or (NORMALS @ x + OFFSETS)[other] * side < 1e-9 or f @ g > 0:
                        continue
                    if abs(first) + abs(second) < 1e-9:  # both run along the line, in opposite directions
                        yield "boundary", x
                    elif first * second < 0:
                        yield ("sliding" if first < 0 else "repelling"), x
        corner = np.linalg.solve(NORMALS, -OFFSETS)
        fields = np.array([self.field(p, q, corner) for p, q in product((1, -1), repeat=2)])
        if linprog(np.zeros(4), A_eq=[*fields.T, np.ones(4)], b_eq=[0, 0, 1]).status == 0:
            yield "corner", corner


KINDS = {
    "cell": RestKind.CELL,
    "sliding": RestKind.SLIDING,
    "repelling": RestKind.REPELLING,
    "boundary": RestKind.BOUNDARY,
    "corner": RestKind.CORNER,
}


@pytest.mark.parametrize("seed", keep(8, range(120)))
def test_affine_pieces_rest_where_linear_algebra_says(seed: int) -> None:
    pieces = Pieces(seed)
    if abs(np.linalg.det(pieces.a)) < 0.05:
        pieces.a = pieces.a + np.eye(2)
    found = rest_places(stated(pieces.text(), radius=2).system)
    expected = [(KINDS[kind], x) for kind, x in pieces.places() if np.abs(x).max() < 2 + 1e-9]
    assert not found.left
    assert not found.stretches
    assert len(found.places) == len(expected)
    for kind, x in expected:
        (place,) = [one for one in found.places if np.abs(np.array([float(c) for c in one.place]) - x).max() < 1e-6]
        assert place.kind is kind
        if place.stability in (Translation.ASYMPTOTICALLY_STABLE, Translation.UNSTABLE):
            assert place.stability is _seen(pieces, x)


def _seen(pieces: Pieces, x: np.ndarray) -> Translation:
    """Whether starts around a place come nearer, by a field with steep functions in place of signs."""
    size, ends = 1e-3, []
    for angle in np.linspace(0, 2 * np.pi, 7)[:-1]:
        start = x + size * np.array([np.cos(angle), np.sin(angle)])
        far = lambda t, y: np.abs(y - x).max() - 50 * size  # noqa: E731
        far.terminal = True  # type: ignore[attr-defined]
        path = solve_ivp(pieces.smoothed, (0, 400), start, method="LSODA", rtol=1e-8, atol=1e-11, events=far)
        ends.append(np.abs(path.y[:, -1] - x).max())
    return Translation.ASYMPTOTICALLY_STABLE if max(ends) < size / 3 else Translation.UNSTABLE


def test_dry_friction_rests_on_a_stretch() -> None:
    found = stated("y; -x - sign(y)", radius=2).equilibria().facts()
    assert found["places"] == []
    assert [(part["from"], part["to"], part["kind"]) for part in found["stretches"]] == [([-1, 0], [1, 0], "sliding")]
    assert found["left"] == []


def test_a_pendulum_with_dry_friction_rests_near_both_verticals() -> None:
    """``abs(sin x) <= 1/4``."""
    found = stated("y; -sin(x) - y/5 - sign(y)/4", radius=4).equilibria().facts()
    ends = sorted(x for part in found["stretches"] for x, _ in (part["from"], part["to"]))
    near = np.arcsin(0.25)
    assert ends == pytest.approx([-np.pi - near, near - np.pi, -near, near, np.pi - near, np.pi + near], abs=1e-9)
    assert not found["left"]


def test_a_boundary_equilibrium_beside_a_sine() -> None:
    """One side is zero at the surface: ``sin 0`` is exact."""
    result = stated("sin(x)/2 - x + (1 - sign(x))/4", radius=1).equilibria()
    assert [(row["exact"], row["where"][:12]) for row in result.rows()] == [("(0)", "on a surface")]
    assert not result.found.left


def test_irrational_equilibria_are_enclosed() -> None:
    """``x^3 = x + 1`` has no root that a formula of this program names."""
    (place,) = stated("x**3 - x - 1; x - y", radius=2).equilibria().facts()["places"]
    assert place["x"] == pytest.approx(1.324717957244746, abs=1e-12)
    assert place["error"] < 1e-12
    assert place["exact"] is None
    assert (place["shape"], place["stability"]) == ("saddle", "unstable")


def test_a_pseudo_equilibrium_in_three_states() -> None:
    """On z = 0 the sliding motion is ``x' = 1/2 - x, y' = x - y`` with ``z' = y - x/2 -+ 1`` on both sides."""
    rhs = "1/2 - x; x - y + 1/8*(1 + sign(z)) - 1/8 + (y - x/2)/8; y - x/2 - sign(z)"
    (place,) = stated(rhs, radius=2).equilibria().facts()["places"]
    assert [place["x"], place["y"], place["z"]] == pytest.approx([0.5, place["y"], 0], abs=1e-12)
    weight = place["y"] - place["x"] / 2  # sign(z) has this mean
    assert 0.5 - place["y"] + weight / 8 + weight / 8 == pytest.approx(0, abs=1e-12)
    assert (place["where"], place["surfaces"]) == ("on a surface that both fields lead to", "z = 0")
    assert place["stability"] == "asymptotically stable"


def test_where_the_linearization_says_nothing_theorems_are_asked() -> None:
    """Two fields that run along the surface (a fused focus), a cubic centre, and a corner."""
    (fused,) = stated("y - x/4; -x - y/4 - sign(x)", radius=1).equilibria().facts()["places"]
    assert fused["stability"] == "asymptotically stable"
    cubic = stated("-x**3; -y", radius=1).equilibria()  # where Krawczyk's operator isolates no zero
    assert [(row["stability"], row["exact"]) for row in cubic.rows()] == [("asymptotically stable", "(0, 0)")]
    assert all(np.abs([float(x) for x in box]).max() < 1e-4 for box in cubic.found.left)
    (corner,) = stated("1/2 - sign(x); x/8 - sign(y)/3", radius=1).equilibria().facts()["places"]
    assert corner["where"] == "where surfaces meet"
    assert corner["stability"] == "asymptotically stable"


def test_theorems_are_asked_on_the_border_of_the_cube_too() -> None:
    """The bend is at the place, so its linearization says nothing."""
    (row,) = stated("-x - Abs(x + 1/2)/2 - 1/2; -y", radius="1/2").equilibria().rows()
    assert (row["exact"], row["stability"]) == ("(-1/2, 0)", "asymptotically stable")


def test_what_is_not_isolated_is_left() -> None:
    """A circle of equilibria."""
    result = stated("x*(1 - x**2 - y**2); y*(1 - x**2 - y**2)", radius=2).equilibria()
    assert result.exit_status == 3
    assert len(result.found.left) > 100
    assert all(abs(float(np.hypot(float(x), float(y))) - 1) < 0.05 for x, y in result.found.left)


SEGMENTS = [
    ("xy", "y; -y - relu(x - 1/2) + relu(-x - 1/2)", "cell", [(-0.5, 0), (0.5, 0)]),  # a dead zone
    ("xvu", "v; -v + relu(u - 1/2) - relu(-u - 1/2); -u - x - v", "cell", [(-0.5, 0, 0.5), (0.5, 0, -0.5)]),
    (
        "xy",
        "y*(1 + sign(y)) - 1 + sign(y); 0*y - 1 + sign(y)",
        "boundary",
        [(-2, 0), (2, 0)],
    ),  # one field is zero there
    ("xy", "sign(y); 0*x", "boundary", [(-2, 0), (2, 0)]),  # both fields run along the border, in opposite directions
    ("xyz", "y; z; -2*sign(x) - 3*sign(y) - z", "boundary", [(-2, 0, 0), (2, 0, 0)]),
    ("xy", "y - x; x - y", "cell", [(-2, -2), (2, 2)]),
    ("xvw", "v; -x - w/3 - v - sign(v); -w", "sliding", [(-1, 0, 0), (1, 0, 0)]),  # dry friction in space
    ("xvw", "v; -x - w/3 - v + sign(v); -w", "repelling", [(-1, 0, 0), (1, 0, 0)]),
    (
        "pqrs",
        "q; -sat(2*p + 3*q) + r/5; s; -r - 2*s - sign(s)/4",
        "sliding",
        [(-0.025, 0, -0.25, 0), (0.025, 0, 0.25, 0)],
    ),
]


@pytest.mark.parametrize(("states", "rhs", "kind", "ends"), SEGMENTS)
def test_lines_of_equilibria_are_segments(states: str, rhs: str, kind: str, ends: list[tuple[float, ...]]) -> None:
    """And nothing else is left, at their ends neither."""
    result = ns.System(list(states), rhs.split("; "), radius=2).equilibria()
    (segment,) = result.facts()["stretches"]
    assert segment["kind"] == kind
    assert [tuple(segment["from"]), tuple(segment["to"])] == ends
    assert (result.exit_status, result.found.places) == (0, ())


def sum_of(factors: Iterable[object], names: Iterable[str]) -> str:
    return " + ".join(f"({k})*{name}" for k, name in zip(factors, names, strict=True))


def hull_distance(x: np.ndarray, corners: np.ndarray) -> float:
    matrix = np.vstack([corners.T, np.full(len(corners), 1e3)])
    return float(nnls(matrix, [*x, 1e3])[1])


@pytest.mark.parametrize("seed", keep(10, range(200)))
def test_all_that_rests_of_singular_pieces_is_found(seed: int) -> None:
    """``x' = A x + b + C sgn(S x + s)`` with a singular A: places of most and least of any sum, in two to four states.

    What rests where some signs are 1 or -1, and others any number of [-1, 1], are polyhedra.
    """
    drawn = np.random.default_rng(seed)
    n, rows = 2 + seed % 3, 1 + seed % 2
    rank = max(1, n - 1 - seed % 4 // 3)
    a = drawn.integers(-2, 3, (n, rank)) @ drawn.integers(-2, 3, (rank, n)) / 2
    b, c = drawn.integers(-1, 2, n) / 2 * (seed % 3 == 0), drawn.integers(-2, 3, (n, rows)) / 2 * (seed % 5 > 0)
    normals, offsets = drawn.integers(-2, 3, (rows, n)), drawn.integers(-1, 2, rows) / 4
    for k in range(rows):
        normals[k, k] = normals[k, k] or 1
    states = "xyzu"[:n]
    surfaces = [sum_of([*row, s], [*states, "1"]) for row, s in zip(normals, offsets, strict=True)]
    names = [*states, "1", *(f"sign({surface})" for surface in surfaces)]
    rhs = [sum_of([*row, p, *q], names) for row, p, q in zip(a, b, c, strict=True)]
    found = rest_places(ns.System(list(states), rhs, radius=2).system)
    assert not found.left
    hulls = [np.array([list(map(float, corner)) for corner in stretch.corners]) for stretch in found.stretches]
    hulls += [np.array([list(map(float, place.place))]) for place in found.places]

    for sides in product((1, -1, 0), repeat=rows):
        limits = [(side, side) if side else (-1, 1) for side in sides]
        on, beside = [k for k in range(rows) if not sides[k]], [k for k in range(rows) if sides[k]]
        for _ in range(4):
            rest = linprog(
                [*drawn.standard_normal(n), *[0] * rows],
                A_eq=np.vstack([np.hstack([a, c]), *([*normals[k], *[0] * rows] for k in on)]),
                b_eq=[*-b, *(-offsets[k] for k in on)],
                A_ub=[[*(-sides[k] * normals[k]), *[0] * rows] for k in beside] or None,
                b_ub=[sides[k] * offsets[k] for k in beside] or None,
                bounds=[(-2, 2)] * n + limits,
            )
            if rest.status == 0:
                x = rest.x[:n]
                near = min((hull_distance(x, hull) for hull in hulls), default=np.inf)
                assert near < 1e-6, (rhs, x)
    for corners in hulls[: len(found.stretches)]:
        for weights in drawn.dirichlet(np.ones(len(corners)), 3):
            x = weights @ corners
            values = normals @ x + offsets
            signs = [(np.sign(value),) * 2 if abs(value) > 1e-9 else (-1, 1) for value in values]
            rest = a @ x + b
            if rows == 1 or np.linalg.matrix_rank(normals) == rows:
                assert linprog([0] * rows, A_eq=c, b_eq=-rest, bounds=signs).status == 0, (rhs, x)


def test_fields_without_a_cell_hold_no_place(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where x and y are zero so is their sum; where they are positive it is not negative, whatever stands there."""
    monkeypatch.setattr("nonsmooth.proofs.boxes.all_zeros.MOST_BOXES", 300)
    monkeypatch.setattr("nonsmooth.proofs.rest_places.MOST_BOXES", 300)
    rhs = ["-sign(x)", "-y", "1 - (1 + sign(x))*(1 + sign(y))*(1 - sign(x + y))/4"]
    found = rest_places(ns.System(["x", "y", "z"], rhs, radius=1).system)
    assert not found.places
    assert not found.stretches


@pytest.mark.parametrize("seed", keep(4, range(100)))
def test_fields_of_cells_alone_have_a_say(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """On planes that meet in one line, some signs of which no place has; what rests is told by values close by."""
    monkeypatch.setattr("nonsmooth.proofs.boxes.all_zeros.MOST_BOXES", 100)
    monkeypatch.setattr("nonsmooth.proofs.rest_places.MOST_BOXES", 100)
    drawn = np.random.default_rng(seed)
    n = 2 + seed % 2
    planes, lines = np.array([[1, 0, 0], [0, 1, 0], [1, 1, 0]])[:, :n], ("x", "y", "x + y")
    a, b = drawn.integers(-2, 3, (n, n)) / 2 * (drawn.random((n, n)) < 0.5), drawn.integers(-1, 2, n) / 2
    chosen = [indices for size in (1, 2, 3) for indices in combinations(range(3), size)]
    jumps = drawn.integers(-2, 3, (n, len(chosen))) / 4 * (drawn.random((n, len(chosen))) < 0.5)
    products = ["*".join(f"sign({lines[k]})" for k in indices) for indices in chosen]
    rhs = [sum_of([*row, c, *jump], [*"xyz"[:n], "1", *products]) for row, c, jump in zip(a, b, jumps, strict=True)]
    found = rest_places(ns.System(list("xyz"[:n]), rhs, radius=1).system)

    def may_rest(place: np.ndarray) -> bool:
        near = place + drawn.uniform(-1e-7, 1e-7, (400, n))
        signs = np.sign(near @ planes.T)
        values = (
            near @ a.T
            + b
            + np.stack([np.prod(signs[:, list(indices)], axis=1) for indices in chosen], axis=1) @ jumps.T
        )
        values = np.unique(np.round(values, 5), axis=0)
        matrix = np.vstack([values.T, np.full(len(values), 10.0)])
        return bool(nnls(matrix, [*np.zeros(n), 10.0])[1] < 2e-5)

    hulls = [np.array([list(map(float, corner)) for corner in stretch.corners]) for stretch in found.stretches]
    hulls += [np.array([list(map(float, place.place))]) for place in found.places]
    for corners in hulls:
        assert all(may_rest(weights @ corners) for weights in drawn.dirichlet(np.ones(len(corners)), 3)), rhs
    boxes = [
        (np.array([float(x.lower()) for x in box]), np.array([float(x.upper()) for x in box])) for box in found.left
    ]
    for share in drawn.uniform(-0.9, 0.9, (12, n)):
        for normal in planes:
            place = share - (share @ normal) / (normal @ normal) * normal
            for point in (place, place * (np.arange(n) > 1)):
                if may_rest(point) and np.abs(point).max() <= 1:
                    is_known = any(hull_distance(point, corners) < 1e-4 for corners in hulls)
                    assert is_known or any(
                        np.all((low <= point + 1e-6) & (point - 1e-6 <= high)) for low, high in boxes
                    )


@pytest.mark.parametrize(
    "rhs",
    [
        ["-sign(x) - sign(x + y)/2", "-sign(y) - sign(x + y)/2"],
        # 0 is a mixture of fields on both sides of each pair of lines alone
        [
            "-x - sign(x)*sign(x + y)/2 + sign(y)*sign(x + y)/4 + sign(x)*sign(y)*sign(x + y)/2",
            "2*x - 2*y + 1/2 - sign(x)*sign(y)/4 - sign(x)*sign(x + y)/4",
        ],
    ],
)
def test_a_corner_of_three_lines_is_found(rhs: list[str]) -> None:
    """All cells around it have a say, and no others."""
    places = rest_places(ns.System(["x", "y"], rhs, radius=1).system).places
    (corner,) = (place for place in places if place.exact is not None and not any(place.exact))
    assert (corner.kind, len(corner.surfaces)) == (RestKind.CORNER, 3)


def test_dry_friction_on_two_masses_holds_a_polygon() -> None:
    """``|2 q - p| <= 1, |q - 2 p| <= 2``; in the plane dead zones of both states hold one in a cell."""
    rhs = ["v", "w", "-2*q + p - sign(v)", "q - 2*p - 2*sign(w)"]
    result = ns.System(["q", "p", "v", "w"], rhs, radius=2).equilibria()
    assert result.exit_status == 0
    (polytope,) = result.facts()["polytopes"]
    assert [tuple(corner[:2]) for corner in polytope["corners"]] == [(-4 / 3, -5 / 3), (0, -1), (4 / 3, 5 / 3), (0, 1)]
    dead = [f"(Abs({name} + 1) - Abs({name} - 1))/2 - {name}" for name in "xy"]
    (polytope,) = ns.System(["x", "y"], dead, radius=2).equilibria().facts()["polytopes"]
    assert list(map(tuple, polytope["corners"])) == [(-1, -1), (-1, 1), (1, 1), (1, -1)]


RESTS = [
    ("-x**3 + x**5; -y", 3),  # a zero that is not simple
    ("-sin(x)**3; -y", 1),
    ("-sign(x) + y/4; -sign(y) - x/4; -z - z**3", 1),  # two surfaces in space
    ("y; -sin(x)**3 - y", 1),
]


@pytest.mark.parametrize(("rhs", "places"), keep(3, RESTS))
def test_nothing_else_rests_where_a_place_attracts(rhs: str, places: int) -> None:
    """Boxes in which the search cannot tell are dropped there; on their own they are left."""
    system = stated(rhs, radius=2)
    assert rest_places(system.system).left
    result = system.equilibria()
    assert (result.exit_status, len(result.found.places)) == (0, places)


def test_a_second_place_where_one_attracts_is_a_contradiction(monkeypatch: pytest.MonkeyPatch) -> None:
    system = stated("-x**3; -y").system
    found = rest_places(system)
    (first,) = found.places
    second = replace(first, place=(arb(1) / 8, arb(0)), exact=None)
    monkeypatch.setattr(decided, "rest_places", lambda _: replace(found, places=(first, second)))
    with pytest.raises(ContradictionError, match=r"as \(0.125, 0\), is certified to come to it; but what starts"):
        decided.decided_places(system)
    zero, end = system.field.zero, system.field.rational(Fraction(1, 8))
    segment = RestPolytope(((zero, zero), (end, zero)), RestKind.CELL, along=(end, zero))
    monkeypatch.setattr(decided, "rest_places", lambda _: replace(found, stretches=(segment,)))
    with pytest.raises(ContradictionError):
        decided.decided_places(system)


@pytest.mark.parametrize(
    "rhs",
    [
        "y; -x - sign(y)*(3 + sign(x**2 + y**2 - 4))",  # dry friction that a curve parts
    ],
)
def test_stretches_that_no_border_tells_are_left(rhs: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("nonsmooth.proofs.boxes.all_zeros.MOST_BOXES", 1000)
    found = stated(rhs, radius=3).equilibria().found
    assert not found.stretches
    assert any(abs(float(y)) < 0.05 and abs(float(x)) < 1 for x, y in found.left)


@pytest.mark.parametrize(
    ("rhs", "said"),
    [
        ("-x/sqrt(x**2 + y**2); -y", "without norms"),
        ("-x/(1/4 - x); -y", "not to vanish"),  # beyond x = 1/4 the field without fractions goes the other way
        ("-sqrt(Abs(x))*sign(x); -y", r"without sqrt\(Abs"),
        ("; ".join(["-x" + "".join(f" - sign(x - {k}/10)/9" for k in range(7)), "-y"]), "at most 6 switching"),
    ],
)
def test_others_are_refused(rhs: str, said: str) -> None:
    with pytest.raises(ns.SceneError, match=said):
        stated(rhs, radius=2).equilibria()
