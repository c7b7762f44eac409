"""A design, as a script or a notebook holds it: an array that meets requirements and does best, with its answers."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nonsmooth.reports.designs.named import find_named
from nonsmooth.reports.designs.request import read_freedom, read_wish
from nonsmooth.reports.designs.search import Design, Wish
from nonsmooth.reports.designs.toml_text import toml_text
from nonsmooth.reports.designs.views import WHAT, design_record, headline
from nonsmooth.reports.files import output_path, write_whole
from nonsmooth.reports.short_text import short_lines
from nonsmooth.symbolic.number_text import float_text

if TYPE_CHECKING:
    from nonsmooth.reports.interface.made_array import MadeArray

DIGITS = 4


@dataclass(frozen=True, repr=False)
class DesignResult:
    """What a search for a better array found.

    Attributes:
        design: the scene of the best candidate, its answers, and those of the given array.
        wish: what was required and maximized.
        array: the best candidate, as a :class:`nonsmooth.Array`; the given array where none is better.
    """

    design: Design
    wish: Wish
    array: MadeArray

    @property
    def is_found(self) -> bool:
        """Whether the best candidate meets every requirement."""
        return self.design.is_found

    @property
    def value(self) -> float | None:
        """What was maximized, of the best candidate; None where it is not known."""
        return self.design.best.value

    @property
    def given_value(self) -> float | None:
        """The same of the given array."""
        return self.design.base.value

    @property
    def unmet(self) -> tuple[str, ...]:
        """The requirements that the best candidate does not meet."""
        return tuple(self.design.best.unmet)

    @property
    def impossible(self) -> str:
        """Why nothing that may change meets the requirements; empty where that is not known."""
        return self.design.impossible

    def to_dict(self) -> dict[str, Any]:
        """The JSON record of ``nonsmooth design --json``."""
        return design_record(self.design, self.wish)

    def save(self, file: str | Path) -> Path:
        """Write the scene of the best candidate as a file: .toml.

        Raises:
            OutputError: for another ending, and for a file that cannot be written.
        """
        path = output_path(str(file), (".toml",))
        write_whole(path, toml_text(self.design.document).encode())
        return path

    def __repr__(self) -> str:
        rows = [(answer.name, f"{answer.verdict}: {answer.sentence}") for answer in self.design.best.answers]
        objective = self.wish.maximize
        rows += [(objective, f"{_text(self.value)}, {WHAT[objective]}; of the given array {_text(self.given_value)}")]
        return short_lines(headline(self.design, self.wish), rows)


def _text(value: float | None) -> str:
    return "-" if value is None else float_text(value, DIGITS)


def design_array(
    array: MadeArray,
    *,
    free: str,
    require: str,
    maximize: str,
    move: Any,
    symmetry: int | None,
    checks: int,
    seed: int,
) -> DesignResult:
    """Search for a better array; see :meth:`nonsmooth.reports.interface.array.Array.design`.

    Raises:
        SceneError: for a tolerance to maximize that the array does not state.
        DesignError: for what cannot be used.
    """
    wish = read_wish(array.scene, require, maximize, checks, seed)
    freedom = read_freedom(array.scene, free, move, symmetry)
    design = find_named(array.document, array.folder, array.scene, freedom, wish, _untold)
    return DesignResult(design, wish, type(array).of_document(design.document, array.folder))


def _untold(done: int, allowed: int) -> None:
    """Nobody is told how far the search is."""
