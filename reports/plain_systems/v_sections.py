"""What decides the stability of a plain system: its Lyapunov function with region and rate, or its leading terms."""

from __future__ import annotations

from nonsmooth.proofs.system_facts import gain_words, rate_words, region_rate_words, region_words
from nonsmooth.proofs.systems.findings import DERIVATIVES, ExaminedFunction, Method
from nonsmooth.proofs.systems.search import PlaneFunction
from nonsmooth.reports.document import Block, Code, Entry, Section, number, point, table
from nonsmooth.reports.plain_systems.system_formulas import polynomial_math
from nonsmooth.reports.plain_systems.system_subject import SystemSubject
from nonsmooth.reports.prose import paragraph

LADDER = (
    "Three sets bound the derivative of V along solutions, each inside the one before, and the last one decides: all "
    "products of gradients and velocities that meet at a point (naive), the set of Shevitz and Paden, and that of "
    "Bacciotti and Ceragioli. Their signs over the domain without the point:"
)


def lyapunov_section(subject: SystemSubject) -> Section:
    """The V that proves the verdict, with the derivatives, its region and its rate; else what the scene's V shows."""
    result, reach, states = subject.result, subject.result.reach, subject.system.states
    shown = result.function or result.given
    if shown is None:
        raise TypeError("required a system in two states")
    blocks: list[Block] = [paragraph("{} on {}:", Code(f"V = {shown.text}"), shown.domain.text(states))]
    blocks.append(paragraph("{}", _meaning(subject, shown)))
    blocks += [paragraph(LADDER), _ladder(shown), *_pieces(subject, shown)]
    if reach.region is not None:
        blocks.append(paragraph("Region of attraction: {}.", region_words(reach.region, states)))
    if reach.rate is not None:
        blocks.append(paragraph("Rate: {}.", rate_words(reach, states)))
    if reach.region_rate is not None:
        blocks.append(paragraph("Rate farther out: {}.", region_rate_words(reach, states)))
    if reach.gain is not None:
        blocks.append(paragraph("With a disturbance d: {}.", gain_words(reach, states)))
    return Section("A Lyapunov function", tuple(blocks))


def _meaning(subject: SystemSubject, shown: ExaminedFunction) -> str:
    if shown.grows:
        return "V is positive and grows along every solution, so solutions leave: it proves instability."
    found = f"Decided exactly on every cell, edge and corner: {shown.reason}."
    return found if subject.result.function is not None else f"{found} The verdict does not rest on this V."


def _ladder(shown: ExaminedFunction) -> Block:
    rows: list[list[Entry]] = []
    for key, found in shown.suprema.items():
        largest: Entry = ""
        if found.value is not None and found.point is not None:
            largest = (number(found.value), " at ", point(found.point))
        rows.append([DERIVATIVES[key], str(found.trend), largest])
    return table(("derivative", "sign", "largest value, where it is attained"), rows, (0.3, 0.25, 0.45))


def _pieces(subject: SystemSubject, shown: PlaneFunction) -> list[Block]:
    """V and its derivative on each cell."""
    states = subject.system.states
    rows: list[list[Entry]] = [
        [str(k), polynomial_math(cell.potential, states), polynomial_math(rate, states)]
        for k, cell in enumerate(shown.result.cells, 1)
        for rate in cell.rates
    ]
    words = paragraph("On each cell of its domain, V and its derivative along the field of the cell:")
    return [words, table(("cell", "V", "grad V . f"), rows, (0.08, 0.4, 0.52))]


def leading_section(subject: SystemSubject) -> Section:
    """The homogeneous parts of lowest degree on tangent cones."""
    found = subject.result.by(Method.LEADING)
    if found is None:
        raise TypeError("required a system that its leading terms decide")
    leading = found.proofs
    words = paragraph(
        "Near the point the fields are looked at to leading order on the tangent cones of their cells, where solutions "
        "of the homogeneous field turn and grow by functions of the direction alone; what follows for them holds for "
        "the system. Here, {}: {}.",
        leading.reason,
        str(leading.verdict),
    )
    rows: list[list[Entry]] = [
        [point(m.ray), ("inward", "at rest", "outward")[m.direction + 1], "sliding" if m.sliding else "in a cone"]
        for m in leading.motions
    ]
    blocks: list[Block] = [words]
    if rows:
        blocks.append(paragraph("Rays along which a radial motion is possible:"))
        blocks.append(table(("ray", "direction", "kind"), rows, (0.5, 0.25, 0.25)))
    return Section("Leading terms", tuple(blocks))
