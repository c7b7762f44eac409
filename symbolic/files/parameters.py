"""Named parameters of a plain system: numbers that stand in its formulas by name.

A formula is rewritten as text before it is parsed: every parameter's name is replaced by its value, so
results, reports and certificates show formulas that are complete by themselves.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from fractions import Fraction
from typing import Any

from nonsmooth.symbolic.files.scene_values import read_exact
from nonsmooth.symbolic.formulas.expression import ExpressionError
from nonsmooth.symbolic.messages.scene_error import SceneError, requirement

MAX_PARAMETERS = 40
NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,19}")
_PLAIN = re.compile(r"\d+(\.\d+)?")
_NAMES_IN_FORMULA = re.compile(r"(?<![\w.])[A-Za-z_]\w*")  # not the exponent of 1e5


def read_parameters(value: object) -> dict[str, Any]:
    """A table of numbers by name, as they were written.

    Raises:
        ValueError: for anything else.
    """
    if not isinstance(value, dict) or not all(isinstance(name, str) for name in value):
        raise ValueError("required a table of numbers such as { k = 2 }")
    if len(value) > MAX_PARAMETERS:
        raise ValueError(f"required at most {MAX_PARAMETERS} parameters")
    return dict(value)


def parameter_texts(parameters: Mapping[str, Any], taken: Collection[str], file: str) -> dict[str, str]:
    """What stands for each name in a formula.

    Args:
        parameters: values by name.
        taken: names that mean something else: states and functions.
        file: for messages.

    Raises:
        SceneError: for a name that is taken or no name, and for a value that is no number.
    """
    texts = {}
    for name, value in parameters.items():
        key = f"system.parameters.{name}"
        if not NAME.fullmatch(name) or name in taken:
            raise SceneError(file, key, "a name that is no state and no function", name)
        text = _text(value, file, key)
        texts[name] = text if _PLAIN.fullmatch(text) else f"({text})"
    return texts


def _text(value: Any, file: str, key: str) -> str:
    try:
        number = read_exact(value)
    except ExpressionError as error:
        raise SceneError(file, key, requirement(error), value) from None
    return str(number) if isinstance(number, Fraction) else number.text


def with_parameters(formula: object, texts: Mapping[str, str]) -> object:
    """A formula with its parameters replaced; what is no text stays as it is, for the parser to refuse."""
    if not isinstance(formula, str) or not texts:
        return formula
    return _NAMES_IN_FORMULA.sub(lambda match: texts.get(match.group(), match.group()), formula)
