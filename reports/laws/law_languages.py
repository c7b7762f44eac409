"""A feedback law as a program: one header and one function, in Python, C and Structured Text (IEC 61131-3).

Every program does the same: it finds the region that holds the displacement c, forms the few terms of which the speeds
are combinations there (:class:`~nonsmooth.analysis.fields.feedback_laws.LawKind`), and scales all speeds by one factor
where one of them would exceed its limit.  D is homogeneous in twist and speeds together, so such a factor changes how
fast the body moves and not where to.  To add a language, write a function from a law and the lines of its header to a
text, and list it in :data:`LANGUAGES`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from fractions import Fraction
from pprint import pformat
from textwrap import wrap
from typing import TYPE_CHECKING, ClassVar

from nonsmooth.analysis.fields.feedback_laws import LawKind
from nonsmooth.proofs.answers.answer import how_far
from nonsmooth.proofs.findings import Record
from nonsmooth.reports.laws.law_table import LawRegion, LawTable, law_table
from nonsmooth.reports.output.document import Block, sentences, table
from nonsmooth.reports.output.study_options import LawName
from nonsmooth.reports.studies.result import FORMATS, DataTable, Formats, Result, short_lines
from nonsmooth.symbolic.numbers.number_text import exact_place, float_text, numbers_text

if TYPE_CHECKING:
    from nonsmooth.proofs.theorem4 import Check


WIDTH = 100  # of lines
TIED = "\N{NO-BREAK SPACE}"  # in place of a space at which no line ends
_FRACTION = re.compile(r"\b\d+/[1-9]\d*\b")
_NAMES = {"e": "E", "f": "F", "w": "WEIGHT", "l": "LENGTH"}


class Language(StrEnum):
    """What a law is written in; the value is the ending of the file."""

    PYTHON = ".py"
    C = ".c"
    STRUCTURED_TEXT = ".st"


def header(law: LawTable, at: str, language: Language) -> list[str]:
    """What whoever runs the program must know: scene, law, units, region, rate, largest speeds."""
    units = law.scene.units
    by = "by the number of its wheel" if language is Language.PYTHON else "each in its place, named beside the result"
    said = [
        f"The feedback law of {_plain(law.scene.name)}, rule {law.scene.contact.rule}, {law.status}; by nonsmooth.",
        f"The law: {law.formula}",
        f"The checked point is {at}; x, y: displacement of the centre of mass from it; theta: turn (radian).",
        "k: gain (1/time), 1 unless another is given; every speed is proportional to it.",
        f"The result is the speed of every rim, {by}.",
        "Wheels that are not named in a region do not carry the body there and may run at any speed.",
        f"It is certified {law.certified}." if law.is_certified else "It is NOT certified: simulate it before use.",
    ]
    if law.scene.body is not None:
        far = how_far(law.scene, "the checked point", "the checked heading")
        carrying = _plain(numbers_text(law.scene.numbers))
        said.append(f"It is about the body on wheels {carrying} and no others: they carry it for certain {far}.")
    said.append(f"Where it does not return the body: {'; '.join(_where_not(law))}.")
    said += [f"Which k: {law.gains}."] if law.gains else []
    named = [f"{w.index:d} {_plain(str(w.index))}" for w in law.scene.wheels if str(w.index) != f"{w.index:d}"]
    said += [f"The wheels by number and name: {', '.join(named)}."] if named else []
    if units.length:
        said.append(f"Units: {units.length} (lengths), {units.speed} (speeds), {units.time} (times).")
    said += [f"Rate: {law.rate}."] if law.rate else []
    said += [f"No rim is asked for a speed above {law.effort}."] if law.effort else []
    stated = "those of the scene" if law.scene.speed_limits else "the scene states none"
    said.append(f"Limits of speed: {stated}.")
    said.append("Where one would be exceeded all speeds are scaled by one factor: the body takes the same way, later.")
    said.append(f"The speeds are combinations of: {law.kind}.")
    said = [_FRACTION.sub(_decimal, sentence) if units.length else sentence for sentence in said]
    return [line for sentence in said for line in _wrapped(sentence.replace(" = ", f"{TIED}={TIED}"), WIDTH, "  ")]


def _wrapped(text: str, width: int, indent: str = "") -> list[str]:
    """Lines of a text, in which tied words stay together."""
    return [line.replace(TIED, " ") for line in wrap(text, width, subsequent_indent=indent)]


def _where_not(law: LawTable) -> Iterator[str]:
    """Where nobody should count on the law: on other wheels, outside of its regions and of the certified starts."""
    if any(region.sides for region in law.regions) and law.kind is not LawKind.DRIVEN:
        yield "outside of its regions it gives no speed (region 0 and rims at rest; in Python a ValueError)"
    else:
        yield "it gives speeds at every place, and does not say when it cannot return the body"
    yield f"nothing is proved from {'other starts than those named' if law.is_certified else 'any start'}"
    if law.scene.body is not None:
        yield "as soon as other wheels carry the body its speeds are the wrong ones, and it does not ask which carry"


def _decimal(fraction: re.Match[str]) -> str:
    """A fraction of a scene with units as a decimal, as people wrote its numbers; the program holds floats."""
    return float_text(Fraction(fraction[0]), 12)


def _order(law: LawTable, first: int) -> list[str]:
    """Which wheel each place of an array of speeds belongs to, whose places are counted from ``first``."""
    places = (
        f"[{k}] {_wheel_words(wheel.index)}".replace(" ", TIED) for k, wheel in enumerate(law.scene.wheels, first)
    )
    return _wrapped(f"speeds by wheel: {', '.join(places)}", WIDTH - 10)


def _wheel_words(index: int) -> str:
    """``wheel 2``, or ``wheel 2 A2`` of a table with names."""
    named = str(index) != f"{index:d}"
    return f"wheel {index:d}{' ' + _plain(str(index)) if named else ''}"


def _plain(text: str) -> str:
    """A name as ASCII on one line, without what may end a comment or a string in any of the languages."""
    shown = " ".join(text.split()).encode("ascii", "replace").decode()
    return shown.replace("\\", "/").replace('"', "'").replace("*", "x")


def _comment(line: str) -> str:
    """A line of a header that may hold formulas, so that it neither ends nor begins a comment."""
    return line.replace("*)", "* )").replace("(*", "( *").replace("*/", "* /").replace("/*", "/ *")


# ---- Python --------------------------------------------------------------------------------------

_PYTHON_HEAD = '''"""{head}

speeds(x, y, theta) returns the speed of every rim.  It needs nothing but Python.
"""

import math

'''

_PYTHON_PLACE = '''

def region_at(x, y):
    """The region that holds the displacement; between two of them, by rounding, the one it is deepest in."""
    def depth(region):
        return min(((a + b * x + c * y) / math.hypot(b, c) for a, b, c in region["sides"]), default=0.0)

    best = max(REGIONS, key=depth)
    if depth(best) < -1e-9 * SIZE:
        raise ValueError(f"required a place in a region of the law, received ({x}, {y})")
    return best


def within_limits(speeds):
    """All speeds times one factor, where one of them would exceed its limit: the body takes the same way, later."""
    demand = max([abs(speeds[wheel]) / limit for wheel, limit in LIMITS.items() if wheel in speeds], default=0.0)
    return speeds if demand <= 1 else {wheel: speed / demand for wheel, speed in speeds.items()}


def speeds(x, y, theta, k=1.0):
    """Rim speeds by wheel, with gain k (1/time)."""
    if not all(abs(value) < 1e100 for value in (x, y, theta, k)):  # of no size: not a number, infinite
        raise ValueError(f"required a pose and a gain of sizes below 1e100, received {(x, y, theta, k)}")
    region = region_at(x, y)
'''

_PYTHON_TERMS = {
    LawKind.GRADIENT: """    X, Y = (1 + E) * x + F * y, F * x + (1 - E) * y
    terms = X, Y, WEIGHT * theta + Y * x - X * y
""",
    LawKind.CASCADE: """    terms = math.hypot(x, y), x, y, theta
""",
    LawKind.PAPER: """    terms = math.hypot(x, y), abs(theta), theta
""",
    LawKind.SLOW_TURNS: """    ((a, b),) = region["axes"]
    r, s = a * x + b * y, a * y - b * x
    lead = s * s / (2 * r * LENGTH) if r > 0 else 0.0
    turn = s / LENGTH - (theta - lead)
    terms = (1 - turn) * r, turn
""",
    LawKind.DRIVEN: """    products = [x * a + y * b + WEIGHT * theta * c for a, b, c in region["axes"]]
    chosen = max(range(len(products)), key=lambda index: abs(products[index]))
""",
}

_LINEAR = '{wheel: k * sum(c * t for c, t in zip(row, terms)) for wheel, row in region["speeds"].items()}'
_DRIVEN = '{wheel: -k * products[chosen] * row[chosen] for wheel, row in region["speeds"].items()}'


def python_program(law: LawTable, head: Sequence[str]) -> str:
    """A file of the standard library with a function ``speeds(x, y, theta, k=1.0)`` to a mapping by wheel."""
    regions: list[dict[str, object]] = [
        {"name": region.name, "sides": region.sides, "speeds": dict(region.speeds), "axes": region.axes}
        for region in law.regions
    ]
    limits = {index: float(limit) for index, limit in law.scene.speed_limits.items()}
    lines = "".join(f"{name} = {value!r}\n" for name, value in _constants(law))
    lines += f"LIMITS = {limits!r}  # of wheels, by their numbers\n"
    lines += f"REGIONS = {pformat(regions, width=WIDTH, sort_dicts=False)}\n"
    result = _DRIVEN if law.kind is LawKind.DRIVEN else _LINEAR
    text = _PYTHON_HEAD.format(head="\n".join(head)) + lines + _PYTHON_PLACE + _PYTHON_TERMS[law.kind]
    return f"{text}    return within_limits({result})\n"


def _constants(law: LawTable) -> list[tuple[str, float]]:
    constants = [(_NAMES[key], value) for key, value in law.constants.items()]
    return [*constants, ("SIZE", law.scene.check.half_width)]


# ---- tables of C and Structured Text ---------------------------------------------------------------


class _Tables:
    """The regions as arrays of one shape, padded with zeros.

    Attributes:
        wheels: the numbers of the wheels, in the order of the speeds.
        limits: theirs, zero where a wheel has none.
        side_counts, sides: of the regions (m,), (m, most sides, 3).
        axes: (m, most axes, 3), of a driven law and of slow turns.
        rows: the coefficients of the speeds (m, n, terms), zero for a wheel that is not driven.
    """

    def __init__(self, law: LawTable) -> None:
        """Of a law."""
        self.wheels = [int(wheel.index) for wheel in law.scene.wheels]
        limits = law.scene.speed_limits
        self.limits = [float(limits[wheel]) if wheel in limits else 0.0 for wheel in self.wheels]
        self.side_counts = [len(region.sides) for region in law.regions]
        self.sides = _padded([region.sides for region in law.regions], 3)
        self.axes = _padded([region.axes for region in law.regions], 3)
        terms = max(len(row) for region in law.regions for row in region.speeds.values())
        self.rows = [self._rows_of(region, terms) for region in law.regions]

    def _rows_of(self, region: LawRegion, terms: int) -> list[list[float]]:
        rows = [region.speeds.get(wheel, ()) for wheel in self.wheels]
        return [[*row, *[0.0] * (terms - len(row))] for row in rows]


def _padded(tables: Sequence[Sequence[Sequence[float]]], width: int) -> list[list[list[float]]]:
    """Tables of one height, at least one, and one width."""
    height = max(1, *(len(table) for table in tables))
    padded = []
    for entries in tables:
        rows = [[*row, *[0.0] * (width - len(row))] for row in entries]
        padded.append([*rows, *[[0.0] * width] * (height - len(rows))])
    return padded


# ---- C -------------------------------------------------------------------------------------------

_C_BODY = """
/* How deep the displacement lies in a region: negative outside of it. */
static double law_depth(int region, double x, double y)
{{
    double depth = 0.0;
    int side;
    for (side = 0; side < SIDE_COUNTS[region]; side++) {{
        const double *s = SIDES[region][side];
        double here = (s[0] + s[1] * x + s[2] * y) / sqrt(s[1] * s[1] + s[2] * s[2]);
        if (side == 0 || here < depth)
            depth = here;
    }}
    return depth;
}}

/* The speeds in the order of law_wheels. Returns the number of the region, from 1; 0 outside of all, with no speed. */
int law_speeds(double x, double y, double theta, double k, double speeds[LAW_WHEELS])
{{
    double terms[TERMS];
    double factor = k, demand = 1.0, deepest = 0.0;
    int region, wheel, term, best = 0;
    for (wheel = 0; wheel < LAW_WHEELS; wheel++)
        speeds[wheel] = 0.0;
    if (!(fabs(x) < 1e100 && fabs(y) < 1e100 && fabs(theta) < 1e100 && fabs(k) < 1e100))
        return 0; /* of no size: not a number, infinite */
    for (region = 0; region < REGIONS; region++) {{
        double depth = law_depth(region, x, y);
        if (region == 0 || depth > deepest) {{
            deepest = depth;
            best = region;
        }}
    }}
    if (deepest < -1e-9 * SIZE)
        return 0;
{terms}    for (wheel = 0; wheel < LAW_WHEELS; wheel++) {{
        for (term = 0; term < TERMS; term++)
            speeds[wheel] += factor * ROWS[best][wheel][term] * terms[term];
        if (law_limits[wheel] > 0.0 && fabs(speeds[wheel]) / law_limits[wheel] > demand)
            demand = fabs(speeds[wheel]) / law_limits[wheel];
    }}
    for (wheel = 0; wheel < LAW_WHEELS; wheel++)
        speeds[wheel] /= demand;
    return best + 1;
}}
"""

_C_TERMS = {
    LawKind.GRADIENT: """    terms[0] = (1 + E) * x + F * y;
    terms[1] = F * x + (1 - E) * y;
    terms[2] = WEIGHT * theta + terms[1] * x - terms[0] * y;
""",
    LawKind.CASCADE: """    terms[0] = sqrt(x * x + y * y);
    terms[1] = x;
    terms[2] = y;
    terms[3] = theta;
""",
    LawKind.PAPER: """    terms[0] = sqrt(x * x + y * y);
    terms[1] = fabs(theta);
    terms[2] = theta;
""",
    LawKind.SLOW_TURNS: """    {
        double along = AXES[best][0][0] * x + AXES[best][0][1] * y;
        double across = AXES[best][0][0] * y - AXES[best][0][1] * x;
        double lead = along > 0.0 ? across * across / (2 * along * LENGTH) : 0.0;
        terms[1] = across / LENGTH - (theta - lead);
        terms[0] = (1 - terms[1]) * along;
    }
""",
    LawKind.DRIVEN: """    {
        double largest = 0.0;
        int chosen = 0;
        for (term = 0; term < TERMS; term++) {
            const double *a = AXES[best][term];
            double product = x * a[0] + y * a[1] + WEIGHT * theta * a[2];
            if (fabs(product) > fabs(largest)) {
                largest = product;
                chosen = term;
            }
        }
        for (term = 0; term < TERMS; term++)
            terms[term] = term == chosen ? -largest : 0.0;
    }
""",
}


def c_program(law: LawTable, head: Sequence[str]) -> str:
    """C99 with nothing but ``math.h``: ``law_wheels``, ``law_limits`` and ``law_speeds``."""
    tables = _Tables(law)
    lines = ["/*", *(f" * {_comment(line)}" for line in head), " */", "", "#include <math.h>", ""]
    lines += [
        f"#define LAW_WHEELS {len(tables.wheels)}",
        f"#define REGIONS {len(law.regions)}",
        f"#define TERMS {len(tables.rows[0][0])}",
    ]
    lines += [f"static const double {name} = {value!r};" for name, value in _constants(law)]
    lines += ["", *(f"/* {_comment(line)} */" for line in _order(law, 0))]
    lines += [f"const int law_wheels[LAW_WHEELS] = {_braces(tables.wheels)};"]
    lines += [f"double law_limits[LAW_WHEELS] = {_braces(tables.limits)}; /* 0: none */"]
    lines += [f"static const int SIDE_COUNTS[REGIONS] = {_braces(tables.side_counts)};"]
    lines += [f"static const double SIDES[REGIONS][{len(tables.sides[0])}][3] = {_braces(tables.sides)};"]
    if law.kind in (LawKind.SLOW_TURNS, LawKind.DRIVEN):
        lines += [f"static const double AXES[REGIONS][{len(tables.axes[0])}][3] = {_braces(tables.axes)};"]
    lines += [f"static const double ROWS[REGIONS][LAW_WHEELS][TERMS] = {_braces(tables.rows)};", ""]
    return "\n".join(lines) + _C_BODY.format(terms=_C_TERMS[law.kind])


def _braces(table: Sequence[object], indent: str = "") -> str:
    """A nested table as an initializer, one innermost row a line."""
    if not isinstance(table[0], list):
        return f"{{{', '.join(map(repr, table))}}}"
    inner = indent + "    "
    rows = f",\n{inner}".join(_braces(row, inner) for row in table if isinstance(row, list))
    return f"{{\n{inner}{rows}}}"


# ---- Structured Text -----------------------------------------------------------------------------

_ST_BODY = """
FOR wheel := 1 TO {wheels} DO
    speeds[wheel] := 0.0;
END_FOR;
region := 1;
deepest := -1.0E300;
FOR candidate := 1 TO {regions} DO
    (* How deep the displacement lies in the region: negative outside of it. *)
    depth := 0.0;
    FOR side := 1 TO side_counts[candidate] DO
        here := (sides[candidate, side, 1] + sides[candidate, side, 2] * x + sides[candidate, side, 3] * y)
            / SQRT(sides[candidate, side, 2] * sides[candidate, side, 2]
                + sides[candidate, side, 3] * sides[candidate, side, 3]);
        IF side = 1 OR here < depth THEN
            depth := here;
        END_IF;
    END_FOR;
    IF depth > deepest THEN
        deepest := depth;
        region := candidate;
    END_IF;
END_FOR;
IF deepest >= -1.0E-9 * SIZE
    AND ABS(x) < 1.0E100 AND ABS(y) < 1.0E100 AND ABS(theta) < 1.0E100 AND ABS(k) < 1.0E100 THEN
{terms}    demand := 1.0;
    FOR wheel := 1 TO {wheels} DO
        FOR term := 1 TO {count} DO
            speeds[wheel] := speeds[wheel] + k * coefficients[region, wheel, term] * terms[term];
        END_FOR;
        IF limits[wheel] > 0.0 THEN
            demand := MAX(demand, ABS(speeds[wheel]) / limits[wheel]);
        END_IF;
    END_FOR;
    FOR wheel := 1 TO {wheels} DO
        speeds[wheel] := speeds[wheel] / demand;
    END_FOR;
ELSE
    region := 0; (* outside of all, not a number, or infinite: no speed *)
END_IF;
END_FUNCTION_BLOCK
"""

_ST_TERMS = {
    LawKind.GRADIENT: """    terms[1] := (1.0 + E) * x + F * y;
    terms[2] := F * x + (1.0 - E) * y;
    terms[3] := WEIGHT * theta + terms[2] * x - terms[1] * y;
""",
    LawKind.CASCADE: """    terms[1] := SQRT(x * x + y * y);
    terms[2] := x;
    terms[3] := y;
    terms[4] := theta;
""",
    LawKind.PAPER: """    terms[1] := SQRT(x * x + y * y);
    terms[2] := ABS(theta);
    terms[3] := theta;
""",
    LawKind.SLOW_TURNS: """    along := axes[region, 1, 1] * x + axes[region, 1, 2] * y;
    across := axes[region, 1, 1] * y - axes[region, 1, 2] * x;
    lead := 0.0;
    IF along > 0.0 THEN
        lead := across * across / (2.0 * along * LENGTH);
    END_IF;
    terms[2] := across / LENGTH - (theta - lead);
    terms[1] := (1.0 - terms[2]) * along;
""",
    LawKind.DRIVEN: """    largest := 0.0;
    chosen := 1;
    FOR term := 1 TO {count} DO
        terms[term] := 0.0;
        product := x * axes[region, term, 1] + y * axes[region, term, 2] + WEIGHT * theta * axes[region, term, 3];
        IF ABS(product) > ABS(largest) THEN
            largest := product;
            chosen := term;
        END_IF;
    END_FOR;
    terms[chosen] := -largest;
""",
}

_ST_LOCALS = {
    LawKind.SLOW_TURNS: ["along, across, lead : LREAL;"],
    LawKind.DRIVEN: ["largest, product : LREAL;", "chosen : INT;"],
}


def structured_text(law: LawTable, head: Sequence[str]) -> str:
    """A function block ``FB_Law`` of IEC 61131-3, which is called once in every cycle."""
    tables = _Tables(law)
    wheels, regions, count = len(tables.wheels), len(law.regions), len(tables.rows[0][0])
    constants = [f"{name} : LREAL := {_literal(value)};" for name, value in _constants(law)]
    constants += [f"wheels : {_array(tables.wheels, 'INT')}; (* their numbers *)"]
    constants += [f"side_counts : {_array(tables.side_counts, 'INT')};", f"sides : {_array(tables.sides)};"]
    if law.kind in (LawKind.SLOW_TURNS, LawKind.DRIVEN):
        constants += [f"axes : {_array(tables.axes)};"]
    constants += [f"coefficients : {_array(tables.rows)};"]
    variables = [
        "candidate, wheel, side, term : INT;",
        "depth, deepest, here, demand : LREAL;",
        f"terms : ARRAY[1..{count}] OF LREAL;",
        *_ST_LOCALS.get(law.kind, []),
    ]
    inputs = [
        "x : LREAL;",
        "y : LREAL;",
        "theta : LREAL;",
        "k : LREAL := 1.0;",
        f"limits : {_array(tables.limits)}; (* 0.0: none *)",
    ]
    outputs = [
        *(f"(* {_comment(line)} *)" for line in _order(law, 1)),
        f"speeds : ARRAY[1..{wheels}] OF LREAL;",
        "region : INT; (* 0: outside of all *)",
    ]
    blocks = (("VAR_INPUT", inputs), ("VAR_OUTPUT", outputs), ("VAR CONSTANT", constants), ("VAR", variables))
    lines = ["(*", *(f"   {_comment(line)}" for line in head), "*)", "FUNCTION_BLOCK FB_Law"]
    for name, declared in blocks:
        lines += [name, *(f"    {line}" for line in declared), "END_VAR"]
    terms = _ST_TERMS[law.kind].format(count=count)
    return "\n".join(lines) + _ST_BODY.format(wheels=wheels, regions=regions, count=count, terms=terms)


def _array(table: Sequence[object], kind: str = "LREAL") -> str:
    """The type of a nested table with its values, which go around the last index first."""
    shape, inner = [], table
    while isinstance(inner, list):
        shape.append(f"1..{len(inner)}")
        inner = inner[0]
    values = wrap(", ".join(_literal(value) for value in _leaves(table)), WIDTH)
    shown = "\n        ".join(["", *values]) if len(values) > 1 else values[0]
    return f"ARRAY[{', '.join(shape)}] OF {kind} := [{shown}]"


def _leaves(table: object) -> Iterable[float | int]:
    if isinstance(table, list):
        for entry in table:
            yield from _leaves(entry)
    elif isinstance(table, float | int):
        yield table


def _literal(value: float) -> str:
    """A number of Structured Text: reals have a point, ``1.0E-5``."""
    mantissa, _, exponent = repr(value).partition("e")
    if isinstance(value, float) and "." not in mantissa:
        mantissa += ".0"
    return f"{mantissa}E{int(exponent)}" if exponent else mantissa


LANGUAGES: dict[Language, Callable[[LawTable, Sequence[str]], str]] = {
    Language.PYTHON: python_program,
    Language.C: c_program,
    Language.STRUCTURED_TEXT: structured_text,
}


# ---- a law as Python users hold it ---------------------------------------------------------------
#
# A feedback law of a check, as Python users hold it: a function, a table, and programs in three languages.


@dataclass(frozen=True, repr=False)
class LawResult(Result):
    """A feedback law: in which region which wheel runs at which speed.  It can be called.

    Attributes:
        law: the regions and speeds; poses are measured from the checked point.
        at: the checked point, in words.
    """

    law: LawTable
    at: str

    formats: ClassVar[Formats] = {
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
        return LANGUAGES[chosen](self.law, header(self.law, self.at, chosen))

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
        return DataTable.of_rows(self.law.rows())

    def blocks(self) -> Sequence[Block]:
        """The terms, and the table."""
        names, lines = self.table()
        return [*sentences(str(self.law.kind)), table(names, lines)]

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
    return LawResult(law_table(check, name), exact_place(check.scene.check.equilibrium))
