"""Twenty systems that are carried to other libraries and back, and their fields by our own walker of trees."""

from __future__ import annotations

import random
from collections.abc import Sequence
from typing import Any

import nonsmooth as ns
from nonsmooth.symbolic.formulas.trees import MAX_TEXT, float_value, parse_tree

BUILT_IN = (
    "eq-3",
    "eq-4",
    "escaping-slide",
    "flower",
    "line-of-equilibria",
    "relay-chain",
    "relay-oscillator",
    "relay-oscillator-damped",
    "stick-slip",
)
STATED: dict[str, dict[str, Any]] = {
    "saturated": {"rhs": ["y", "-x - sat(2*x + y, -1/3, 1/2)"]},
    "rectified": {"rhs": ["-x + relu(y)", "-y - relu(x - y)"]},
    "largest": {"rhs": ["-Max(x, y, 0) - x", "-y - Min(x, 2*y, 3*x)/7"]},
    "arbitrary": {"rhs": [["-x + y", "-x - y"], ["-2*x", "-sign(x) - y"]]},
    "fraction": {"rhs": ["-x/(1 + y**2)", "-y - x/3"]},
    "sines": {"rhs": ["y", "-sin(x) - sign(y)/4"]},
    "smooth": {"rhs": ["tanh(y)", "-atan(x) - (1 + exp(-(y/2)**2))*sign(y)"]},
    "one state": {"states": ["s"], "rhs": ["-sign(s)*(1 + Abs(s)/5) - s**3"]},
    "three states": {"states": ["x", "y", "z"], "rhs": ["-x + y", "-y - sign(y)", "-z - relu(x)/9"]},
    "roots of numbers": {"rhs": ["-sqrt(2)*x + cos(pi/5)*y", "-x - sign(y)/sqrt(3)"]},
    "root of a state": {"rhs": ["-sign(x)*sqrt(Abs(x))", "-y"]},
    "moved": {"rhs": ["2 - x - sign(x - 1) + y", "-y - x + 1"], "at": [1, 0], "lyapunov": "x**2 + y**2"},
}
NAMES = (*BUILT_IN, *STATED)


def system(name: str) -> ns.System:
    """One of the twenty."""
    if name in BUILT_IN:
        loaded = ns.load(name)
        assert isinstance(loaded, ns.System)
        return loaded
    stated = dict(STATED[name])
    return ns.System(stated.pop("states", ["x", "y"]), stated.pop("rhs"), name=name, **stated)


def points(count: int, number: int = 12) -> list[list[float]]:
    """Random points on the two sides of most surfaces; on the surfaces themselves nothing is compared."""
    source = random.Random(count)
    return [[round(source.uniform(-2, 2), 3) + 0.00037 for _ in range(count)] for _ in range(number)]


def values(formulas: Sequence[str], states: Sequence[str], point: Sequence[float]) -> list[float]:
    """The formulas at a point, by the walker that proposes in floats."""
    at = dict(zip(states, point, strict=True))
    trees = [parse_tree(text, MAX_TEXT, "a formula") for text in formulas]
    return [float_value(tree, at, text) for text, tree in trees]
