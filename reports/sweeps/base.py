"""The scene that a sweep starts from, fully resolved: its document, and the text of its table of wheels.

Workers get it once; a scene of the sweep is this document with a few entries replaced.  Its key in a store is the hash
of all that its answers follow from.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from functools import cache, cached_property
from pathlib import Path
from typing import Any

from nonsmooth.reports.sweeps.sweep_plan import Entry, SweepPlan
from nonsmooth.symbolic.files.key_paths import Path as KeyPath
from nonsmooth.symbolic.files.key_paths import with_value
from nonsmooth.symbolic.files.scene_file import build_scene, one_by_one, wheel_table
from nonsmooth.symbolic.files.system_builder import build_system
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

UNHEARD = ("name", "description")  # tables that no answer follows from
_PLAIN = re.compile(r"-?[0-9]{1,60}(\.[0-9]{1,60}|/[1-9][0-9]{0,60})?")  # a decimal or a fraction
OF_ALL_WHEELS: dict[KeyPath, str] = {  # numbers of the scene, and what a wheel calls its own
    ("friction", "mu_roll"): "mu_roll",
    ("friction", "mu_side"): "mu_side",
    ("friction", "axis"): "axis",
    ("drive", "speed_limit"): "speed_limit",
}
CODE = ("symbolic", "analysis", "proofs", "reports/sweeps")  # what answers follow from


@dataclass(frozen=True)
class Base:
    """The scene before anything varies.

    Attributes:
        document: its tables, with rule, radius and point as they were asked for.
        file: the scene, for messages.
        path: its file, whose name is the scene's where the document names none.
        wheels: the text of its table of wheels, where it has one.
    """

    document: Mapping[str, Any]
    file: str
    path: Path
    wheels: str | None = None

    def scene(self, paths: Sequence[KeyPath], entries: Sequence[Entry]) -> Scene:
        """One scene of the sweep.

        Raises:
            SceneError: for values that cannot be used.
        """
        return build_scene(self.with_entries(paths, entries), self.file, self.path, wheels=self.wheels)

    @property
    def is_system(self) -> bool:
        """Whether it is a plain system, not an array."""
        return "system" in self.document

    def system(self, paths: Sequence[KeyPath], entries: Sequence[Entry]) -> SwitchedSystem:
        """One plain system of the sweep.

        Raises:
            SceneError: for values that cannot be used.
        """
        return build_system(self.with_entries(paths, entries), self.file, self.path)

    def with_entries(self, paths: Sequence[KeyPath], entries: Sequence[Entry]) -> dict[str, Any]:
        """The document with these entries in their places."""
        document = dict(self.document)
        for path, entry in zip(paths, entries, strict=True):
            document = with_value(document, path, entry)
        return document

    def key(self, paths: Sequence[KeyPath], entries: Sequence[Entry], asked: str) -> str:
        """The hash of one scene of the sweep, of what is asked of it, and of the program."""
        document = self.with_entries(paths, entries)
        tables = {str(path[0]) for path in paths} - set(UNHEARD)
        varied = {name: _plain(document[name]) for name in tables}
        heard = {**self._heard, **varied}
        whole = {"scene": heard, "wheels": self.wheels, "asked": asked, "program": program_hash()}
        return hashlib.sha256(json.dumps(whole, sort_keys=True).encode()).hexdigest()

    @cached_property
    def _heard(self) -> dict[str, Any]:
        """The tables that answers follow from, as JSON, before anything varies."""
        return {name: _plain(value) for name, value in self.document.items() if name not in UNHEARD}


def base_of(document: Mapping[str, Any], file: str, path: Path, *, allow_outside: bool = False) -> Base:
    """The base of a document, whose table of wheels is read now: it may change on the disk meanwhile.

    Raises:
        SceneError: for a scene that cannot be used.
    """
    if "system" in document:
        if "contact" in document:
            raise SceneError(file, "contact.rule", "no contact rule for a plain switched system", document["contact"])
        base = Base(document, file, path)
        base.system((), ())
        return base
    base = Base(document, file, path, wheel_table(document, file, path, allow_outside=allow_outside))
    base.scene((), ())
    return base


def with_wheels(base: Base, names: Iterable[str]) -> Base:
    """The same with its wheels one by one, where a key path names one of a ring, a grid or a table."""
    asked = any(name.split(".")[0] == "wheel" for name in names)
    if not asked or not any(base.document.get(layout) for layout in ("ring", "grid", "wheels")):
        return base
    return Base(one_by_one(base.document, base.scene((), ())), base.file, base.path)


def require_heard(base: Base, plan: SweepPlan) -> None:
    """Refuse numbers of the scene that no wheel takes, since every wheel states its own.

    Raises:
        SceneError: naming the key, and that of the first wheel.
    """
    if base.is_system:
        return
    wheels = base.scene((), ()).wheels
    for axis in plan.axes:
        key = OF_ALL_WHEELS.get(axis.path[:2], "")
        if key and all(key in wheel.named for wheel in wheels):
            expected = f"a number that some wheel takes, such as wheel.1.{key} (every wheel states its own)"
            raise SceneError(base.file, "", expected, axis.name)


def entries_of(plan: SweepPlan, k: int) -> tuple[Entry, ...]:
    """The values of scene k as a scene file would hold them."""
    return tuple(value.entry for value in plan.point(k))


@cache
def program_hash() -> str:
    """Version of the program: a hash of the source files that answers follow from."""
    root = Path(__file__).resolve().parents[2]
    found = hashlib.sha256()
    for folder in CODE:
        for file in sorted((root / folder).rglob("*.py")):
            found.update(file.relative_to(root).as_posix().encode() + b"\0" + file.read_bytes() + b"\0")
    return found.hexdigest()


def _plain(value: Any) -> Any:
    """An entry as JSON: decimals and fractions by their exact value, so that 0.50 and "1/2" are one scene."""
    if isinstance(value, Mapping):
        return {str(key): _plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(entry) for entry in value]
    if isinstance(value, Decimal):
        return f"{Fraction(value)}" if value.is_finite() else str(value)
    if isinstance(value, str):
        return f"{Fraction(value)}" if _PLAIN.fullmatch(value) else value
    return value if isinstance(value, bool | int | None) else str(value)
