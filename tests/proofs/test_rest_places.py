"""Places of rest beside what linear algebra finds of affine pieces, and their stability beside paths of SciPy."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from itertools import product

import numpy as np
import pytest
from flint import arb
from scipy.integrate import solve_ivp
from scipy.optimize import linprog

import nonsmooth as ns
from nonsmooth.proofs import decided_places as decided
from nonsmooth.proofs.findings import ContradictionError, Translation
from nonsmooth.proofs.rest_places import rest_places
from nonsmooth.proofs.rest_segments import RestKind, RestSegment
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
        (own,) = [one for one in found.places if np.abs(np.array([float(c) for c in one.place]) - x).max() < 1e-6]
        assert own.kind is kind
        if own.stability in (Translation.ASYMPTOTICALLY_STABLE, Translation.UNSTABLE):
            assert own.stability is _seen(pieces, x)


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
    assert [(own["exact"], own["where"][:12]) for own in result.rows()] == [("(0)", "on a surface")]
    assert not result.found.left


def test_irrational_equilibria_are_enclosed() -> None:
    """``x^3 = x + 1`` has no root that a formula of this program names."""
    (own,) = stated("x**3 - x - 1; x - y", radius=2).equilibria().facts()["places"]
    assert own["x"] == pytest.approx(1.324717957244746, abs=1e-12)
    assert own["error"] < 1e-12
    assert own["exact"] is None
    assert (own["shape"], own["stability"]) == ("saddle", "unstable")


def test_a_pseudo_equilibrium_in_three_states() -> None:
    """On z = 0 the sliding motion is ``x' = 1/2 - x, y' = x - y`` with ``z' = y - x/2 -+ 1`` on both sides."""
    rhs = "1/2 - x; x - y + 1/8*(1 + sign(z)) - 1/8 + (y - x/2)/8; y - x/2 - sign(z)"
    (own,) = stated(rhs, radius=2).equilibria().facts()["places"]
    assert [own["x"], own["y"], own["z"]] == pytest.approx([0.5, own["y"], 0], abs=1e-12)
    weight = own["y"] - own["x"] / 2  # sign(z) has this mean
    assert 0.5 - own["y"] + weight / 8 + weight / 8 == pytest.approx(0, abs=1e-12)
    assert (own["where"], own["surfaces"]) == ("on a surface that both fields lead to", "z = 0")
    assert own["stability"] == "asymptotically stable"


def test_where_the_linearization_says_nothing_theorems_are_asked() -> None:
    """Two fields that run along the surface (a fused focus), a cubic centre, and a corner."""
    (fused,) = stated("y - x/4; -x - y/4 - sign(x)", radius=1).equilibria().facts()["places"]
    assert fused["stability"] == "asymptotically stable"
    cubic = stated("-x**3; -y", radius=1).equilibria()  # where Krawczyk's operator isolates no zero
    assert [(own["stability"], own["exact"]) for own in cubic.rows()] == [("asymptotically stable", "(0, 0)")]
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


@pytest.mark.parametrize("seed", keep(10, range(150)))
def test_all_that_rests_of_singular_pieces_is_found(seed: int) -> None:
    """``x' = A x + b + c sgn(s)`` with a singular A in two or three states: places of most and least of any sum.

    What rests in a cell, and on ``s = 0``, where sgn is any number of [-1, 1], are polyhedra.
    """
    drawn = np.random.default_rng(seed)
    n = 2 + seed % 2
    a = drawn.integers(-2, 3, (n, n - 1)) @ drawn.integers(-2, 3, (n - 1, n)) / 2
    b, c = drawn.integers(-1, 2, n) / 2 * (seed % 3 == 0), drawn.integers(-2, 3, n) / 2 * (seed % 5 > 0)
    normal, offset = drawn.integers(-2, 3, n), drawn.integers(-1, 2) / 4
    normal[0] = normal[0] or 1
    states = "xyz"[:n]
    surface = " + ".join(f"({k})*{name}" for k, name in zip([*normal, offset], [*states, "1"], strict=True))
    rhs = [
        " + ".join(f"({k})*{name}" for k, name in zip([*row, p, q], [*states, "1", f"sign({surface})"], strict=True))
        for row, p, q in zip(a, b, c, strict=True)
    ]
    found = rest_places(ns.System(list(states), rhs, radius=2).system)
    ends = [[np.array(list(map(float, end))) for end in (own.start, own.end)] for own in found.stretches]
    known = ends + [[np.array(list(map(float, own.place)))] * 2 for own in found.places]

    def distance(x: np.ndarray, start: np.ndarray, end: np.ndarray) -> float:
        along = end - start
        share = np.clip((x - start) @ along / (along @ along or 1), 0, 1)
        return float(np.linalg.norm(start + share * along - x))

    cells = [((side, side), side) for side in (1, -1)]
    for limits, side in [*cells, ((-1, 1), 0)]:
        equal, zero = np.column_stack([a, c]), -b
        if not side:
            equal, zero = np.vstack([equal, [*normal, 0]]), np.append(zero, -offset)
        for _ in range(4):
            rest = linprog(
                [*drawn.standard_normal(n), 0],
                A_eq=equal,
                b_eq=zero,
                A_ub=[[*(-side * normal), 0]],
                b_ub=[side * offset],
                bounds=[(-2, 2)] * n + [limits],
            )
            if rest.status == 0:
                x = rest.x[:n]
                near = min((distance(x, *own) for own in known), default=np.inf)
                assert near < 1e-6 or found.left, (rhs, x)
    for start, end in ends:
        for share in (0.01, 0.5, 0.99):
            x = start + share * (end - start)
            value = normal @ x + offset
            signs = (np.sign(value),) * 2 if abs(value) > 1e-9 else (-1, 1)
            assert linprog([0], A_eq=c[:, None], b_eq=-a @ x - b, bounds=[signs]).status == 0


RESTS = [
    ("-x**3 + x**5; -y", 3),  # a zero that is not simple
    ("-sin(x)**3; -y", 1),
    ("-sign(x) + y/4; -sign(y) - x/4; -z", 1),  # two surfaces in space
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
    (own,) = found.places
    second = replace(own, place=(arb(1) / 8, arb(0)), exact=None)
    monkeypatch.setattr(decided, "rest_places", lambda _: replace(found, places=(own, second)))
    with pytest.raises(ContradictionError, match=r"as \(0.125, 0\), is certified to come to it; but what starts"):
        decided.decided_places(system)
    zero, end = system.field.zero, system.field.rational(Fraction(1, 8))
    segment = RestSegment((zero, zero), (end, zero), RestKind.CELL, (end, zero))
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
