"""Feedforward networks with ReLU units as formulas of their inputs: piecewise affine functions, exactly.

A network with layers ``(W_k, b_k)`` maps ``a`` to ``W_n r(... r(W_1 a + b_1) ...) + b_n`` with ``r(a) = max(a, 0)`` in
every entry.  It is written out as a formula with ``relu``, so whatever reads formulas reads networks.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

MAX_UNITS = 16  # ReLU units of a network: each may be a switching surface
MAX_LAYERS = 4
MAX_OUTPUTS = 8
MAX_FORMULA = 20_000  # characters of a network written out: layers multiply


class NetworkError(ValueError):
    """A network that cannot be used; the message says ``required X, received Y``."""


@dataclass(frozen=True)
class Layer:
    """An affine map ``a -> W a + b``.

    Attributes:
        weights: W, one row for each output.
        biases: b.
    """

    weights: tuple[tuple[Fraction, ...], ...]
    biases: tuple[Fraction, ...]

    @property
    def inputs(self) -> int:
        """How many entries it takes."""
        return len(self.weights[0])


@dataclass(frozen=True)
class Network:
    """Layers with ReLU between them, none after the last one.

    Attributes:
        name: what formulas call it.
        layers: at least one, each taking what the one before gives.
    """

    name: str
    layers: tuple[Layer, ...]

    @property
    def inputs(self) -> int:
        """How many arguments it takes."""
        return self.layers[0].inputs

    @property
    def outputs(self) -> tuple[str, ...]:
        """The names of its outputs: its own, or numbered from 1 where there are several."""
        count = len(self.layers[-1].biases)
        return (self.name,) if count == 1 else tuple(f"{self.name}_{k}" for k in range(1, count + 1))

    def formulas(self, arguments: Sequence[str]) -> tuple[str, ...]:
        """A formula for each output.

        Args:
            arguments: formulas of the inputs.

        Raises:
            NetworkError: for a formula that gets too long.
        """
        values = [f"({argument})" for argument in arguments]
        for layer in self.layers[:-1]:
            values = [f"relu({text})" for text in _affine(layer, values)]
        found = tuple(f"({text})" for text in _affine(self.layers[-1], values))
        longest = max(map(len, found))
        if longest > MAX_FORMULA:
            expected = f"a network that is at most {MAX_FORMULA} characters written out"
            raise NetworkError(f"required {expected}, received {longest}")
        return found


def build_network(name: str, layers: Sequence[Layer]) -> Network:
    """A network whose layers fit together.

    Raises:
        NetworkError: for layers that do not, and for more of anything than is looked at.
    """
    if not 1 <= len(layers) <= MAX_LAYERS:
        raise NetworkError(f"required 1 to {MAX_LAYERS} layers, received {len(layers)}")
    for k, (before, after) in enumerate(pairwise(layers), 2):
        if after.inputs != len(before.biases):
            expected = f"{len(before.biases)} columns of weights in layer {k}, one for each unit before it"
            raise NetworkError(f"required {expected}, received {after.inputs}")
    units = sum(len(layer.biases) for layer in layers[:-1])
    if units > MAX_UNITS:
        raise NetworkError(f"required at most {MAX_UNITS} ReLU units, received {units}")
    if len(layers[-1].biases) > MAX_OUTPUTS:
        raise NetworkError(f"required at most {MAX_OUTPUTS} outputs, received {len(layers[-1].biases)}")
    return Network(name, tuple(layers))


def _affine(layer: Layer, values: Sequence[str]) -> list[str]:
    return [_sum(row, bias, values) for row, bias in zip(layer.weights, layer.biases, strict=True)]


def _sum(row: Sequence[Fraction], bias: Fraction, values: Sequence[str]) -> str:
    terms = [_product(weight, value) for weight, value in zip(row, values, strict=True) if weight]
    if bias or not terms:
        terms.append(_number(bias))
    return " + ".join(terms)


def _product(weight: Fraction, value: str) -> str:
    return value if weight == 1 else f"{_number(weight)}*{value}"


def _number(value: Fraction) -> str:
    return str(value) if value.denominator == 1 and value >= 0 else f"({value})"
