"""Text of the files that a scene is made of: of bounded size, and beside the scene unless the user says otherwise."""

from __future__ import annotations

from pathlib import Path

from nonsmooth.symbolic.scene_error import SceneError, StatedFact

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
        found = StatedFact(f"other bytes at position {error.start}")
        raise SceneError(file, key, "a text file in UTF-8", found) from None
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
