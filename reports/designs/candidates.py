"""Candidates of a search for designs: each is built and judged once, however often the search comes back to it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Generic, TypeAlias, TypeVar

from nonsmooth.reports.designs.freedom import Freedom
from nonsmooth.symbolic.files.scene_file import build_scene
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.scene_error import SceneError

Worth = TypeVar("Worth")
Told: TypeAlias = Callable[[int, int], None]  # candidates checked, and allowed


class Candidates(ABC, Generic[Worth]):
    """What was checked of a search, and what each candidate is worth.

    Args:
        base: the document of the given scene.
        folder: where its files lie.
        scene: the same, read.
        freedom: what may change.
        most: candidates that may be checked.
    """

    def __init__(self, base: Mapping[str, Any], folder: Path, scene: Scene, freedom: Freedom, most: int) -> None:
        self._base, self._folder, self._scene, self._freedom, self._most = base, folder, scene, freedom, most
        self._known: dict[str, Worth] = {}

    @property
    def checks(self) -> int:
        """How many were checked."""
        return len(self._known)

    def worth(self, vector: Sequence[float], told: Told) -> Worth:
        """Of the candidate that a vector names."""
        document = self._freedom.document(self._base, self._scene, vector)
        key = repr(document["wheel"])
        if key not in self._known:
            self._known[key] = self._built_and_judged(document)
            told(self.checks, self._most)
        return self._known[key]

    def _built_and_judged(self, document: dict[str, Any]) -> Worth:
        name = str(document.get("name") or self._scene.name)
        try:
            scene = build_scene(document, name, self._folder / f"{name}.toml")
        except SceneError as error:
            return self._refused(error)
        return self._judge(scene, document)

    @abstractmethod
    def _refused(self, error: SceneError) -> Worth:
        """Of a document that is no scene."""

    @abstractmethod
    def _judge(self, scene: Scene, document: dict[str, Any]) -> Worth:
        """Of a scene."""
