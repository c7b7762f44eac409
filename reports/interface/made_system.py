"""What is made from the tables of a scene file with ``[system]``; refused at once where they cannot be used."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Self, TypeVar

Exact = TypeVar("Exact")


class MadeSystem:
    """Holds the tables; a class that inherits says in ``system`` what they mean exactly."""

    document: Mapping[str, Any]

    @property
    def system(self) -> Any:
        """The exact system."""
        raise NotImplementedError

    def _set(self, document: Mapping[str, Any]) -> None:
        object.__setattr__(self, "document", document)
        _ = self.system  # refuse what cannot be used at once

    def _read(self, build: Callable[[dict[str, Any], str, Path], Exact], unnamed: str) -> Exact:
        """What a reader of scene files makes of the tables; errors name the system, or else what it is."""
        from nonsmooth.symbolic.files.scene_file import deep_nesting_refused

        name = self.document.get("name")
        label = name if isinstance(name, str) and name.strip() else unnamed
        with deep_nesting_refused(label):
            return build(dict(self.document), label, Path(f"{label}.toml"))

    @classmethod
    def of_document(cls, document: Mapping[str, Any]) -> Self:
        """The system of a scene file's tables.

        Raises:
            SceneError: for whatever cannot be used.
        """
        system = cls.__new__(cls)
        system._set(document)
        return system
