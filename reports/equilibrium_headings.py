"""The headings at which a body with an outline rests, written down: rows for a terminal and a report, and JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rich.console import Group, RenderableType
from rich.text import Text

from nonsmooth.proofs.answers.contact import numbers_text
from nonsmooth.proofs.facts import Quantity
from nonsmooth.reports.exact_record import Record
from nonsmooth.reports.facts import as_record
from nonsmooth.reports.terminal import header_table
from nonsmooth.symbolic.number_text import float_text, lower_text, place_text, upper_text
from nonsmooth.symbolic.numbers.enclosures import rational_below

if TYPE_CHECKING:
    from flint import arb

    from nonsmooth.proofs.answers.headings import HeadingOfRest, HeadingsOfRest

DIGITS = 4
ROUNDED = 1e-12  # coordinates below are zero but for rounding
MOST_SHOWN = 10  # entries on a terminal and in a report
HEADER = ("theta", "at", "wheels", "near there", "heading", "status")


def headings_view(headings: HeadingsOfRest) -> RenderableType:
    """A table of the entries that attract first."""
    if not headings.found:
        return Text(title(headings))
    table = header_table(*HEADER, widest="wheels")
    for entry in headings.found[:MOST_SHOWN]:
        table.add_row(*row(entry))
    rest = more(headings)
    return Group(Text(title(headings)), table, *([Text(rest)] if rest else []))


def title(headings: HeadingsOfRest) -> str:
    """What was looked for, where."""
    where = "at the checked point"
    if headings.reach is not None:
        where = f"within {float_text(headings.reach, DIGITS)} of the checked point along x and y"
    found = "" if headings.found else " none found"
    return f"equilibrium headings {where} (theta in rad from the checked heading; a search may miss some):{found}"


def more(headings: HeadingsOfRest) -> str:
    """How many entries are not shown, and how many points were not decided."""
    hidden = len(headings.found) - MOST_SHOWN
    parts = [f"{hidden} more (--json lists them)"] if hidden > 0 else []
    if headings.left_out:
        parts.append(f"{headings.left_out} more points of rest on one set of wheels were seen and not decided")
    return "; ".join(parts)


def row(entry: HeadingOfRest) -> tuple[str, str, str, str, str, str]:
    """One entry in words, under :data:`HEADER`."""
    wheels = numbers_text(entry.wheels)
    if entry.low is None and entry.edge:
        wheels += f"; under the edge {numbers_text(entry.edge)}"
    status = "proved" if entry.proved else "sampled"
    return (
        theta_text(entry),
        place_text((_plain(float(value)) for value in entry.at), DIGITS),
        wheels,
        str(entry.position),
        str(entry.verdict),
        status,
    )


def theta_text(entry: HeadingOfRest) -> str:
    """``0.1 to 0.3``, rounded inward; or one heading."""
    if entry.is_every_heading:
        return "every heading"
    if entry.low is not None and entry.high is not None:
        return f"{_above(entry.low)} to {_below(entry.high)}"
    about = "about " if not entry.proved else ""
    return about + float_text(0.0 if entry.heading is None else float(entry.heading), DIGITS)


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
    return {"searched_within": headings.reach, "left_out": headings.left_out, "found": entries}


def _above(ball: arb) -> str:
    return upper_text(-rational_below(-ball), DIGITS)


def _below(ball: arb) -> str:
    return lower_text(rational_below(ball), DIGITS)


def _plain(value: float) -> float:
    """Rounding of zero as zero."""
    return 0.0 if abs(value) < ROUNDED else value
