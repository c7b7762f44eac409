"""Scene files with ``[[mode]]`` tables: systems with hysteresis and dwell time."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, PlainValidator

from nonsmooth.symbolic.expression import ExpressionError
from nonsmooth.symbolic.files.parameters import parameter_texts, read_parameters, with_parameters
from nonsmooth.symbolic.files.scene_document import Name
from nonsmooth.symbolic.files.scene_file import builtin_modes, deep_nesting_refused, read_document
from nonsmooth.symbolic.files.scene_validation import validate
from nonsmooth.symbolic.files.scene_values import ExactField, Numbers, TomlTable
from nonsmooth.symbolic.files.system_document import RESERVED, read_formulas, read_states
from nonsmooth.symbolic.files.system_file import build_system
from nonsmooth.symbolic.mode_system import ModeExit, ModeSystem, OwnMode
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.piecewise import parse_piecewise
from nonsmooth.symbolic.scene_error import SceneError, StatedFact, requirement
from nonsmooth.symbolic.switched_system import SwitchedSystem, require_stated

MAX_MODES = 40
MAX_NAME = 40  # characters


def read_name(value: object) -> str:
    """The name of a mode.

    Raises:
        ValueError: for anything else.
    """
    if not isinstance(value, str) or not value.strip() or len(value) > MAX_NAME or not value.isprintable():
        raise ValueError('required a name such as "heating"')
    return value


def read_exits(value: object) -> dict[str, object]:
    """Guards by the name of the mode that follows.

    Raises:
        ValueError: for anything else.
    """
    if not isinstance(value, dict) or not all(isinstance(name, str) for name in value):
        raise ValueError('required a table of guards by mode such as { idle = "T - 21" }')
    return dict(value)


class ModeTable(TomlTable):
    """One ``[[mode]]``: its right-hand sides, guards towards other modes, and the least time in it."""

    name: Annotated[str, PlainValidator(read_name)]
    rhs: Annotated[tuple[object, ...], PlainValidator(read_formulas)]
    leave: Annotated[dict[str, object], PlainValidator(read_exits)] = Field(default_factory=dict)
    dwell: ExactField = Fraction(0)


class ModeStatesTable(TomlTable):
    """``[system]`` beside modes: the states, and numbers that stand in formulas by name."""

    states: Annotated[tuple[str, ...], PlainValidator(read_states)]
    parameters: Annotated[dict[str, object], PlainValidator(read_parameters)] = Field(default_factory=dict)


class ModeDocument(TomlTable):
    """A whole scene file of a system with modes."""

    name: Name = None
    description: Name = None
    system: ModeStatesTable
    mode: tuple[ModeTable, ...]


def holds_modes(source: str | Path) -> bool:
    """Whether a scene is a system with modes.

    Raises:
        SceneError: for a file that cannot be read.
    """
    try:
        return "mode" in read_document(source)[0]
    except RecursionError:
        return False


def mode_descriptions() -> dict[str, str]:
    """One line about each built-in system with modes, by name."""
    return {name: read_document(name)[0]["description"] for name in builtin_modes()}


def load_modes(source: str | Path) -> ModeSystem:
    """Read a system with modes.

    Raises:
        SceneError: for whatever cannot be used.
    """
    with deep_nesting_refused(source):
        return build_modes(*read_document(source))


def build_modes(data: dict[str, Any], file: str, path: Path) -> ModeSystem:
    """The system of a document, by the parts that ``read_document`` returns.

    Raises:
        SceneError: for whatever cannot be used.
    """
    document = validate(ModeDocument, data, file)
    states, tables = document.system.states, document.mode
    if not 1 <= len(tables) <= MAX_MODES:
        raise SceneError(file, "mode", f"1 to {MAX_MODES} modes", StatedFact(str(len(tables))))
    names = [table.name for table in tables]
    for k, name in enumerate(names, 1):
        if name in names[: k - 1]:
            raise SceneError(file, f"mode[{k}].name", "another name for each mode", name)
    texts = parameter_texts(document.system.parameters, {*states, *RESERVED}, file)
    modes = tuple(_Reader(file, f"mode[{k}]", states, texts, names).mode(t, path) for k, t in enumerate(tables, 1))
    return ModeSystem(document.name or path.stem, states, modes, file)


class _Reader:
    """One mode of a document."""

    def __init__(
        self, file: str, key: str, states: tuple[str, ...], texts: Mapping[str, str], names: list[str]
    ) -> None:
        self.file, self.key, self.states, self.texts, self.names = file, key, states, texts, names

    def mode(self, table: ModeTable, path: Path) -> OwnMode:
        system = self._system(table, path)
        numbers = Numbers(self.file, system.field)
        dwell = numbers(table.dwell, f"{self.key}.dwell")
        if dwell.sign() < 0:
            raise SceneError(self.file, f"{self.key}.dwell", "a time that is not negative", str(dwell))
        exits = tuple(self._exit(system, target, guard) for target, guard in table.leave.items())
        return OwnMode(table.name, system, exits, dwell)

    def _system(self, table: ModeTable, path: Path) -> SwitchedSystem:
        """The right-hand sides as a plain system; what is wrong is said of the mode."""
        if any(isinstance(part, list) for part in table.rhs):
            expected = "one list of formulas (under arbitrary switching there are no modes)"
            raise SceneError(self.file, f"{self.key}.rhs", expected, StatedFact("several"))
        rhs = [with_parameters(text, self.texts) for text in table.rhs]
        try:
            system = build_system({"system": {"states": list(self.states), "rhs": rhs}}, self.file, path)
            require_stated(system)
            return system
        except SceneError as error:
            raise SceneError(self.file, error.key.replace("system", self.key, 1), error.expected, error.value) from None

    def _exit(self, system: SwitchedSystem, target: str, text: object) -> ModeExit:
        key = f"{self.key}.leave.{target}"
        if target not in self.names:
            raise SceneError(self.file, key, f"a mode of this file: {', '.join(self.names)}", target)
        try:
            expression = parse_piecewise(with_parameters(text, self.texts), self.states)
            values = dict(zip(self.states, system.coordinates(), strict=True))
            return ModeExit(expression.polynomial(values, _no_sign), target)
        except ExpressionError as error:
            raise SceneError(self.file, key, requirement(error), text) from None


def _no_sign(inner: Polynomial) -> int:
    raise ExpressionError("required a guard without sign, Abs, Max and Min, received one with them")
