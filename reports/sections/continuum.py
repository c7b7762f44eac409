"""The continuous idealization in the derivation report."""

from __future__ import annotations

from nonsmooth.analysis.continuum.idealization import NoIdealizationError, predictions
from nonsmooth.proofs.theorem4_result import Check
from nonsmooth.reports.continuum import HEADER, NOTE, continuum_rows, field_text
from nonsmooth.reports.document import Section, display, table
from nonsmooth.reports.prose import paragraph


def continuum_section(result: Check) -> Section | None:
    """What a continuous field would do to an object, beside what the array does; None where no field stands for it."""
    try:
        found = predictions(result.scene)
    except NoIdealizationError:
        return None
    balance = display(
        r"F = \int f \, dA, \qquad M = \int (p - c) \times f \, dA",
        "F = int f dA, M = int (p - c) x f dA",
    )
    words = paragraph(
        "The wheels sample one field: {}. If every point p of the object's footprint were pushed by a force per area "
        "along it, force and moment about the centroid would be",
        field_text(found[0].field),
    )
    rest = paragraph(
        "and the object would rest where both vanish, at stable headings where the moment turns back. That is what "
        "many small actuators would do; the last row is what these few wheels do."
    )
    note = paragraph("The first rows are {}.", NOTE)
    rows = table(HEADER, continuum_rows(found, [result]), (3, 4, 6))
    return Section("The continuous idealization", (words, balance, rest, rows, note))
