"""``[[network]]`` tables of a plain system: functions of its formulas that are given as layers of weights.

A table names the function, and a file of layers (.json, or .onnx) or the layers themselves.  ``u(x, v)`` in a formula
is then the network's output; one with several outputs is called ``u_1(x, v)``, ``u_2(x, v)``, ....
"""

from __future__ import annotations

import ast
import json
from collections.abc import Collection, Mapping, Sequence
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

from nonsmooth.symbolic.expression import ExpressionError, parse_tree
from nonsmooth.symbolic.files.onnx_file import read_onnx
from nonsmooth.symbolic.files.parameters import NAME
from nonsmooth.symbolic.files.scene_values import TomlTable, read_exact
from nonsmooth.symbolic.files.text_files import path_beside, read_text
from nonsmooth.symbolic.network import Layer, Network, NetworkError, build_network
from nonsmooth.symbolic.piecewise import MAX_TEXT
from nonsmooth.symbolic.scene_error import SceneError, StatedFact, requirement, shown

MAX_NETWORKS = 4
MAX_BYTES = 1 << 20
MAX_ROWS = 64  # of a matrix that is read, and entries of a row
SUFFIXES = (".json", ".onnx")


class NetworkTable(TomlTable):
    """``[[network]]``: its name in formulas, and its file or its layers."""

    name: str
    file: str | None = None
    layers: Any = None


def read_networks(
    tables: Sequence[NetworkTable], taken: Collection[str], file: str, path: Path
) -> dict[str, tuple[Network, int]]:
    """The functions that formulas may call: for each name the network, and which of its outputs.

    Args:
        tables: of the document.
        taken: names that mean something else.
        file: the scene, for messages.
        path: its file: networks lie beside it.

    Raises:
        SceneError: for whatever cannot be used.
    """
    if len(tables) > MAX_NETWORKS:
        raise SceneError(file, "network", f"at most {MAX_NETWORKS} networks", StatedFact(f"{len(tables)}"))
    found: dict[str, tuple[Network, int]] = {}
    for k, table in enumerate(tables, 1):
        key = f"network[{k}]"
        if not NAME.fullmatch(table.name):
            raise SceneError(file, f"{key}.name", "a name such as u", table.name)
        network = _network(table, file, key, path)
        for output, name in enumerate(network.outputs):
            if name in taken or name in found:
                raise SceneError(file, f"{key}.name", "a name that is no state, parameter or function", name)
            found[name] = network, output
    return found


def with_layers(document: Mapping[str, Any], file: str, path: Path) -> dict[str, Any]:
    """The document with the layers of its networks in place of their files, which may change on the disk meanwhile.

    Raises:
        SceneError: for a file that cannot be used.
    """
    tables = document.get("network")
    if not isinstance(tables, list):
        return dict(document)
    return {**document, "network": [_with_own(table, file, f"network[{k}]", path) for k, table in enumerate(tables, 1)]}


def require_layers(document: Mapping[str, Any], file: str) -> None:
    """Refuse networks in files, for a document that has no folder.

    Raises:
        SceneError: for such a network.
    """
    tables = document.get("network")
    for k, table in enumerate(tables if isinstance(tables, list) else [], 1):
        if isinstance(table, Mapping) and "file" in table:
            raise SceneError(file, f"network[{k}]", "layers (files are read beside scene files)", StatedFact("a file"))


def _with_own(table: Any, file: str, key: str, path: Path) -> Any:
    if not isinstance(table, Mapping) or not isinstance(table.get("file"), str) or "layers" in table:
        return table
    network = _network(NetworkTable(name=str(table.get("name")), file=table["file"]), file, key, path)
    layers = [
        {"weights": [[str(w) for w in row] for row in layer.weights], "biases": [str(b) for b in layer.biases]}
        for layer in network.layers
    ]
    return {**{name: value for name, value in table.items() if name != "file"}, "layers": layers}


def called(formula: object, functions: Mapping[str, tuple[Network, int]]) -> object:
    """A formula with its calls of networks written out; what is no text stays as it is, for the parser to refuse.

    Raises:
        ExpressionError: for a call with another number of arguments.
    """
    if not isinstance(formula, str) or not functions:
        return formula
    text, tree = parse_tree(formula, MAX_TEXT, "a formula")
    return _written(tree, text, functions)


def _written(node: ast.expr, text: str, functions: Mapping[str, tuple[Network, int]]) -> str:
    """A part of a formula: its own text, less that of the calls inside it."""
    own = ast.get_source_segment(text, node) or ""
    for inner in sorted(_calls(node, functions), key=lambda call: (-call.lineno, -call.col_offset)):
        network, output = functions[_name(inner)]
        if len(inner.args) != network.inputs or inner.keywords:
            expected = f"{network.inputs} arguments of {_name(inner)}"
            raise ExpressionError(f"required {expected}, received {shown(text)}")
        arguments = [_written(argument, text, functions) for argument in inner.args]
        segment = ast.get_source_segment(text, inner) or ""
        try:
            formula = network.formulas(arguments)[output]
        except NetworkError as error:
            raise ExpressionError(str(error)) from None
        start = _start(text, node, inner)
        own = own[:start] + formula + own[start + len(segment) :]
    return own


def _calls(node: ast.expr, functions: Mapping[str, tuple[Network, int]]) -> list[ast.Call]:
    """The outermost calls of networks in a part."""
    found: list[ast.Call] = []
    waiting: list[ast.AST] = [node]
    while waiting:
        here = waiting.pop()
        if isinstance(here, ast.Call) and _name(here) in functions:
            found.append(here)
        else:
            waiting += ast.iter_child_nodes(here)
    return found


def _name(call: ast.Call) -> str:
    return call.func.id if isinstance(call.func, ast.Name) else ""


def _start(text: str, outer: ast.expr, inner: ast.expr) -> int:
    """Where a part begins in the text of another one, in characters."""
    return _offset(text, inner) - _offset(text, outer)


def _offset(text: str, node: ast.expr) -> int:
    lines = text.splitlines(keepends=True)
    before = sum(map(len, lines[: node.lineno - 1]))
    return before + len(lines[node.lineno - 1].encode()[: node.col_offset].decode())


# ---- layers --------------------------------------------------------------------------------------


def _network(table: NetworkTable, file: str, key: str, path: Path) -> Network:
    if (table.file is None) is (table.layers is None):
        received = StatedFact("neither" if table.file is None else "both")
        raise SceneError(file, key, "file or layers", received)
    place = f"{key}.layers" if table.file is None else f"{key}.file {table.file}"
    try:
        layers = _layers(table.layers) if table.file is None else _of_file(table.file, file, place, path)
        return build_network(table.name, layers)
    except NetworkError as error:
        received = StatedFact(str(error).partition(", received ")[2])
        raise SceneError(file, place, requirement(error), received) from None


def _of_file(name: str, file: str, key: str, path: Path) -> list[Layer]:
    target = path_beside(path, name, file, key, allow_outside=False)
    if target.suffix.lower() not in SUFFIXES:
        raise SceneError(file, key, f"a file {' or '.join(SUFFIXES)}", name)
    if target.suffix.lower() == ".onnx":
        return read_onnx(target)
    text = read_text(target, MAX_BYTES, file, key, "a file")
    try:
        data = json.loads(text, parse_float=Decimal)
    except (ValueError, RecursionError):
        raise NetworkError("required JSON, received other text") from None
    if not isinstance(data, dict) or set(data) != {"layers"}:
        raise NetworkError('required {"layers": [{"weights": [[...]], "biases": [...]}, ...]}, received others')
    return _layers(data["layers"])


def _layers(value: Any) -> list[Layer]:
    if not isinstance(value, list) or not value:
        raise NetworkError("required a list of layers, received another value")
    return [_layer(entry, k) for k, entry in enumerate(value, 1)]


def _layer(value: Any, k: int) -> Layer:
    if not isinstance(value, dict) or set(value) != {"weights", "biases"}:
        raise NetworkError(f"required weights and biases in layer {k}, received {shown(value)}")
    weights, biases = value["weights"], value["biases"]
    shaped = isinstance(weights, list) and isinstance(biases, list) and len(weights) == len(biases)
    if not shaped or not 1 <= len(weights) <= MAX_ROWS:
        raise NetworkError(f"required a row of weights for each bias in layer {k}, received others")
    rows = [row if isinstance(row, list) else [] for row in weights]
    if not 1 <= len(rows[0]) <= MAX_ROWS or any(len(row) != len(rows[0]) for row in rows):
        raise NetworkError(f"required rows of weights of one length in layer {k}, received others")
    return Layer(tuple(tuple(map(_number, row)) for row in rows), tuple(map(_number, biases)))


def _number(value: Any) -> Fraction:
    """A rational number.

    Raises:
        NetworkError: for anything else.
    """
    try:
        found = read_exact(value)
    except ExpressionError as error:
        raise NetworkError(str(error)) from None
    if isinstance(found, Fraction):
        return found
    try:
        number, multiple = found.parts_in_pi()
    except ExpressionError:
        number, multiple = Fraction(0), Fraction(1)
    if multiple:
        raise NetworkError(f"required rational weights, received {shown(value)}")
    return number
