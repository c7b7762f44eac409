"""What is made from the tables of a scene file with ``[system]``; refused at once where they cannot be used."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Self


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

    @classmethod
    def of_document(cls, document: Mapping[str, Any]) -> Self:
        """The system of a scene file's tables.

        Raises:
            SceneError: for whatever cannot be used.
        """
        system = cls.__new__(cls)
        system._set(document)
        return system
