"""Networks in ONNX files: dense layers with ReLU, their floats as the binary fractions that they are.

The file is read by the package ``onnx`` (extra ``onnx``), and nothing in it is run.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from importlib import import_module
from math import isfinite
from pathlib import Path
from typing import Any

from nonsmooth.symbolic.network import Layer, NetworkError

MAX_BYTES = 1 << 20
DENSE = "nodes Gemm, MatMul, Add and Relu, one after the other"


def read_onnx(path: Path) -> list[Layer]:
    """The layers of a network.

    Raises:
        NetworkError: without the package, and for a file that holds something else.
    """
    try:
        onnx: Any = import_module("onnx")
        helper: Any = import_module("onnx.numpy_helper")
    except ImportError:
        expected = "the package onnx (pip install nonsmooth[onnx])"
        raise NetworkError(f"required {expected}, received a Python without it") from None
    graph = _graph(onnx, path)
    values = {tensor.name: _entries(helper, tensor) for tensor in graph.initializer}
    return _layers(graph, values)


def _graph(onnx: Any, path: Path) -> Any:
    try:
        with path.open("rb") as stream:
            data = stream.read(MAX_BYTES + 1)
        if len(data) > MAX_BYTES:
            raise NetworkError(f"required a file of at most {MAX_BYTES >> 20} MB, received more")
        model = onnx.load_model_from_string(data)
        onnx.checker.check_model(model)
    except NetworkError:
        raise
    except OSError as error:
        raise NetworkError(f"required a readable file, received {error.strerror or 'an error'}") from None
    except Exception:  # whatever the package raises of bytes that are no model
        raise NetworkError("required an ONNX model, received other bytes") from None
    return model.graph


def _entries(helper: Any, tensor: Any) -> list[Any]:
    """The numbers of a tensor as exact fractions, nested by its dimensions."""
    try:
        array = helper.to_array(tensor)
    except Exception:  # such as data in another file
        raise NetworkError(f"required weights in the file itself, received {tensor.name!r} elsewhere") from None
    if array.dtype.kind not in "fiu" or array.ndim > 2:
        raise NetworkError(f"required vectors and matrices of numbers, received {tensor.name!r}")
    return _exact(array.tolist())


def _exact(value: Any) -> Any:
    if isinstance(value, list):
        return [_exact(entry) for entry in value]
    if not isfinite(value):
        raise NetworkError(f"required finite weights, received {value}")
    return Fraction(value)


def _layers(graph: Any, values: Mapping[str, Any]) -> list[Layer]:
    """The chain of nodes from the one input to the one output."""
    given = [entry.name for entry in graph.input if entry.name not in values]
    if len(given) != 1 or len(graph.output) != 1:
        raise NetworkError(f"required one input and one output, received {len(given)} and {len(graph.output)}")
    layers: list[Layer] = []
    here, ends_in_relu = given[0], True  # the first layer has none before it
    for node in graph.node:
        if here not in node.input or len(node.output) != 1:
            raise NetworkError(f"required {DENSE}, received {node.op_type} beside them")
        others = [values[name] for name in node.input if name != here and name in values]
        if len(others) != len(node.input) - 1:
            raise NetworkError(f"required {DENSE} with stored weights, received {node.op_type} of other values")
        if node.op_type == "Relu":
            ends_in_relu = True
        elif node.op_type == "Add" and layers and not ends_in_relu:
            layers[-1] = _with_biases(layers[-1], others[0])
        elif node.op_type in ("Gemm", "MatMul") and node.input[0] == here and ends_in_relu:
            layers.append(_gemm(node, others) if node.op_type == "Gemm" else _dense(_transposed(others[0]), None))
            ends_in_relu = False
        else:
            raise NetworkError(f"required {DENSE}, received {node.op_type} there")
        here = node.output[0]
    if here != graph.output[0].name or not layers or ends_in_relu:
        raise NetworkError(f"required {DENSE}, the last layer without Relu, received another end")
    return layers


def _gemm(node: Any, others: list[Any]) -> Layer:
    """``alpha A B + beta C`` with the weights B, perhaps transposed."""
    set_to = {a.name: (a.f if a.name in ("alpha", "beta") else a.i) for a in node.attribute}
    plain = set_to.get("alpha", 1.0) == 1.0 and set_to.get("beta", 1.0) == 1.0 and not set_to.get("transA", 0)
    if not plain:
        raise NetworkError("required Gemm with alpha = beta = 1 and transA = 0, received others")
    weights = others[0] if set_to.get("transB", 0) else _transposed(others[0])
    return _dense(weights, others[1] if len(others) > 1 else None)


def _transposed(matrix: Any) -> list[list[Fraction]]:
    if not matrix or not isinstance(matrix[0], list):
        raise NetworkError("required matrices of weights, received a vector")
    return [list(column) for column in zip(*matrix, strict=True)]


def _dense(weights: list[list[Fraction]], biases: Any) -> Layer:
    if not weights or not isinstance(weights[0], list) or not weights[0]:
        raise NetworkError("required matrices of weights, received others")
    layer = Layer(tuple(map(tuple, weights)), (Fraction(0),) * len(weights))
    return layer if biases is None else _with_biases(layer, biases)


def _with_biases(layer: Layer, biases: Any) -> Layer:
    """The layer with a vector, or a matrix of one row, added."""
    row = biases[0] if isinstance(biases, list) and biases and isinstance(biases[0], list) else biases
    if not isinstance(row, list) or len(row) not in (1, len(layer.biases)):
        raise NetworkError(f"required {len(layer.biases)} biases, received another number")
    full = row * len(layer.biases) if len(row) == 1 else row
    return Layer(layer.weights, tuple(a + b for a, b in zip(layer.biases, full, strict=True)))
