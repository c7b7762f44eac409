"""Paths along, across and away from the zeros of norms, beside closed forms and beside SciPy on a boundary layer.

With ``sigma/sqrt(abs(sigma)^2 + e^2)`` in place of the unit vector the field is smooth, and its solutions tend to those
of the field that jumps: a theory that the followed paths do not share.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import log
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from nonsmooth.analysis.trajectories.result import TrajectoryError
from nonsmooth.proofs import measurements
from tests.plain import stated
from tests.thorough import keep

N = "sqrt(x**2 + y**2)"
LAYER = 1e-7  # e


def path_of(text: str, start: Sequence[float], until: float) -> dict[str, Any]:
    return dict(stated(text).simulate(start=tuple(start), until=until).facts())


def kinds(path: dict[str, Any]) -> list[tuple[str, Any]]:
    return [(event["kind"], event["t"]) for event in path["events"]]


def test_a_path_slides_with_the_equivalent_control_until_it_is_too_large() -> None:
    """``z' = 1 + z/4`` pushes along x with z/2: the unit control holds it until z = 2, at ``4 log(3/2)``."""
    path = path_of(f"1/2*z - x/{N}; -y/{N}; 1 + z/4", (0.3, 0.2, 0), 3)
    (slide, _), (leave, when) = kinds(path)
    assert (slide, leave) == ("slide", "leave")
    assert when == pytest.approx(4 * log(1.5), abs=1e-10)
    assert path["events"][1]["state"] == pytest.approx([0, 0, 2], abs=1e-10)
    assert path["events"][0]["surface"] == f"{N} = 0"
    later = 3 - when  # x'' = z'/2 with x = x' = 0 at first: exactly
    assert path["end"]["state"][0] == pytest.approx(3 * (4 * (np.exp(later / 4) - 1) - later), abs=2e-6)
    assert path["unique"]


def test_a_path_crosses_where_no_control_holds_it() -> None:
    path = path_of(f"3/2 - x/{N}; -y/{N}; -z", (-0.3, 0, 0), 3)
    assert kinds(path) == [("cross", pytest.approx(0.12, abs=1e-12))]
    assert path["end"]["state"] == pytest.approx([1.44, 0, 0], abs=1e-9)


@pytest.mark.parametrize(("text", "unique"), [(f"-x/{N}; -y/{N}; -z", True), (f"x/{N}; y/{N}; -z", None)])
def test_a_path_may_begin_on_the_zeros(text: str, *, unique: bool | None) -> None:
    path = path_of(text, (0, 0, 1), 2)
    assert kinds(path)[0] == ("slide", 0.0)
    assert path["end"]["state"] == pytest.approx([0, 0, np.exp(-2)], abs=1e-10)
    assert path["unique"] is unique


def test_the_root_of_one_square_is_an_absolute_value() -> None:
    norm = path_of("y - 2*x/sqrt(x**2); -x - y", (0.5, 0.4), 4)
    relay = path_of("y - 2*sign(x); -x - y", (0.5, 0.4), 4)
    assert norm["end"]["state"] == pytest.approx(relay["end"]["state"], abs=1e-9)
    assert kinds(norm) == [(kind, pytest.approx(t, abs=1e-9)) for kind, t in kinds(relay)]


def test_zeros_and_surfaces_are_kept_to_together() -> None:
    path = path_of(f"1/2*z - x/{N}; -y/{N}; 1 + z/4 - 2*sign(z - 1)", (0.3, 0.2, 0), 3)
    assert [kind for kind, _ in kinds(path)] == ["slide", "slide", "rest"]
    assert path["end"]["state"] == pytest.approx([0, 0, 1], abs=1e-10)
    two = "-x/sqrt(x**2 + y**2); -y/sqrt(x**2 + y**2); -z/sqrt(z**2 + w**2) + x; -2*w/sqrt(z**2 + w**2); -v"
    both = ns.System(list("xyzwv"), two.split("; ")).simulate(start=(0.3, 0.4, 0.5, 0.1, 1), until=2).facts()
    assert [event["kind"] for event in both["events"]] == ["slide", "slide"]
    assert both["events"][0]["t"] == pytest.approx(0.5, abs=1e-9)
    assert both["end"]["state"] == pytest.approx([0, 0, 0, 0, np.exp(-2)], abs=1e-9)
    assert both["unique"]


@pytest.mark.parametrize(
    ("text", "note"),
    [
        ("-x/{N} - sign(x); -y/{N}; -z; -w; -v", "hold those of the norm"),  # the surface holds the zeros
        ("-x/{N}; -y/{N}; -z/{M} - x/{N}*z/{M}; -w/{M}; -v", "products of unit vectors"),
    ],
)
def test_a_path_ends_where_the_theory_does(text: str, note: str) -> None:
    rhs = text.format(N=N, M="sqrt(z**2 + w**2)").split("; ")
    path = ns.System(list("xyzwv"), rhs).simulate(start=(0.3, 0.2, 0, 0, 0.5), until=3).facts()
    assert path["end"]["reason"] == "what follows is not known"
    assert note in path["end"]["note"]


def test_a_smoothed_path_has_a_layer_about_the_zeros() -> None:
    """Within the width u is ``sigma/width``: for ``z/2 < 1`` the path comes near ``x = width*z/2``."""
    text, width = f"1/2*z - x/{N}; -y/{N}; 1 + z/4", 1e-3
    end = stated(text).simulate(start=(0.3, 0.2, 0), until=1, method="smoothed", width=width).facts()["end"]
    z = 4 * (np.exp(0.25) - 1)
    assert end["state"] == pytest.approx([width * z / 2, 0, z], abs=2e-6)


def test_a_start_from_which_nothing_is_known_is_refused() -> None:
    system = ns.System(list("xyzw"), f"-x/{N}; -y/{N}; -z/sqrt(z**2 + w**2); 1 - z/sqrt(z**2 + w**2)".split("; "))
    with pytest.raises(TrajectoryError, match="not known which of them are left"):
        system.simulate(start=(0, 0, 0, 0), until=1)


def test_a_path_leaves_by_one_input_against_two_drifts() -> None:
    """``1/2 - u = r u, 1 - u/4 = r v`` with the unit vector (u, v)."""
    x, y, _ = path_of(f"1/2 - x/{N}; 1 - x/{N}/4; -z", (0, 0, 1), 1)["end"]["state"]
    size = np.hypot(x, y)
    assert [0.5 - x / size, 1 - x / size / 4] == pytest.approx([x, y], abs=1e-8)  # r is the size at time 1


def test_zeros_stand_where_they_are_stated() -> None:
    s1, s2 = "(x - 1 + vx)", "(y + 2 + 2*vy)"
    size = f"sqrt({s1}**2 + 4*{s2}**2)"
    system = ns.System(["x", "y", "vx", "vy"], ["vx", "vy", f"-2*{s1}/{size}", f"-2*{s2}/{size}"], at=(1, -2, 0, 0))
    path = system.simulate(start=(1.5, -1.5, 0, 0.25), until=6).facts()
    (slide,) = [event for event in path["events"] if event["kind"] == "slide"]
    x, y, vx, vy = path["end"]["state"]
    assert [x - 1 + vx, y + 2 + 2 * vy] == pytest.approx([0, 0], abs=1e-12)
    left = 6 - slide["t"]
    first_x, first_y, *_ = slide["state"]
    assert [x - 1, y + 2] == pytest.approx([(first_x - 1) * np.exp(-left), (first_y + 2) * np.exp(-left / 2)], abs=1e-9)


@pytest.mark.parametrize("seed", keep(3, [3, 11, 1, 19, 23, 2, 7, 8, 14, 24, 32, 33, 35, 37, 38]))
def test_random_unit_controls_are_limits_of_boundary_layers(seed: int) -> None:
    """Linear systems with unit control of some outputs: slides, crossings and departures."""
    drawn = np.random.default_rng(seed)
    n = int(drawn.integers(3, 6))
    k = int(drawn.integers(2, n))
    a = np.round(drawn.uniform(-1, 1, (n, n)) * 8) / 8 - np.eye(n) / 2
    c = np.round(drawn.uniform(-1, 1, n) * 4) / 8
    w = np.round(drawn.uniform(-1, 1, (k, n)) * 8) / 8
    p = np.round(drawn.uniform(-1, 1, (k, k)) * 8) / 8
    b = -2 * np.linalg.pinv(w) @ (p @ p.T + np.eye(k)) if drawn.random() < 0.7 else drawn.uniform(-2, 2, (n, k))
    b = np.round(b * 8) / 8
    drawn.uniform()
    start = drawn.integers(-8, 9, n) / 8

    names = [f"x{i}" for i in range(n)]
    outputs = [" + ".join(f"({c})*{name}" for c, name in zip(row, names, strict=True)) for row in w]
    size = f"sqrt({' + '.join(f'({own})**2' for own in outputs)})"
    texts = []
    for i in range(n):
        drift = " + ".join(f"({a[i, j]})*{names[j]}" for j in range(n))
        control = " + ".join(f"({b[i, j]})*({outputs[j]})/{size}" for j in range(k))
        texts.append(f"{drift} + ({c[i]}) + {control}")
    path = ns.System(names, texts).simulate(start=tuple(start.tolist()), until=4).facts()

    def layered(t: float, x: np.ndarray) -> np.ndarray:
        sigma = w @ x
        return a @ x + c + b @ sigma / np.sqrt(sigma @ sigma + LAYER**2)

    other = solve_ivp(layered, (0, 4), start, method="Radau", rtol=1e-8, atol=1e-10)
    left = any(event["kind"] == "leave" for event in path["events"])  # there the layer is late by more
    assert path["end"]["t"] == 4
    assert path["end"]["state"] == pytest.approx(other.y[:, -1], abs=1e-4 if left else 2e-6)


def test_measurements_leave_out_paths_without_a_reference(monkeypatch: pytest.MonkeyPatch) -> None:
    """A norm that is zero on a line: no reference at 60 digits slides along it."""
    system = stated("y - 2*(x + y)/sqrt((x + y)**2); -x - y")
    assert "norm" in system.precision(study="paths", runs=1).to_dict()["studies"][0]["left_out"]
    monkeypatch.setattr(measurements, "POWERS", ())  # verdicts in other units, which take seconds
    monkeypatch.setattr(measurements, "RATIOS", {})
    rows = [row for row in system.stress().rows() if row["case"] in ("scales", "starts", "switches")]
    assert [row["verdict"] for row in rows] == ["refused"] * 3


@pytest.mark.parametrize("seed", keep(1, [9, 5, 0, 2, 6, 8, 11]))
def test_two_unit_controls_and_a_relay_are_limits_of_boundary_layers(seed: int) -> None:
    """Zeros of two norms and a surface, met one after the other, kept to together and left."""
    drawn = np.random.default_rng(1000 + seed)
    a = np.round(drawn.uniform(-1, 1, (5, 5)) * 8) / 8 - np.eye(5) / 2
    c = np.round(drawn.uniform(-1, 1, 5) * 4) / 8
    w = np.vstack([np.round(drawn.uniform(-1, 1, (2, 5)) * 8) / 8 for _ in range(2)])
    relay = np.round(drawn.uniform(-1, 1, 5) * 8) / 8
    gains = np.repeat(np.round(drawn.uniform(0.5, 2, 2) * 4) / 4, 2)
    b = -np.round(np.linalg.pinv(w) * 16) / 8 * gains
    jump = np.round(drawn.uniform(-1, 1, 5) * 4) / 8
    start = drawn.integers(-8, 9, 5) / 8

    names = list("abcde")
    *outputs, switch = [" + ".join(f"({v})*{name}" for v, name in zip(own, names, strict=True)) for own in [*w, relay]]
    sizes = [f"sqrt(({outputs[j]})**2 + ({outputs[j + 1]})**2)" for j in (0, 2)]
    texts = []
    for i in range(5):
        drift = " + ".join(f"({a[i, j]})*{names[j]}" for j in range(5))
        control = " + ".join(f"({b[i, j]})*({outputs[j]})/{sizes[j // 2]}" for j in range(4))
        texts.append(f"{drift} + ({c[i]}) + {control} + ({jump[i]})*sign({switch})")
    path = ns.System(names, texts).simulate(start=tuple(start.tolist()), until=3).facts()

    def layered(t: float, x: np.ndarray) -> np.ndarray:
        first, second = np.split(w @ x, 2)
        units = [own / np.sqrt(own @ own + LAYER**2) for own in (first, second)]
        return a @ x + c + b @ np.concatenate(units) + jump * np.tanh(relay @ x / LAYER)

    other = solve_ivp(layered, (0, 3), start, method="Radau", rtol=1e-8, atol=1e-10)
    assert path["end"]["t"] == 3
    assert path["end"]["state"] == pytest.approx(other.y[:, -1], abs=1e-5)
