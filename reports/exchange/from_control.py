"""python-control's state spaces as Lur'e systems: linear, with a saturation, relay or dead zone in the loop (extra
``nonsmooth[control]``).

``x' = A x + B u``, ``y = C x``, ``u_i = sign phi_i(y_i)``, with -1 for a negative feedback.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from nonsmooth.reports.exchange.from_matrices import Rows, matrix, state_names, times
from nonsmooth.reports.exchange.reading import Reading
from nonsmooth.symbolic.formulas.formula_text import ZERO, difference_text, product_text, sum_text

PHI: dict[str, Callable[[str, str], str]] = {
    "saturation": "sat({0}, -{1}, {1})".format,
    "relay": lambda y, limit: product_text([limit, f"sgn({y})"]),
    "deadzone": lambda y, limit: difference_text(y, f"sat({y}, -{limit}, {limit})"),
}  # of an output and a positive number, by name
LIKE_A_NAME = 'one of "saturation", "relay", "deadzone", or None, for each output'


def formulas_of_control(
    plant: Any, nonlinearity: Any, limit: Any, sign: int, reading: Reading
) -> tuple[list[str], list[str]]:
    """The names of the states, and one formula for each.

    Args:
        plant: a ``control.StateSpace`` in continuous time.
        nonlinearity: a name of :data:`PHI` or None (a gain of one) for each output, or one for all; python-control's
            ``saturation_nonlinearity``, or its ``relay_hysteresis_nonlinearity`` without hysteresis. Without any of
            them the loop is open: ``x' = A x``.
        limit: positive number: of a saturation or relay its largest value, of a dead zone its half-width; or a list.
        sign: of the feedback, 1 or -1.
        reading: how numbers are read.

    Raises:
        SceneError: without python-control, for discrete time, feedthrough, and what is no such nonlinearity.
    """
    control = reading.library("control")
    if not isinstance(plant, control.StateSpace):
        hint = "a StateSpace (control.ss makes one, in floats, of a transfer function)"
        raise reading.refused("plant", hint, type(plant).__name__)
    if plant.dt not in (0, None):
        raise reading.refused("plant", "continuous time (dt = 0)", f"dt = {plant.dt}")
    if type(sign) is not int or sign not in (1, -1):
        raise reading.refused("sign", "1 or -1", sign)
    labels = [str(label) for label in plant.state_labels]
    names = labels if all(label.isidentifier() for label in labels) else state_names(plant.nstates)
    linear = times(matrix(plant.A, "A", reading), names)
    if nonlinearity is None:
        return names, linear
    feedback = _feedback(plant, nonlinearity, limit, names, reading)
    signed = feedback if sign == 1 else [f"(-{part})" for part in feedback]
    inputs: Rows = matrix(plant.B, "B", reading, (plant.nstates, len(signed)))
    return names, [sum_text([a, b]) for a, b in zip(linear, times(inputs, signed), strict=True)]


def _feedback(plant: Any, nonlinearity: Any, limit: Any, names: Sequence[str], reading: Reading) -> list[str]:
    """``phi_i(y_i)`` of each output."""
    if plant.D.any():
        raise reading.refused("D", "no feedthrough (D = 0): a relay of its own output need not have a value", "another")
    outputs = times(matrix(plant.C, "C", reading, (plant.ninputs, plant.nstates)), names)
    kinds = list(nonlinearity) if isinstance(nonlinearity, list | tuple) else [nonlinearity] * len(outputs)
    limits = list(limit) if isinstance(limit, list | tuple) else [limit] * len(outputs)
    if not len(kinds) == len(limits) == len(outputs):
        raise reading.refused("nonlinearity", f"{len(outputs)}, with their limits", f"{len(kinds)}, {len(limits)}")
    return [_phi(*own, reading) for own in zip(outputs, kinds, limits, strict=True)]


def _phi(output: str, kind: Any, limit: Any, reading: Reading) -> str:
    """One nonlinearity of one output."""
    if output == ZERO or kind is None:
        return output
    name, size = (kind, limit) if isinstance(kind, str) else _of_object(kind, reading)
    if name not in PHI:
        raise reading.refused("nonlinearity", LIKE_A_NAME, repr(name))
    if not isinstance(size, str) and not size > 0:
        raise reading.refused("limit", "a positive number", size)
    return PHI[name](output, reading.number(size, "limit"))


def _of_object(kind: Any, reading: Reading) -> tuple[str, Any]:
    """The name and the limit of one of python-control's own nonlinearities."""
    match type(kind).__name__:
        case "saturation_nonlinearity" if kind.lb == -kind.ub:
            return "saturation", kind.ub
        case "relay_hysteresis_nonlinearity" if kind.c == 0:
            return "relay", kind.b
        case "relay_hysteresis_nonlinearity":
            raise reading.refused("nonlinearity", "a relay without hysteresis (c = 0)", f"c = {kind.c}")
    raise reading.refused("nonlinearity", LIKE_A_NAME, type(kind).__name__)
