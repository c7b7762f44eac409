"""A V of a system in three states and more, with the conditions that were looked at."""

from __future__ import annotations

from dataclasses import dataclass

from nonsmooth.proofs.many_states.conditions import Questions
from nonsmooth.proofs.many_states.examination import (
    SLIDES_UP,
    Examination,
    by_face,
    find_failure,
    find_slide,
    questions_on,
)
from nonsmooth.proofs.many_states.sign_cells import SignCells
from nonsmooth.proofs.systems.derivatives import Decrease
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.piecewise import PiecewiseExpression, parse_piecewise
from nonsmooth.symbolic.switched_system import SwitchedSystem


@dataclass(frozen=True)
class ExaminedLyapunov:
    """A V with its conditions.

    Attributes:
        formula: V, in the displacement under the states' names.
        radius: half the side of the cube on which they are looked at.
        examination: the conditions with their evidence.
    """

    formula: PiecewiseExpression
    radius: Number
    examination: Examination

    def check(self, system: SwitchedSystem) -> bool:
        """Verify the evidence, and that it is about the system and the text of V; undecided, it claims nothing."""
        if self.examination.verdict is Decrease.UNDECIDED:
            return True
        cells, questions = questions_on(system, parse_piecewise(self.formula.text, system.states), self.radius)
        if self.examination.verdict is Decrease.REFUTED:
            return self._is_refuted(system, cells, questions)
        found = self.examination.inequalities
        if cells != self.examination.cells or list(questions.listed) != [i.question for i in found]:
            return False
        strict = all(i.proved is not None and i.proved.claim.strict for i in found)
        proved = all(i.proved is not None and i.check() for i in found)
        return proved and (strict or self.examination.verdict is Decrease.WEAK)

    def _is_refuted(self, system: SwitchedSystem, cells: SignCells, questions: Questions) -> bool:
        """Whether the point that refutes V is found again, in a cell or on some face."""
        failure = self.examination.failure
        if failure is None or failure.meaning != SLIDES_UP:
            return failure is not None and find_failure(cells, questions) == failure
        faces = by_face(questions.listed)
        return any(find_slide(system, self.formula, cells, asked) == failure for asked in faces)
