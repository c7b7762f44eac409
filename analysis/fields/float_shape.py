"""Friction sets that floats alone know."""

from __future__ import annotations

from typing import Any, NoReturn

from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.symbolic.mechanics.friction_set import CutEllipse


class FloatShape(CutEllipse[Any]):
    """A shape that floats alone know: bodies are followed, and whatever proves something refuses it.

    A shape on it writes ``searched``, ``support``, ``gauge``, ``excess``, ``nearest``, ``slip_cone``, ``room``,
    ``rounded_gradient`` and ``rounded_hessian``.  Slips r and s, and what ``support``, ``nearest``, ``excess`` and the
    rounded methods give, are about minus the force; ``gauge``, ``slip_cone`` and ``room`` are about the force.  Zero
    lies inside every set.
    """

    def piece(self, r: Any, s: Any) -> NoReturn:
        """Refused."""
        self.refuse()

    def gradient(self, r: Any, s: Any) -> NoReturn:
        """Refused."""
        self.refuse()

    def bend(self, r: Any, s: Any) -> NoReturn:
        """Refused."""
        self.refuse()

    def holds_strictly(self, x: Any, y: Any) -> NoReturn:
        """Refused."""
        self.refuse()

    def refuse(self) -> NoReturn:
        """Say that nothing is proved.

        Raises:
            RefusalError: always.
        """
        shape = type(self).__name__
        raise RefusalError(f"required friction sets with exact forces, received {shape}: nothing is proved of it")
