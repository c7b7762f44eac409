"""Documents in TOML, of arrays, plain systems and vehicles: built-in ones by name, others from files, within bounds.

Whatever cannot be read ends in one :class:`SceneError` that names file, key, what was expected and what was received.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from decimal import Decimal
from difflib import get_close_matches
from os import PathLike
from pathlib import Path
from typing import Any

from nonsmooth.symbolic.mechanics.rule import MIXED
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact

MAX_TOML_BYTES = 1 << 20
_SCENES = Path(__file__).parents[1] / "scenes"
_BUILTIN = (
    "four-wheel",
    "four-wheel-side",
    "rectangle",
    "ring-3",
    "ring-5",
    "ring-6",
    "ring-8",
    "grid-4x4",
    "elliptic",
    "spiral-30",
    "conveyor-3",
    "saddle",
    "outward",
    "off-center",
    "differential-drive",
    "omni-3",
    "mecanum-4",
    "roller-bed",
    "carton-on-6x6",
)
_SYSTEMS = (
    "relay-oscillator",
    "relay-oscillator-damped",
    "flower",
    "escaping-slide",
    "line-of-equilibria",
    "eq-3",
    "eq-4",
    "stick-slip",
    "relay-chain",
)
_VEHICLES = (
    "lynx-wh05",
    "jackal",
    "husky-a200",
    "leo-rover",
    "panther-wh01",
    "rosbot",
    "warthog",
    "mecanum-base",
    "swerve-base",
    "tracked-base",
)


def builtin_scenes() -> tuple[str, ...]:
    """Names of the built-in scenes."""
    return _BUILTIN


def builtin_systems() -> tuple[str, ...]:
    """Names of the built-in plain switched systems (see :mod:`nonsmooth.symbolic.files.scene_file`)."""
    return _SYSTEMS


def builtin_vehicles() -> tuple[str, ...]:
    """Names of the built-in vehicles on their own wheels (see :mod:`nonsmooth.symbolic.files.vehicle_file`)."""
    return _VEHICLES


def builtin_descriptions() -> dict[str, str]:
    """One line about each built-in scene, by name."""
    return {name: _read_toml(_SCENES / f"{name}.toml", name)["description"] for name in _BUILTIN}


def read_document(
    source: str | Path,
    *,
    rule: str | None = None,
    radius: str | None = None,
    at: str | None = None,
    accuracy: str | None = None,
) -> tuple[dict[str, Any], str, Path]:
    """The TOML document of a scene with the given replacements, the scene's name for messages, and its file.

    Raises:
        SceneError: for a file that cannot be read, and a point of an array that is not two numbers; a plain system has
            one for each state.
    """
    require_path(source, "", "a scene file or a built-in name")
    file = str(source) or "''"
    path = _path(source)
    document = _read_toml(path, file)
    if at and at.count(",") != 1 and "system" not in document:
        raise SceneError(file, "check.equilibrium", "two numbers with a comma between them, such as 240,0", at)
    changes: dict[str, dict[str, object]] = {
        "contact": {"rule": None if rule == MIXED else rule},
        "check": {"radius": radius, "equilibrium": at and at.split(","), "accuracy": accuracy},
    }
    return _overridden(document, changes), file, path


def scene_files(source: str | Path) -> list[Path]:
    """The files that a scene is read from: its own, and that of its table of wheels.

    Raises:
        SceneError: for a file that cannot be read.
    """
    document, _, path = read_document(source)
    wheels = document.get("wheels")
    table = wheels.get("file") if isinstance(wheels, dict) else None
    return [path, path.parent / table] if isinstance(table, str) else [path]


def require_path(source: object, key: str, wanted: str) -> None:
    """Refuse what names no file.

    Raises:
        SceneError: of it; it names the key.
    """
    if not isinstance(source, str | PathLike):
        raise SceneError("scene", key, f"{wanted}, as a text or a path", source)


@contextmanager
def deep_nesting_refused(source: str | Path) -> Iterator[None]:
    """Refuse a document whose nested brackets exhaust the stack.

    Raises:
        SceneError: in place of Python's error.
    """
    try:
        yield
    except RecursionError:
        raise SceneError(str(source), "", "a document with fewer nested brackets", StatedFact("too many")) from None


def _path(source: str | Path) -> Path:
    """File of a scene: built-in names come before files, so that a stray file changes no result."""
    if isinstance(source, str) and source in _BUILTIN:
        return _SCENES / f"{source}.toml"
    if isinstance(source, str) and source in _SYSTEMS:
        return _SCENES / "systems" / f"{source}.toml"
    if isinstance(source, str) and source in _VEHICLES:
        return _SCENES / "vehicles" / f"{source}.toml"
    return Path(source)


def _read_toml(path: Path, file: str) -> dict[str, Any]:
    text = read_text(path, MAX_TOML_BYTES, file, "", _wanted(file))
    excess = toml_excess(text)
    if excess is not None:
        raise SceneError(file, "", excess[0], StatedFact(excess[1]))
    try:
        return tomllib.loads(text, parse_float=Decimal)
    except tomllib.TOMLDecodeError as error:
        raise SceneError(file, "", "a TOML document", StatedFact(f"an error: {str(error)[:120]}")) from None
    except (ValueError, ArithmeticError):  # of int and Decimal
        raise SceneError(file, "", "numbers of moderate length", StatedFact("one that is too long")) from None


def _wanted(file: str) -> str:
    """What a missing scene should have been."""
    close = get_close_matches(file[:80], (*_BUILTIN, *_SYSTEMS, *_VEHICLES), 2) or _BUILTIN[:2]
    return f"a scene file or a built-in scene such as {' or '.join(close)}"


def _overridden(data: dict[str, Any], changes: Mapping[str, Mapping[str, object]]) -> dict[str, Any]:
    """The document with the command line's values in their places, to be validated like the file's own."""
    for name, values in changes.items():
        overrides = {key: value for key, value in values.items() if value is not None}
        section = data.get(name, {})
        if overrides and isinstance(section, dict):
            data = {**data, name: {**section, **overrides}}
    return data


# ---- texts of files ------------------------------------------------------------------------------


OUTSIDE_OPTION = "--allow-outside"


def read_text(path: Path, limit: int, file: str, key: str, wanted: str) -> str:
    """Text of a file.

    Args:
        path: the file.
        limit: its largest size (bytes).
        file: the scene, for messages.
        key: the key that names the file, for messages; empty for the scene itself.
        wanted: what a missing file should have been, for messages.

    Raises:
        SceneError: for a missing, unreadable, oversized or binary file.
    """
    try:
        if not path.is_file():
            raise SceneError(file, key, wanted, StatedFact(_kind(path)))
        with path.open("rb") as stream:
            data = stream.read(limit + 1)
        if len(data) > limit:
            raise SceneError(file, key, f"a file of at most {limit >> 20} MB", StatedFact("more"))
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        received = StatedFact(f"other bytes at position {error.start}")
        raise SceneError(file, key, "a text file in UTF-8", received) from None
    except OSError as error:
        raise SceneError(file, key, "a readable file", StatedFact(error.strerror or "an error")) from None


def path_beside(scene: Path, name: str, file: str, key: str, *, allow_outside: bool) -> Path:
    """The file that a scene names, relative to the scene's folder.

    A scene may come from somebody else: without ``allow_outside`` the file must lie in that folder or below it, links
    resolved, and nothing is looked up elsewhere.

    Raises:
        SceneError: for a file outside the folder.
    """
    path = scene.parent / name
    if allow_outside:
        return path
    try:
        target, folder = path.resolve(), scene.parent.resolve()
    except ValueError:  # a null character: no file has such a name
        return path
    except (OSError, RuntimeError):  # links that lead to each other
        raise SceneError(file, key, "a readable file", StatedFact("a path that leads nowhere")) from None
    if not target.is_relative_to(folder):
        expected = f"a file in the scene's folder or below it (or the option {OUTSIDE_OPTION})"
        raise SceneError(file, key, expected, StatedFact("a path that leads outside"))
    return target


def _kind(path: Path) -> str:
    if path.is_dir():
        return "a directory"
    return "something that is no regular file" if path.exists() else "no such file"


# ---- bounds of TOML ------------------------------------------------------------------------------
#
# The parser of the standard library takes time that grows with the square of the number of parts of a dotted key, and a
# stack that grows with the depth of brackets.  A scene needs three of either.


MAX_PARTS = 16  # of a dotted key
MAX_NESTING = 64  # of brackets

# Strings and comments, each to its end or, where that is missing, to where the parser would give up.  Possessive, so
# that no character is looked at twice.
_OPAQUE = re.compile(
    r'"""(?:[^"\\]|\\.|"(?!""))*+(?:"{3,5})?'
    r"|'''(?:[^']|'(?!''))*+(?:'{3,5})?"
    r'|"(?:[^"\\\n]|\\[^\n])*+"?'
    r"|'[^'\n]*+'?"
    r"|#[^\n]*+",
    re.DOTALL,
)
_STRUCTURE = re.compile(r"[\n=,\[\]{}]")


def toml_excess(text: str) -> tuple[str, str] | None:
    """What a document must keep to and what this one holds; None where it keeps to both bounds."""
    bare = _OPAQUE.sub("", text)
    parts = 1 + max(piece.count(".") for piece in _STRUCTURE.split(bare))
    if parts > MAX_PARTS:
        return f"keys of at most {MAX_PARTS} parts", f"one of {parts}"
    depth = deepest = 0
    for bracket in re.findall(r"[\[\]{}]", bare):
        depth = depth + 1 if bracket in "[{" else max(depth - 1, 0)
        deepest = max(deepest, depth)
    if deepest > MAX_NESTING:
        return f"a document with fewer nested brackets (at most {MAX_NESTING})", f"{deepest}"
    return None
