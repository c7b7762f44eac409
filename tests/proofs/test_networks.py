"""Networks in plain systems: what is written out is the network, and verdicts agree with paths of it."""

from __future__ import annotations

import json
from fractions import Fraction
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.proofs.verdicts import Translation
from nonsmooth.symbolic.files.system_file import build_system, load_system
from nonsmooth.symbolic.scene_error import SceneError
from nonsmooth.symbolic.switched_system import SwitchedSystem
from tests.thorough import keep

SCENE = """
[system]
states = ["x", "v"]
rhs = ["v", "-x + u(x, v)"]

[[network]]
name = "u"
file = "{}"
"""


def random_layers(seed: int, units: int, *, biased: bool) -> list[tuple[np.ndarray, np.ndarray]]:
    """Weights of a hidden layer and of one output that is zero at the origin, as decimals of two digits."""
    rng = np.random.default_rng(seed)
    inner, outer = np.round(rng.normal(size=(units, 2)), 2), np.round(rng.normal(size=(1, units)), 2)
    biases = np.round(rng.normal(size=units) / 2, 2) * biased
    return [(inner, biases), (outer, -(outer @ np.maximum(biases, 0)))]


def tables(layers: list[tuple[np.ndarray, np.ndarray]]) -> list[dict[str, Any]]:
    """The layers as a file holds them: four digits after the point are exact."""
    return [
        {"weights": [[f"{w:.4f}" for w in row] for row in weights], "biases": [f"{b:.4f}" for b in biases]}
        for weights, biases in layers
    ]


def value(layers: list[tuple[np.ndarray, np.ndarray]], x: Any) -> Any:
    for weights, biases in layers[:-1]:
        x = np.maximum(weights @ x + biases, 0)
    return layers[-1][0] @ x + layers[-1][1]


def loop(layers: list[tuple[np.ndarray, np.ndarray]], v: str = "-2*x - 3*v/2 + u(x, v)") -> SwitchedSystem:
    document = {"system": {"states": ["x", "v"], "rhs": ["v", v]}, "network": [{"name": "u", "layers": tables(layers)}]}
    return build_system(document, "t", Path("t.toml"))


def largest_end(layers: list[tuple[np.ndarray, np.ndarray]], size: float, until: float) -> float:
    """Where paths from a small circle end, over its radius, by a solver that steps over the kinks."""

    def field(t: float, x: np.ndarray) -> np.ndarray:
        return np.array([x[1], -2 * x[0] - 1.5 * x[1] + float(value(layers, x)[0])])

    ends = []
    for angle in np.linspace(0, 2 * np.pi, 12, endpoint=False):
        start = size * np.array([np.cos(angle), np.sin(angle)])
        found = solve_ivp(field, (0, until), start, rtol=1e-9, atol=1e-13, events=_far(size))
        ends.append(np.hypot(*found.y[:, -1]) / size)
    return max(ends)


def _far(size: float) -> Any:
    def gone(t: float, x: np.ndarray) -> float:
        return float(np.hypot(*x) - 50 * size)

    gone.terminal = True  # type: ignore[attr-defined]
    return gone


@pytest.mark.parametrize("units", keep(1, [4, 16, 8]))
@pytest.mark.parametrize("seed", range(6))
def test_verdicts_agree_with_paths(seed: int, units: int) -> None:
    layers = random_layers(100 * units + seed, units, biased=bool(seed % 2))
    result = decide_system(loop(layers))
    assert result.check()
    last = largest_end(layers, 1e-3, 40.0)
    if result.verdict is Translation.ASYMPTOTICALLY_STABLE:
        assert last < 0.5
    elif result.verdict is Translation.UNSTABLE:
        assert last > 2
    else:
        pytest.fail(f"{result.verdict}: {result.reason}")


@pytest.mark.parametrize("units", [2, 5])
def test_what_is_written_out_is_the_network(units: int) -> None:
    first = random_layers(units, units, biased=True)[0]
    rng = np.random.default_rng(3)
    middle = (np.round(rng.normal(size=(3, units)), 2), np.round(rng.normal(size=3), 2))
    last = (np.round(rng.normal(size=(1, 3)), 2), np.array([0.25]))
    layers = [first, middle, last]
    system = loop(layers, "u(2*x - v, v)")
    for x, v in rng.normal(size=(10, 2)):
        place = [Fraction(x), Fraction(v)]
        piece = system.velocity(lambda surface, place=place: surface(place).sign())[1]  # type: ignore[misc]
        assert float(piece(place)) == pytest.approx(float(value(layers, np.array([2 * x - v, v]))[0]), abs=1e-9)


def test_several_outputs_and_calls_inside_calls() -> None:
    layers = [{"weights": [[1], [-1]], "biases": [0, 0]}, {"weights": [[1, 1], [1, -1]], "biases": [0, 0]}]
    document = {
        "system": {"states": ["x", "y"], "rhs": ["-f_2(f_2(x)) - k*f_1(y)", "-y"], "parameters": {"k": "1/2"}},
        "network": [{"name": "f", "layers": layers}],
    }
    system = build_system(document, "t", Path("t.toml"))
    for place in ([Fraction(2), Fraction(3)], [Fraction(-2), Fraction(-3)]):
        piece = system.velocity(lambda surface, place=place: surface(place).sign())[0]  # type: ignore[misc]
        assert float(piece(place)) == -place[0] - abs(place[1]) / 2


def test_a_network_of_a_file(tmp_path: Path) -> None:
    layers = random_layers(7, 4, biased=False)
    (tmp_path / "net.json").write_text(json.dumps({"layers": tables(layers)}))
    (tmp_path / "loop.toml").write_text(SCENE.format("net.json"))
    system = load_system(tmp_path / "loop.toml")
    assert [side.text for side in system.rhs] == [side.text for side in loop(layers, "-x + u(x, v)").rhs]


LAYER = {"weights": [[1, 1]], "biases": [0]}
WIDE = {"weights": [[1, 1]] * 17, "biases": [0] * 17}
BAD: list[tuple[Any, str]] = [
    ("no json", "JSON"),
    ({"layers": []}, "list of layers"),
    ({"layers": [LAYER, LAYER]}, "1 columns of weights in layer 2"),
    ({"layers": [WIDE, {"weights": [[1] * 17], "biases": [0]}]}, "at most 16 ReLU units"),
    ({"layers": [LAYER] * 5}, "1 to 4 layers"),
    ({"layers": [{"weights": [[1, 2], [1]], "biases": [0, 0]}]}, "rows of weights of one length"),
    ({"layers": [{"weights": [[1, 1]], "biases": [0, 0]}]}, "a row of weights for each bias"),
    ({"layers": [{"weights": [[1, "sqrt(2)"]], "biases": [0]}]}, "rational"),
    ({"layers": [{"weights": [[1, None]], "biases": [0]}]}, "a number"),
    ({"layers": [{"weights": [[1, 1, 1]], "biases": [0]}]}, "3 arguments of u"),
    ({"layers": [LAYER], "name": "u"}, "layers"),
]


@pytest.mark.parametrize(("content", "said"), BAD)
def test_what_is_no_network_is_refused_in_one_line(tmp_path: Path, content: Any, said: str) -> None:
    (tmp_path / "net.json").write_text(content if isinstance(content, str) else json.dumps(content))
    (tmp_path / "loop.toml").write_text(SCENE.format("net.json"))
    with pytest.raises(SceneError) as raised:
        load_system(tmp_path / "loop.toml")
    assert said in str(raised.value)
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize("name", ["../net.json", "/etc/passwd", "none.json", "net.txt", "."])
def test_only_networks_beside_the_scene_are_read(tmp_path: Path, name: str) -> None:
    folder = tmp_path / "scene"
    folder.mkdir()
    (tmp_path / "net.json").write_text(json.dumps({"layers": [LAYER]}))
    (folder / "loop.toml").write_text(SCENE.format(name))
    with pytest.raises(SceneError, match="network"):
        load_system(folder / "loop.toml")


@pytest.mark.parametrize("name", ["x", "relu", "1u"])
def test_names_that_mean_something_else_are_refused(name: str) -> None:
    document = {"system": {"states": ["x"], "rhs": ["-x"]}, "network": [{"name": name, "layers": [LAYER]}]}
    with pytest.raises(SceneError, match="name"):
        build_system(document, "t", Path("t.toml"))


# ---- ONNX ----------------------------------------------------------------------------------------

needs_onnx = pytest.mark.skipif(find_spec("onnx") is None, reason="needs the package onnx")


def written(folder: Path, nodes: list[tuple[Any, ...]], stored: dict[str, np.ndarray]) -> Path:
    """An ONNX file of nodes ``(operator, inputs, output, attributes)``, and a scene that uses it."""
    onnx: Any = import_module("onnx")
    helper: Any = import_module("onnx.helper")
    kind = onnx.TensorProto.FLOAT
    made = [helper.make_node(op, inputs, [output], **attributes) for op, inputs, output, attributes in nodes]
    ends = [helper.make_tensor_value_info(name, kind, [1, size]) for name, size in (("in", 2), (nodes[-1][2], 1))]
    tensors = [import_module("onnx.numpy_helper").from_array(array, name) for name, array in stored.items()]
    graph = helper.make_graph(made, "net", ends[:1], ends[1:], tensors)
    onnx.save_model(helper.make_model(graph), folder / "net.onnx")
    scene = folder / "loop.toml"
    scene.write_text(SCENE.format("net.onnx"))
    return scene


@needs_onnx
@pytest.mark.parametrize("gemm", [True, False])
def test_an_onnx_network_is_that_of_its_floats(tmp_path: Path, *, gemm: bool) -> None:
    rng = np.random.default_rng(5)
    w1, b1, w2 = (rng.normal(size=shape).astype(np.float32) for shape in ((2, 4), (4,), (4, 1)))
    b2 = -(np.maximum(b1, 0) @ w2).astype(np.float32)
    stored = {"w1": w1.T.copy() if gemm else w1, "b1": b1, "w2": w2, "b2": b2}
    first: list[tuple[Any, ...]] = (
        [("Gemm", ["in", "w1", "b1"], "h", {"transB": 1})]
        if gemm
        else [("MatMul", ["in", "w1"], "g", {}), ("Add", ["b1", "g"], "h", {})]
    )
    last: list[tuple[Any, ...]] = [("MatMul", ["r", "w2"], "m", {}), ("Add", ["m", "b2"], "out", {})]
    system = load_system(written(tmp_path, [*first, ("Relu", ["h"], "r", {}), *last], stored))
    layers = [(np.array(w1.T, dtype=float), np.array(b1, dtype=float)), (np.array(w2.T, dtype=float), b2.astype(float))]
    for x, v in rng.normal(size=(5, 2)):
        place = [Fraction(x), Fraction(v)]
        piece = system.velocity(lambda surface, place=place: surface(place).sign())[1]  # type: ignore[misc]
        assert float(piece(place)) == pytest.approx(-x + float(value(layers, np.array([x, v]))[0]), abs=1e-12)


@needs_onnx
@pytest.mark.parametrize(
    ("nodes", "said"),
    [
        ([("Gemm", ["in", "w", "b"], "h", {}), ("Tanh", ["h"], "out", {})], "received Tanh"),
        ([("Gemm", ["in", "w", "b"], "h", {}), ("Relu", ["h"], "out", {})], "without Relu"),
        ([("Gemm", ["in", "w", "b"], "out", {"alpha": 2.0})], "alpha = beta = 1"),
        ([("MatMul", ["w", "in"], "out", {})], "received MatMul"),
    ],
)
def test_other_graphs_are_refused_in_one_line(tmp_path: Path, nodes: list[tuple[Any, ...]], said: str) -> None:
    stored = {"w": np.ones((2, 1), np.float32), "b": np.zeros(1, np.float32)}
    with pytest.raises(SceneError) as raised:
        load_system(written(tmp_path, nodes, stored))
    assert said in str(raised.value)
    assert "\n" not in str(raised.value)


@needs_onnx
def test_bytes_that_are_no_model_are_refused(tmp_path: Path) -> None:
    (tmp_path / "net.onnx").write_bytes(b"\x00\xffno model")
    (tmp_path / "loop.toml").write_text(SCENE.format("net.onnx"))
    with pytest.raises(SceneError, match="an ONNX model"):
        load_system(tmp_path / "loop.toml")


def test_without_the_package_an_onnx_file_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "onnx", None)
    (tmp_path / "net.onnx").write_bytes(b"")
    (tmp_path / "loop.toml").write_text(SCENE.format("net.onnx"))
    with pytest.raises(SceneError, match=r"pip install nonsmooth\[onnx\]"):
        load_system(tmp_path / "loop.toml")


# ---- in Python -----------------------------------------------------------------------------------


def test_loaded_systems_hold_their_layers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    layers = random_layers(7, 4, biased=False)
    (tmp_path / "net.json").write_text(json.dumps({"layers": tables(layers)}))
    (tmp_path / "loop.toml").write_text(SCENE.format("net.json"))
    monkeypatch.chdir("/")
    loaded = ns.load(tmp_path / "loop.toml")
    made = ns.System(
        ["x", "v"], ["v", "-x + u(x, v)"], networks={"u": [{"weights": w, "biases": b} for w, b in layers]}
    )
    assert isinstance(loaded, ns.System)
    assert [side.text for side in loaded.system.rhs] == [side.text for side in made.system.rhs]
    assert loaded.with_(radius="1/4").system.rhs[1].text == loaded.system.rhs[1].text


def test_a_document_without_a_folder_reads_no_file() -> None:
    document = {"system": {"states": ["x"], "rhs": ["-x"]}, "network": [{"name": "u", "file": "net.json"}]}
    with pytest.raises(SceneError, match="files are read beside scene files"):
        ns.System.of_document(document)
