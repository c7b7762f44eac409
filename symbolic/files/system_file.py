"""Scene files with a ``[system]`` table: a plain switched system in two states.

Structure is checked by pydantic, formulas by :mod:`nonsmooth.symbolic.piecewise`.  Whatever is wrong ends in one
:class:`SceneError`, as for wheel arrays.
"""

from __future__ import annotations

import re
from fractions import Fraction
from pathlib import Path
from typing import Annotated, Any

from pydantic import PlainValidator

from nonsmooth.symbolic.expression import ExpressionError
from nonsmooth.symbolic.files.scene_document import Name
from nonsmooth.symbolic.files.scene_file import build_scene, builtin_systems, deep_nesting_refused, read_document
from nonsmooth.symbolic.files.scene_validation import validate
from nonsmooth.symbolic.files.scene_values import ExactField, Numbers, PairField, Table, angles, field_of, requirement
from nonsmooth.symbolic.piecewise import NUMBERS, SWITCHES, PiecewiseExpression, parse_piecewise
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.scene_error import Fact, SceneError
from nonsmooth.symbolic.system import SystemCheck, SystemScene

_STATE = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,19}")
_RESERVED = {*NUMBERS, *SWITCHES}


def is_state(value: object) -> bool:
    """Whether a value can name a state."""
    return isinstance(value, str) and _STATE.fullmatch(value) is not None and value not in _RESERVED


def read_states(value: object) -> tuple[str, str]:
    """Two different names.

    Raises:
        ValueError: for anything else.
    """
    names = value if isinstance(value, list) and len(value) == 2 else []
    fit = [name for name in names if is_state(name)]
    if len(set(fit)) != 2:
        raise ValueError('required two different names such as ["x", "y"] (only planar systems are supported)')
    return fit[0], fit[1]


def read_two(value: object) -> tuple[object, object]:
    """A list of two formulas.

    Raises:
        ValueError: for anything else.
    """
    if not isinstance(value, list) or len(value) != 2:
        raise ValueError("required two formulas, one for each state")
    return value[0], value[1]


class SystemTable(Table):
    """``[system]``: two states and their right-hand sides."""

    states: Annotated[tuple[str, str], PlainValidator(read_states)]
    rhs: Annotated[tuple[object, object], PlainValidator(read_two)]


class SystemCheckTable(Table):
    """``[check]``: the equilibrium, the half-width of the square about it, and a Lyapunov function V."""

    equilibrium: PairField = (Fraction(0), Fraction(0))
    radius: ExactField = Fraction(1, 2)
    lyapunov: object = None


class SystemDocument(Table):
    """A whole scene file of a plain switched system."""

    name: Name = None
    description: Name = None
    system: SystemTable
    check: SystemCheckTable = SystemCheckTable()


def load_any(
    source: str | Path,
    *,
    rule: str | None = None,
    radius: str | None = None,
    at: str | None = None,
    allow_outside: bool = False,
) -> Scene | SystemScene:
    """Read a wheel array or a plain switched system, whichever the file holds; arguments as for ``load_scene``.

    Raises:
        SceneError: for whatever cannot be used.
    """
    with deep_nesting_refused(source):
        data, file, path = read_document(source, rule=rule, radius=radius, at=at)
        if "system" not in data:
            return build_scene(data, file, path, allow_outside=allow_outside)
        if rule is not None:
            raise SceneError(file, "contact.rule", "no contact rule for a plain switched system", str(rule))
        return _system(data, file, path)


def load_system(source: str | Path, *, radius: str | None = None, at: str | None = None) -> SystemScene:
    """Read a plain switched system.

    Args:
        source: path of a scene file, or the name of a built-in system.
        radius: half-width of the checked square that replaces the file's, as text.
        at: equilibrium ``x,y`` that replaces the file's, as text.

    Raises:
        SceneError: for whatever cannot be used.
    """
    with deep_nesting_refused(source):
        data, file, path = read_document(source, radius=radius, at=at)
        if "system" not in data:
            raise SceneError(file, "system", "a plain switched system, [system]", Fact("nothing"))
        return _system(data, file, path)


def system_descriptions() -> dict[str, str]:
    """One line about each built-in system, by name."""
    return {name: read_document(name)[0]["description"] for name in builtin_systems()}


def parse_lyapunov(text: object, states: tuple[str, ...], file: str, key: str) -> PiecewiseExpression:
    """V, or a right-hand side, as a formula of the states.

    Raises:
        SceneError: for anything else.
    """
    try:
        return parse_piecewise(text, states)
    except ExpressionError as error:
        raise SceneError(file, key, requirement(error), text) from None


def _system(data: dict[str, Any], file: str, path: Path) -> SystemScene:
    document = validate(SystemDocument, data, file)
    table, check = document.system, document.check
    first, second = (
        parse_lyapunov(text, table.states, file, f"system.rhs[{k}]") for k, text in enumerate(table.rhs, 1)
    )
    default = " + ".join(f"{name}**2" for name in table.states)
    lyapunov = parse_lyapunov(
        default if check.lyapunov is None else check.lyapunov, table.states, file, "check.lyapunov"
    )
    turns = [turn for formula in (first, second, lyapunov) for turn in formula.turns()]
    numbers = Numbers(file, field_of([*turns, *angles(check)]))
    x, y = (numbers(value, "check.equilibrium") for value in check.equilibrium)
    checked = SystemCheck((x, y), numbers.positive(check.radius, "check.radius"), lyapunov, check.lyapunov is None)
    scene = SystemScene(document.name or path.stem, numbers.field, table.states, (first, second), checked, file)
    for sign in (1, -1):  # two of the smooth pieces: the rest is looked at where it is used
        _try_pieces(scene, sign)
    return scene


def _try_pieces(scene: SystemScene, sign: int) -> None:
    """Refuse formulas that are no polynomials where all inner expressions have one sign."""
    scene.velocity(lambda _: sign)
    lyapunov = scene.check.lyapunov
    try:
        scene.potential(lyapunov, lambda _: sign)
    except ExpressionError as error:
        raise SceneError(scene.source, "check.lyapunov", requirement(error), lyapunov.text) from None
