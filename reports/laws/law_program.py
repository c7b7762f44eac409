"""A feedback law of a check, as Python users hold it: a function, a table, and programs in three languages."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from nonsmooth.reports.laws.law_languages import Language, header, law_program
from nonsmooth.reports.laws.law_table import LawTable, law_table
from nonsmooth.reports.output.document import Block, Paragraph, table
from nonsmooth.reports.output.study_options import LawName
from nonsmooth.reports.studies.result import FORMATS, DataTable, Record, Result, short_lines
from nonsmooth.symbolic.numbers.number_text import short_text

if TYPE_CHECKING:
    from nonsmooth.proofs.theorem4_result import Check


@dataclass(frozen=True, repr=False)
class LawResult(Result):
    """A feedback law: in which region which wheel runs at which speed.  It can be called.

    Attributes:
        law: the regions and speeds; poses are measured from the checked point.
        at: the checked point, in words.
    """

    law: LawTable
    at: str

    formats: ClassVar[Mapping[str, Callable[[Any, str], bytes]]] = {
        **{str(each): lambda found, ending: found.program(Language(ending)).encode() for each in Language},
        ".csv": lambda found, ending: found.comments().encode() + FORMATS[".csv"](found, ending),
    }

    def __call__(self, x: float, y: float, theta: float, k: float = 1.0) -> dict[int, float]:
        """The speed of every rim that is driven, by the number of its wheel, within the limits of speed.

        Args:
            x: displacement of the centre of mass from the checked point (length).
            y: the same.
            theta: turn of the body (radian).
            k: gain (1/time).

        Raises:
            ValueError: for a place that is in no region of the law.
        """
        return self.law.speeds(x, y, theta, k)

    def program(self, language: str = "python") -> str:
        """A program of its own: ``python`` (the standard library), ``c`` (C99), ``st`` (Structured Text, IEC 61131-3).

        Raises:
            ValueError: for another language.
        """
        known = {each.value.removeprefix("."): each for each in Language} | {"python": Language.PYTHON}
        chosen = known.get(language.lower().removeprefix("."))
        if chosen is None:
            raise ValueError(f"law: required a language among python, c, st, received {language[:60]!r}")
        return law_program(self.law, self.at, chosen)

    def comments(self) -> str:
        """What whoever programs a machine from the table must know, in lines that begin with ``#``: see ``header``."""
        constants = (f"{name} = {value!r}" for name, value in self.law.constants.items())
        return "".join(f"# {line}\n" for line in (*header(self.law, self.at, Language.PYTHON), *constants))

    def facts(self) -> Record:
        """The law as a record."""
        law = self.law
        said = {"law": law.formula, "certified": law.is_certified, "region": law.certified or None}
        said |= {"rate": law.rate or None, "largest_speed": law.effort or None}
        return {"scene": law.scene.name, **said, "terms": str(law.kind), "speeds": law.rows()}

    def table(self) -> DataTable:
        """One line for each region and wheel (and imposed twist): where, and the speed as a formula."""
        rows = self.law.rows()
        return DataTable(tuple(rows[0]), [tuple(row.values()) for row in rows])

    def blocks(self) -> Sequence[Block]:
        """The terms, and the table."""
        names, lines = self.table()
        return [Paragraph((str(self.law.kind),)), table(names, lines, (1.0,) * len(names))]

    def summary(self) -> str:
        """How many regions."""
        return f"{len(self.law.regions)} regions"

    def __repr__(self) -> str:
        head = f"law of {self.law.scene.name}, rule {self.law.scene.contact.rule}, measured from {self.at}"
        said = [(f"{row['region']}, wheel {row['wheel']}", row["speed"]) for row in self.rows()]
        return short_lines(head, [("terms", str(self.law.kind)), *said])


def law_of(check: Check, name: LawName = LawName.CERTIFIED) -> LawResult:
    """The law that the feedback clause certifies, or another by name (rule ``nearest``).

    Raises:
        NoLawError: where there is none.
    """
    x, y = (short_text(value) for value in check.scene.check.equilibrium)
    return LawResult(law_table(check, name), f"({x}, {y})")
