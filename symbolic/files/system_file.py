"""Scene files of either kind: a wheel array, or with a ``[system]`` table a plain switched system."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from nonsmooth.symbolic.files.documents import builtin_systems, deep_nesting_refused, read_document
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact

if TYPE_CHECKING:
    from nonsmooth.symbolic.mechanics.scene import Scene
    from nonsmooth.symbolic.systems.switched_system import SwitchedSystem


def load_any(
    source: str | Path,
    *,
    rule: str | None = None,
    radius: str | None = None,
    at: str | None = None,
    accuracy: str | None = None,
    allow_outside: bool = False,
    exact: bool = False,
) -> Scene | SwitchedSystem:
    """Read a wheel array or a plain switched system, whichever the file holds.

    Args:
        source: a scene file or the name of a built-in one.
        rule: contact rule in place of the file's; refused for a system.
        radius: half-width of the checked square in place of the file's, in its unit of length.
        at: the checked point in place of the file's.
        accuracy: how near is near enough, in place of the file's (length).
        allow_outside: a scene may name tables outside its own folder.
        exact: numbers of a scene with units are written in exact forms, as those of all other scenes are.

    Raises:
        SceneError: for whatever cannot be used.
    """
    with deep_nesting_refused(source):
        data, file, path = read_document(source, rule=rule, radius=radius, at=at, accuracy=accuracy)
        if "system" not in data:
            from nonsmooth.symbolic.files.scene_file import build_scene  # a plain system does without

            scene = build_scene(data, file, path, rule=rule, allow_outside=allow_outside)
            scene.field.writes_decimals &= not exact
            return scene
        if rule is not None:
            raise SceneError(file, "contact.rule", "no contact rule for a plain switched system", str(rule))
        if accuracy is not None:
            raise SceneError(file, "check.accuracy", "no accuracy for a plain switched system", accuracy)
        from nonsmooth.symbolic.files.system_builder import build_system  # an array does without

        return build_system(data, file, path)


def load_system(source: str | Path, *, radius: str | None = None, at: str | None = None) -> SwitchedSystem:
    """Read a plain switched system.

    Args:
        source: path of a scene file, or the name of a built-in system.
        radius: half-width of the checked cube that replaces the file's, as text.
        at: equilibrium ``x,y`` that replaces the file's, as text.

    Raises:
        SceneError: for whatever cannot be used.
    """
    from nonsmooth.symbolic.files.system_builder import build_system

    with deep_nesting_refused(source):
        data, file, path = read_document(source, radius=radius, at=at)
        if "system" not in data:
            raise SceneError(file, "system", "a plain switched system, [system]", StatedFact("nothing"))
        return build_system(data, file, path)


def system_descriptions() -> dict[str, str]:
    """One line about each built-in system, by name."""
    return {name: read_document(name)[0]["description"] for name in builtin_systems()}
