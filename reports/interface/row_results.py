"""Results that are rows, and their table of pandas, which is not required."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Any


class Tabular(ABC):
    """A result that can be read row by row."""

    @abstractmethod
    def rows(self) -> Sequence[Mapping[str, Any]]:
        """One mapping for each row, all with the same keys."""

    def to_dataframe(self) -> Any:
        """The rows as a pandas DataFrame, where pandas is installed.

        Raises:
            ImportError: where it is not.
        """
        return import_module("pandas").DataFrame(self.rows())
