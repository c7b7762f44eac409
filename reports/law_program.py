"""The certified feedback law of a check: a table, and a program of the standard library with one function."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pprint import pformat
from typing import TYPE_CHECKING, Any, ClassVar

from nonsmooth.reports.document import Block, Paragraph, table
from nonsmooth.reports.law_table import LawKind, LawTable, law_table
from nonsmooth.reports.result import FORMATS, DataTable, Record, Result, short_lines
from nonsmooth.symbolic.number_text import short_text
from nonsmooth.symbolic.scene_error import one_line

if TYPE_CHECKING:
    from nonsmooth.proofs.theorem4_result import Check

WIDTH = 100

_HEAD = '''"""The feedback law of {name}, rule {rule}, certified by nonsmooth.

speeds(x, y, theta) returns the speed of every rim, by the number of its wheel, for a body whose centre of mass is
displaced by (x, y) from the checked point {at} and turned by theta (radian).  It needs nothing but Python.
Wheels that are not named in a region do not carry the body there and may run at any speed.
It is certified {certified}.
{notes}The speeds are combinations of: {terms}.
"""

import math

'''

_PLACE = '''

def region_at(x, y):
    """The region that holds the displacement; between two of them, by rounding, the one it is deepest in."""
    def depth(region):
        return min(((a + b * x + c * y) / math.hypot(b, c) for a, b, c in region["sides"]), default=0.0)

    best = max(REGIONS, key=depth)
    if depth(best) < -1e-9 * SIZE:
        raise ValueError(f"required a place in a region of the law, received ({x}, {y})")
    return best
'''

_TERMS = {
    LawKind.GRADIENT: """    X, Y = (1 + E) * x + F * y, F * x + (1 - E) * y
    terms = X, Y, WEIGHT * theta + Y * x - X * y
""",
    LawKind.CASCADE: """    terms = math.hypot(x, y), x, y, theta
""",
    LawKind.SLOW_TURNS: """    ((a, b),) = region["axes"]
    r, s = a * x + b * y, a * y - b * x
    lead = s * s / (2 * r * LENGTH) if r > 0 else 0.0
    turn = s / LENGTH - (theta - lead)
    terms = (1 - turn) * r, turn
""",
}

_LINEAR = '''

def speeds(x, y, theta, k=1.0):
    """Rim speeds by wheel, with gain k (1/time)."""
    region = region_at(x, y)
{terms}    return {result}
'''

_LINEAR_RESULT = '{wheel: k * sum(c * t for c, t in zip(row, terms)) for wheel, row in region["speeds"].items()}'

_DRIVEN = '''

def speeds(x, y, theta, k=1.0):
    """Rim speeds by wheel, with gain k (1/time)."""
    region = region_at(x, y)
    products = [x * a + y * b + WEIGHT * theta * c for a, b, c in region["axes"]]
    chosen = max(range(len(products)), key=lambda index: abs(products[index]))
    return {result}
'''

_DRIVEN_RESULT = '{wheel: -k * products[chosen] * row[chosen] for wheel, row in region["speeds"].items()}'

_WITHIN_LIMITS = '''

def within_limits(speeds):
    """All speeds times one factor, where one of them would exceed its limit: the body takes the same way, later."""
    demand = max([abs(speeds[wheel]) / limit for wheel, limit in LIMITS.items() if wheel in speeds], default=0.0)
    return speeds if demand <= 1 else {wheel: speed / demand for wheel, speed in speeds.items()}
'''

_NAMES = {"e": "E", "f": "F", "w": "WEIGHT", "l": "LENGTH"}


@dataclass(frozen=True, repr=False)
class LawResult(Result):
    """A feedback law: in which region which wheel runs at which speed.

    Attributes:
        law: the regions and speeds; poses are measured from the checked point.
        at: the checked point, in words.
    """

    law: LawTable
    at: str

    formats: ClassVar[Mapping[str, Callable[[Any, str], bytes]]] = {
        ".py": lambda found, ending: found.program().encode(),
        ".csv": FORMATS[".csv"],
    }

    def program(self) -> str:
        """A Python file of the standard library with a function ``speeds(x, y, theta, k=1.0)``."""
        return law_program(self.law, self.at)

    def facts(self) -> Record:
        """The law as a record."""
        return {"scene": self.law.scene.name, "terms": str(self.law.kind), "speeds": self.law.rows()}

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


def certified_law_of(check: Check) -> LawResult:
    """The law that the feedback clause certifies.

    Raises:
        NoLawError: where it certifies none.
    """
    x, y = (short_text(value) for value in check.scene.check.equilibrium)
    return LawResult(law_table(check), f"({x}, {y})")


def law_program(law: LawTable, at: str) -> str:
    """The text of the file.

    Args:
        law: the law.
        at: the checked point, in words.
    """
    name = one_line(law.scene.name).replace("\\", "/").replace('"', "'")
    regions: list[dict[str, object]] = [
        {"name": region.name, "sides": region.sides, "speeds": dict(region.speeds), "axes": region.axes}
        for region in law.regions
    ]
    head = _HEAD.format(
        name=name, rule=law.scene.contact.rule, at=at, certified=law.certified, terms=law.kind, notes=_notes(law)
    )
    constants = {_NAMES[key]: value for key, value in law.constants.items()} | {"SIZE": float(law.scene.check.radius)}
    lines = "".join(f"{key} = {value!r}\n" for key, value in constants.items())
    limits = {index: float(limit) for index, limit in law.scene.speed_limits.items()}
    lines += f"LIMITS = {limits!r}\n" if limits else ""
    scaling = _WITHIN_LIMITS if limits else ""
    regions_text = pformat(regions, width=WIDTH, sort_dicts=False)
    return f"{head}{lines}REGIONS = {regions_text}\n{_PLACE}{scaling}{_speeds_function(law.kind, limited=bool(limits))}"


def _notes(law: LawTable) -> str:
    """Lines on the units of the scene, and on how fast wheels run at most; none where these are not known."""
    units = law.scene.units
    notes = [f"Lengths are in {units.length}, speeds in {units.speed}, times in {units.time}."] if units.length else []
    notes += [f"No rim is asked for a speed above {law.effort}."] if law.effort else []
    return "".join(f"{note}\n" for note in notes)


def _speeds_function(kind: LawKind, *, limited: bool) -> str:
    """The function ``speeds`` of the file."""
    result = _DRIVEN_RESULT if kind is LawKind.DRIVEN else _LINEAR_RESULT
    result = f"within_limits({result})" if limited else result
    if kind is LawKind.DRIVEN:
        return _DRIVEN.format(result=result)
    return _LINEAR.format(terms=_TERMS[kind], result=result)
