"""The headings at which a body with an outline rests, written down: rows for a terminal and a report, and JSON."""

from __future__ import annotations

from collections import Counter
from math import degrees
from typing import TYPE_CHECKING

from flint import arb

from nonsmooth.proofs.findings import Quantity, Record
from nonsmooth.reports.output.document import Block, Table, sentences, table
from nonsmooth.reports.output.facts import as_record
from nonsmooth.symbolic.mechanics.units import Units
from nonsmooth.symbolic.numbers.enclosures import rational_above, rational_below
from nonsmooth.symbolic.numbers.number_text import float_text, lower_text, numbers_text, place_text, upper_text

if TYPE_CHECKING:
    from collections.abc import Sequence

    from nonsmooth.proofs.answers.heading import HeadingOfRest, HeadingsOfRest
    from nonsmooth.proofs.headings.at_point import OpenHeadings

DIGITS = 4
ROUNDED = 1e-12  # coordinates below are zero but for rounding
MOST_SHOWN = 10  # entries on a terminal and in a report
MOST_OPEN = 4  # ranges that are not decided and listed there
MOST_REASONS = 2
HEADER = ("theta", "at", "wheels", "near there", "heading", "status")


def headings_blocks(headings: HeadingsOfRest) -> list[Block]:
    """What a terminal shows: a table of the entries, those that attract first, and what is not known."""
    return [*sentences(title(headings)), *headings_table(headings), *sentences(*notes(headings))]


def headings_table(headings: HeadingsOfRest) -> list[Table]:
    """The entries, where there are any."""
    rows = [row(entry, headings.units) for entry in headings.found[:MOST_SHOWN]]
    return [table(HEADER, rows, (3, 3, 4, 2, 2, 2))] if rows else []


def title(headings: HeadingsOfRest) -> str:
    """What was looked for, where."""
    where = "at the checked point"
    if headings.reach is not None:
        where += f" and, as a search found, within {float_text(headings.reach, DIGITS)} of it along x and y"
    found = "" if headings.found else " none"
    return f"equilibrium headings {where} (theta in {headings.units.angle} from the checked heading):{found}"


def notes(headings: HeadingsOfRest) -> list[str]:
    """How many entries are not shown, what is proved of all other headings, and what is not decided or not found."""
    hidden = len(headings.found) - MOST_SHOWN
    said = [f"{hidden} more (--json lists them)"] if hidden > 0 else []
    every = any(entry.is_every_heading for entry in headings.found)
    if headings.undecided:
        left = _open_text(headings.undecided, headings.units)
        said.append(f"not decided at the checked point: {left}; simulate --headings 36 samples which return")
    if not every:
        listed = ["those listed, with the ends of ranges"] if any(entry.rests for entry in headings.found) else []
        besides = [*listed, *(["those not decided"] if headings.undecided else [])]
        but = f" but {' and '.join(besides)}" if besides else ""
        said.append(f"at the checked point the body is proved to rest, without turning, at no heading{but}")
    if headings.left_out:
        said.append(f"{headings.left_out} more points of rest on one set of wheels were seen and not decided")
    if headings.reach is not None:
        said.append("off the checked point the search may have missed some, and it looks for none with several wheels")
        said[-1] += " under the edge"
    elif headings.can_search:
        said.append("off the checked point they are not looked for (--headings does)")
    return said


def _open_text(undecided: Sequence[OpenHeadings], units: Units) -> str:
    """Each of a few; of many how many there are, and how much of a turn they are together."""
    if len(undecided) > MOST_OPEN:
        ranges = [float(one.high - one.low) for one in undecided if not one.edge]
        counted = [f"{len(ranges)} ranges, {_heading(sum(ranges), units)} {units.angle} together"] if ranges else []
        single = len(undecided) - len(ranges)
        counted += [f"{single} single headings"] if single else []
        reasons = Counter(one.reason for one in undecided if one.reason)
        why = ", ".join(f"{reason} ({count})" for reason, count in reasons.most_common(MOST_REASONS))
        return f"{' and '.join(counted)} (--json lists them){f': {why}' if why else ''}"
    texts = [
        _heading(float(one.low), units) if one.edge else f"{_below(one.low, units)} to {_above(one.high, units)}"
        for one in undecided
    ]
    return f"theta = {', '.join(texts)}"


def row(entry: HeadingOfRest, units: Units) -> tuple[str, str, str, str, str, str]:
    """One entry in words, under :data:`HEADER`."""
    wheels = numbers_text(entry.wheels)
    if entry.low is None and entry.edge:
        wheels += f"; under the edge {numbers_text(entry.edge)}"
    status = "proved" if entry.proved else "sampled"
    return (
        theta_text(entry, units),
        place_text((_plain(float(value)) for value in entry.at), DIGITS),
        wheels,
        str(entry.position),
        str(entry.verdict),
        status,
    )


def theta_text(entry: HeadingOfRest, units: Units) -> str:
    """``0.1 to 0.3``, rounded inward; or one heading."""
    if entry.is_every_heading:
        return "every heading"
    if entry.low is not None and entry.high is not None:
        return f"{_above(entry.low, units)} to {_below(entry.high, units)}"
    about = "about " if not entry.proved else ""
    return about + _heading(0.0 if entry.heading is None else float(entry.heading), units)


def headings_record(headings: HeadingsOfRest) -> Record:
    """JSON: where was searched, and every entry."""
    entries = [
        as_record(
            {
                "kind": str(entry.kind),
                "from": Quantity(entry.low),
                "to": Quantity(entry.high),
                "heading": Quantity(entry.heading),
                "at": Quantity(entry.at),
                "wheels": list(entry.wheels),
                "edge": list(entry.edge),
                "position": str(entry.position),
                "verdict": str(entry.verdict),
                "status": "proved" if entry.proved else "sampled",
                "reason": entry.reason or None,
            }
        )
        for entry in headings.found
    ]
    undecided = [
        as_record(
            {"from": Quantity(one.low), "to": Quantity(one.high), "edge": list(one.edge), "reason": one.reason or None}
        )
        for one in headings.undecided
    ]
    return {
        "searched_within": headings.reach,
        "left_out": headings.left_out,
        "undecided": undecided,
        "found": entries,
    }


def _heading(theta: float, units: Units) -> str:
    return float_text(_plain(degrees(theta) if units.in_degrees else theta), DIGITS)


def _above(ball: arb, units: Units) -> str:
    return upper_text(rational_above(_in_unit(ball, units)), DIGITS)


def _below(ball: arb, units: Units) -> str:
    return lower_text(rational_below(_in_unit(ball, units)), DIGITS)


def _in_unit(ball: arb, units: Units) -> arb:
    return ball * 180 / arb.pi() if units.in_degrees else ball


def _plain(value: float) -> float:
    """Rounding of zero as zero."""
    return 0.0 if abs(value) < ROUNDED else value
