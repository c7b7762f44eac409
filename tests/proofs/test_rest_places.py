"""Places of rest beside what linear algebra finds of affine pieces, and their stability beside paths of SciPy."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import linprog

import nonsmooth as ns
from nonsmooth.proofs.findings import Translation
from nonsmooth.proofs.rest_places import RestKind, rest_places
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


def test_what_is_not_isolated_is_left() -> None:
    """A circle of equilibria."""
    result = stated("x*(1 - x**2 - y**2); y*(1 - x**2 - y**2)", radius=2).equilibria()
    assert result.exit_status == 3
    assert len(result.found.left) > 100
    assert all(abs(float(np.hypot(float(x), float(y))) - 1) < 0.05 for x, y in result.found.left)


@pytest.mark.parametrize(
    "rhs",
    [
        "sign(y); 0*x",  # both fields run along the border, in opposite directions
        "y*(1 + sign(y)) - 1 + sign(y); 0*y - 1 + sign(y)",  # one is zero along it
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
