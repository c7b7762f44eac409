"""The report of a plain system: verdict, formulas, Filippov's inclusion, what decides stability, picture, solutions.

It is of any number of states; polygons, borders, derivatives and the portrait are of two states alone.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import cycle
from typing import Any

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.cells.switched_cells import FieldCell
from nonsmooth.analysis.fields.stated_field import StatedField
from nonsmooth.analysis.trajectories.result import TrajectoryError
from nonsmooth.proofs.findings import Equilibrium, Translation
from nonsmooth.proofs.kernel.cells import BeyondReachError
from nonsmooth.proofs.kernel.quotients import signed_roots_of
from nonsmooth.proofs.many_states.examination import ExaminedLyapunov
from nonsmooth.proofs.parts import Parts, names_of
from nonsmooth.proofs.system_facts import (
    gain_words,
    rate_words,
    region_rate_words,
    region_words,
    rewriting_words,
    system_facts,
)
from nonsmooth.proofs.systems.border_motion import BorderKind, BorderPart, sliding_velocity
from nonsmooth.proofs.systems.derivatives import Decrease
from nonsmooth.proofs.systems.domain import disturbance_letter
from nonsmooth.proofs.systems.findings import DERIVATIVES, ExaminedFunction, Method, PlaneFunction
from nonsmooth.reports.checks.subject import UNMISSED, ReportPart
from nonsmooth.reports.checks.system_results import brief_function, system_answers
from nonsmooth.reports.checks.system_subject import SystemSubject
from nonsmooth.reports.output.document import (
    Block,
    Bullets,
    Code,
    Entry,
    Figure,
    Listing,
    Math,
    Section,
    Text,
    Tone,
    Verdict,
    decimal,
    display,
    number,
    point,
    table,
)
from nonsmooth.reports.output.facts import fact_rows
from nonsmooth.reports.output.field_formulas import polynomial_math, rates_header, stated_math
from nonsmooth.reports.output.prose import listed, paragraph, with_formulas
from nonsmooth.reports.output.refusals import LARGEST, LEAST
from nonsmooth.reports.simulations.paths import SystemPath, follow_system
from nonsmooth.reports.simulations.simulate_options import SimulateOptions
from nonsmooth.symbolic.formulas.enclosed_functions import kinds_text
from nonsmooth.symbolic.formulas.trees import tidied, written
from nonsmooth.symbolic.messages.scene_error import SceneError, one_line
from nonsmooth.symbolic.numbers.number_text import float_text, place_text

TONES = {
    Translation.ASYMPTOTICALLY_STABLE: Tone.GOOD,
    Translation.STABLE: Tone.FAIR,
    Translation.UNSTABLE: Tone.BAD,
    Translation.UNDECIDED: Tone.OPEN,
}
STARTS = ((0.4, 0.8), (-0.8, 0.4), (-0.4, -0.8), (0.8, -0.4))  # in turn for all states: half-widths from the point
UNTIL = 10.0  # last time of the solutions that are shown
SHOWN_FIELDS = 60  # rows of the table of cells
SHOWN_BORDERS = 60  # rows; a picture shows the others
BRANCHES = {True: "", False: "; other solutions branch off", None: "; uniqueness not decided"}
INEQUALITIES = {
    ("V", True): "V > 0 on a cell",
    ("cell", True): "V' < 0 along a field of a cell",
    ("cell", False): "V' <= 0 along a field of a cell",
    ("face", True): "V' < 0 along all that slides on a face",
    ("face", False): "V' <= 0 along all that slides on a face",
}
EVIDENCE = {
    "squares": "sums of squares",
    "simplices": "coefficients on simplices",
    "pairs": "pairs of fields",
    "mixture": "a mixture of what bounds the cell",
}
CLAIMED = "Cells are cut where V bends, too. Of these it is shown, at all points but the checked one:"
LADDER = (
    "Three sets bound the derivative of V along solutions, each inside the one before, and the last one decides: all "
    "products of gradients and velocities that meet at a point (naive), the set of Shevitz and Paden, and that of "
    "Bacciotti and Ceragioli. Their signs over the domain without the point:"
)
IN_HULL = {Equilibrium.HOLDS: "holds", Equilibrium.FAILS: "fails", Equilibrium.UNDECIDED: "is undecided"}
CUBES = {1: "interval", 2: "square"}  # by the number of states; of more a cube


def verdict_section(subject: SystemSubject) -> Section:
    """What is said about the checked point, and what that rests on."""
    result = subject.result
    said = paragraph(
        "The equilibrium is {}: {}.",
        Verdict(str(result.verdict), TONES[result.verdict]),
        result.reason,
    )
    answers = [
        (name, Verdict(answer, TONES[result.verdict]) if not k else answer, with_formulas(sentence))
        for k, (name, answer, sentence) in enumerate(system_answers(result))
    ]
    header = ("question", "answer", "how far, how fast, on what conditions")
    rows: list[list[Entry]] = [[name, with_formulas(words)] for name, words in fact_rows(system_facts(result))]
    found = table(("what", "found"), rows, (0.28, 0.72))
    return Section("The verdict", (said, table(header, answers, (2, 3, 8)), paragraph("In detail:"), found))


def system_section(subject: SystemSubject) -> Section:
    """The formulas as they were written, and what is checked."""
    if subject.result.is_in_time_of_states:
        return _system_in_time_of_states(subject)
    system, radius = subject.scene, subject.scene.check.radius
    where = paragraph(
        "Checked at {}, on the {} of half-width {} about it{}. On switching surfaces the values of the formulas are "
        "ignored: solutions are those of Filippov's inclusion.",
        point(system.stated_point),
        _cube(subject),
        point([radius]) if len(str(radius)) > len("1000000") else Code(str(radius)),
        "" if system.by_roots is None else f" in {', '.join(system.states)}",
    )
    blocks: list[Block] = []
    members = system.members
    if system.rewriting.written:
        blocks += [_formulas(system.stated_states, formulas) for formulas in system.rewriting.written]
        blocks.append(paragraph("{} What is proved of the following is proved of that.", rewriting_words(system)))
    if system.others and system.has_one_field:
        blocks.append(paragraph("At every point the field is a mixture of these {}:", str(len(members))))
    elif system.others:
        blocks.append(paragraph("The field is any of these {}, or a mixture, at any time:", str(len(members))))
    if system.overlaps:
        blocks.append(paragraph("They differ only where tables of regions overlap: each takes another table first."))
    for member in members:
        texts = [rhs.text for rhs in member.rhs]
        if system.rewriting.written:  # formulas of the user stay as they are
            texts = [written(tidied(rhs.tree)) for rhs in member.rhs]
        blocks.append(_formulas(system.states, texts))
    return Section("The system", (*blocks, where))


def _system_in_time_of_states(subject: SystemSubject) -> Section:
    """The formulas as they were written, and of which roots of states V is a function."""
    system, entry = subject.scene, subject.result.deciding.entry
    roots = None if entry is None else signed_roots_of(entry["hypotheses"], system.stated_states)
    if roots is None:
        raise TypeError("required a V about roots of states")
    stated = [_formulas(system.stated_states, formulas) for formulas in system.stated_lists]
    where = paragraph(
        "Checked at {}. V is a function of {}, with {}, in the time of the states. On switching surfaces the values of "
        "the formulas are ignored: solutions are those of Filippov's inclusion. {}",
        point(system.stated_point),
        ", ".join(roots.seen_states),
        " and ".join(roots.meanings),
        rewriting_words(system, in_time_of_states=True),
    )
    return Section("The system", (*stated, where))


def _cube(subject: SystemSubject) -> str:
    return CUBES.get(len(subject.scene.states), "cube")


def _formulas(states: Sequence[str], formulas: Sequence[str]) -> Listing:
    lines = (f"{name}' = {one_line(text)}" for name, text in zip(states, formulas, strict=True))
    return Listing("\n".join(lines))


# ---- Filippov's inclusion -------------------------------------------------------------------------


def cells_section(subject: SystemSubject) -> Section:
    """The pieces of the checked cube on which the fields are polynomials, by the signs of switching surfaces."""
    if subject.is_in_plane:
        return polygons_section(subject)
    cells, states = subject.sign_cells, subject.seen.states
    rated = subject.scene.stated_states if subject.result.is_in_time_of_states else states
    like = "the states" if rated == states else "the roots and states"
    surfaces = [polynomial_math(surface, states) for surface in cells.surfaces]
    named = [
        (Math(f"s_{{{k}}} = {surface.latex}", f"s_{k} = {surface.plain}"),) for k, surface in enumerate(surfaces, 1)
    ]
    curved = any(surface.degree > 1 for surface in cells.surfaces)
    words = paragraph(
        f"Rates are written in the displacement from the point, whose entries are called like {like}. {{}}",
        f"The signs of these functions cut the {_cube(subject)} into {len(cells.cells)} cells"
        f"{', some of which may have no point, beside curved surfaces' if curved else ''}. Where cells meet, every "
        "mixture of their fields is in Filippov's inclusion:"
        if named
        else "Nothing switches:",
    )
    rows: list[list[Entry]] = []
    for signs, fields in subject.fields():
        rows += [[signs if not k else "", *stated_math(field, states)] for k, field in enumerate(fields)]
    blocks: list[Block] = [words, Bullets(tuple(named))] if named else [words]
    blocks.append(table(("signs", *rates_header(rated)), rows[:SHOWN_FIELDS]))
    if len(rows) > SHOWN_FIELDS:
        blocks.append(paragraph("{} more rows are left out.", str(len(rows) - SHOWN_FIELDS)))
    return Section("Cells", tuple(blocks))


def polygons_section(subject: SystemSubject) -> Section:
    """The pieces of the square on which the fields are polynomials."""
    states = subject.scene.states
    words = paragraph(
        "The switching surfaces and the axes through the checked point cut the square into {} cells. On each the field "
        "is {}. Corners and rates are written in the displacement from the point, whose entries are called "
        "like the states.",
        str(len(subject.polygons)),
        f"a polynomial in the states and in {kinds_text(subject.scene.rewriting.names)} of them"
        if subject.scene.rewriting.names
        else "a polynomial",
    )
    rows = [row for k, cell in enumerate(subject.polygons) for row in _cell_rows(k, cell, subject)]
    header: list[Entry] = ["cell", "corners", *rates_header(states)]
    return Section("Cells", (words, table(header, rows, (0.07, 0.41, 0.26, 0.26))))


def _cell_rows(index: int, cell: FieldCell, subject: SystemSubject) -> Iterable[list[Entry]]:
    """A row for the field of a cell, or for each that may act there."""
    states = subject.scene.states
    where: Text = listed([point((x / w, y / w)) for x, y, w in cell.region.generators])
    for guard in cell.region.guards:
        bound = polynomial_math(guard, states)
        where = (*where, "; ", Math(f"{bound.latex} > 0", f"{bound.plain} > 0"))
    known = [subject.portrait.fields[index]] if subject.scene.rewriting.names else map(StatedField, cell.velocities)
    for k, field in enumerate(known):
        yield [str(index + 1) if not k else "", where if not k else "", *stated_math(field, states)]


def borders_section(subject: SystemSubject) -> Section:
    """What solutions do where two cells meet along a straight side."""
    borders = subject.portrait.borders
    blocks: list[Block] = [
        paragraph(
            "Across these straight borders the field jumps. With f and g on the two sides and a normal n, solutions "
            "cross where n . f and n . g have one sign. Where both fields push onto the border, solutions slide along "
            "it with the only mixture that is tangent:"
        ),
        display(
            r"f_s = \frac{(n \cdot g)\, f - (n \cdot f)\, g}{n \cdot g - n \cdot f}",
            "f_s = ((n . g) f - (n . f) g)/(n . g - n . f)",
        ),
    ]
    if not borders:
        return Section("Filippov's inclusion on borders", (paragraph("No straight border lies between two fields."),))
    rows = [[*_ends(part), str(part.kind), _velocity(part)] for part in borders[:SHOWN_BORDERS]]
    blocks.append(table(("from", "to", "solutions", "f_s midway"), rows, (0.25, 0.25, 0.2, 0.3)))
    if len(borders) > SHOWN_BORDERS:
        blocks.append(paragraph("{} more are drawn in the phase portrait.", str(len(borders) - SHOWN_BORDERS)))
    return Section("Filippov's inclusion on borders", tuple(blocks))


def _ends(part: BorderPart) -> Iterable[Entry]:
    """Exact ends; those at zeros of sines are rounded."""
    rounded = part.fields[0].waves and not part.is_exact
    return (place_text(end, 4) if rounded else point(end) for end in (part.start, part.end))


def _velocity(part: BorderPart) -> Entry:
    if part.kind not in {BorderKind.SLIDING, BorderKind.REPELLING}:
        return ""
    velocity = sliding_velocity(part, _middle(part))
    return place_text(velocity, 4) if any(field.waves for field in part.fields) else point(velocity)


def _middle(part: BorderPart) -> Point:
    first, second = ((a + b) / 2 for a, b in zip(part.start, part.end, strict=True))
    return (first, second)


def point_section(subject: SystemSubject) -> Section:
    """Whether the checked point is an equilibrium: 0 in the hull of the fields of all cells that hold it."""
    if subject.scene.vanishing:
        said = paragraph(
            "The stated field has no value at the checked point, where a denominator is zero, and is bounded beside "
            "it. Whether the point is an equilibrium the verdict alone tells: where solutions stay near it, it is one."
        )
        return Section("The checked point", (said,))
    values = [point(value) for value in subject.values_at_point()]
    latex, plain = r",\allowbreak\ ".join(value.latex for value in values), ", ".join(value.plain for value in values)
    words = paragraph(
        "At the checked point F is the convex hull of the values of the fields of all cells that touch it: {}. "
        "The point is an equilibrium if 0 is in this hull; here that {}.",
        Math(latex, plain),
        IN_HULL[subject.result.equilibrium],
    )
    return Section("The checked point", (words,))


# ---- what decides --------------------------------------------------------------------------------


def lyapunov_section(subject: SystemSubject) -> Section:
    """The V that proves the verdict, with its conditions, region and rate; else what the scene's V shows."""
    if subject.result.is_in_time_of_states:
        return _function_of_states(subject)
    shown, reach, states = subject.shown, subject.result.reach, subject.scene.states
    if shown is None:
        raise TypeError("required a system of which some V is looked at")
    blocks: list[Block] = [paragraph("{} on {}:", Code(f"V = {shown.text}"), shown.domain.text(states))]
    blocks.append(paragraph("{}", _meaning(subject, shown)))
    if isinstance(shown, PlaneFunction):
        blocks += derivative_blocks(subject, shown)
    elif isinstance(shown, ExaminedLyapunov) and shown.proofs:
        header = ("inequality", "how often", "shown by")
        blocks += [paragraph("{}", CLAIMED), table(header, _shown_claims(shown), (0.5, 0.15, 0.35))]
    if reach.region is not None:
        blocks.append(paragraph("Region of attraction: {}.", region_words(reach.region, states)))
    if reach.rate is not None:
        blocks.append(paragraph("Rate: {}.", rate_words(reach, states)))
    if reach.region_rate is not None:
        blocks.append(paragraph("Rate farther out: {}.", region_rate_words(reach.region_rate, states)))
    if reach.gain is not None:
        blocks.append(
            paragraph("With a disturbance {}: {}.", disturbance_letter(states), gain_words(reach.gain, states))
        )
    return Section("A Lyapunov function", tuple(blocks))


def _function_of_states(subject: SystemSubject) -> Section:
    """A V by forms in roots of states, and what is shown of it."""
    entry = subject.result.deciding.entry
    if entry is None:
        raise TypeError("required a V with evidence")
    rows = _counted((name, True, evidence) for name, evidence in entry["proofs"].items())
    words = (
        "{} falls along the velocities of the states{}. Its derivative by a state x is that by root_x over {}, q the "
        "order of the root: again a polynomial on each cell."
    )
    where = " where it is not positive" if entry["theorem"] == "instability" else ""
    function, speed = Code(f"V = {entry['hypotheses']['function']}"), Code("q*Abs(root_x)**(q - 1)")
    blocks: list[Block] = [paragraph(words, function, where, speed), paragraph("{}", CLAIMED)]
    blocks.append(table(("inequality", "how often", "shown by"), list(rows), (0.5, 0.15, 0.35)))
    return Section("A Lyapunov function", tuple(blocks))


def _meaning(subject: SystemSubject, shown: ExaminedFunction) -> str:
    if shown.grows:
        return "V is positive and grows along every solution, so solutions leave: it proves instability."
    places = "cell, edge and corner" if isinstance(shown, PlaneFunction) else "cell and face"
    how = "Examined" if shown.decrease is Decrease.UNDECIDED else "Decided exactly"
    found = f"{how} on every {places}: {shown.reason}."
    return found if subject.result.function is not None else f"{found} The verdict does not rest on this V."


def _shown_claims(shown: ExaminedLyapunov) -> Iterator[list[Entry]]:
    """How many inequalities of each kind are shown by each kind of evidence."""
    found = ((claim.claim.name, claim.found) for claim in shown.asked if claim.found is not None)
    return _counted((name, proof.strict, proof.evidence) for name, proof in found)


def _counted(shown: Iterable[tuple[str, bool, Mapping[str, Any]]]) -> Iterator[list[Entry]]:
    """The inequalities about V among claims, of which name, strictness and evidence are given."""
    counted = Counter[tuple[str, str]]()
    for name, strict, evidence in shown:
        inequality = INEQUALITIES.get((name.split()[0], strict))
        if inequality is not None:
            counted[inequality, EVIDENCE[next(iter(evidence))]] += 1
    for (inequality, kind), count in counted.items():
        yield [inequality, str(count), kind]


def derivative_blocks(subject: SystemSubject, shown: PlaneFunction) -> list[Block]:
    """The largest values of the three derivatives of V, and V with its derivative on each cell."""
    return [paragraph(LADDER), _ladder(shown), *_pieces(subject, shown)]


def _ladder(shown: PlaneFunction) -> Block:
    rows: list[list[Entry]] = []
    for key, found in shown.suprema.items():
        largest: Entry = ""
        if found.value is not None and found.point is not None:
            largest = (number(found.value), " at ", point(found.point))
        rows.append([DERIVATIVES[key], str(found.supremum_sign), largest])
    return table(("derivative", "sign", "largest value, where it is attained"), rows, (0.3, 0.25, 0.45))


def _pieces(subject: SystemSubject, shown: PlaneFunction) -> list[Block]:
    """V and its derivative on each cell."""
    states = subject.scene.states
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
        found.reason,
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


def parts_section(subject: SystemSubject) -> Section:
    """The parts of the system that were decided by themselves, and by what."""
    found = subject.result.deciding
    parts: Parts = found.proofs
    rows: list[list[Entry]] = []
    for part in parts.results:
        function = "" if part.function is None else brief_function(part.function)
        rows.append([names_of(part.scene.stated_states), str(part.verdict), part.reason, function])
    words = paragraph(
        "The verdict follows from these parts by theorem {}; each is decided by itself:", str(found.theorem)
    )
    return Section("Parts", (words, table(("states", "the point is", "because", "by"), rows, (1, 2, 3, 3))))


# ---- portrait and solutions ----------------------------------------------------------------------


def portrait_section(subject: SystemSubject) -> Section:
    """The phase portrait."""
    figure = Figure(
        "phase-portrait",
        (
            "Field lines, nullclines, borders, and level sets of the V that proves the verdict, over the checked "
            "square; measured from the checked point.",
        ),
        f"Phase portrait of {one_line(subject.scene.name)}: {subject.result.verdict}.",
        subject.invocation.line("partition", "-o", "portrait.svg"),
        subject.portrait.content,
    )
    return Section("Phase portrait", (figure,))


def paths_section(subject: SystemSubject) -> Section:
    """Filippov solutions from four starts, followed from event to event; a picture where there is no portrait."""
    paths = {start: _followed(subject, start) for start in _starts(subject)}
    words = paragraph("Filippov solutions from four starts, followed from event to event until t = {}:", f"{UNTIL:g}")
    header = ("start", "events", "ends at t", "in", "because")
    rows = [_path_row(start, path) for start, path in paths.items()]
    blocks: list[Block] = [words, table(header, rows, (0.2, 0.1, 0.13, 0.25, 0.32))]
    drawn = next(((start, path) for start, path in paths.items() if isinstance(path, SystemPath)), None)
    if drawn is not None and not subject.is_in_plane:
        blocks.append(_path_figure(subject, *drawn))
    return Section("Solutions", tuple(blocks))


def _starts(subject: SystemSubject) -> Iterator[tuple[float, ...]]:
    radius, middle = subject.scene.check.half_width, list(map(float, subject.scene.stated_point))
    for shares in STARTS:
        yield tuple(m + share * radius for m, share in zip(middle, cycle(shares), strict=False))


def _followed(subject: SystemSubject, start: tuple[float, ...]) -> SystemPath | str:
    """The solution from a start, or why it is not followed."""
    try:
        return follow_system(subject.scene, SimulateOptions(start=start, until=UNTIL))
    except (SceneError, TrajectoryError, ValueError) as error:
        return f"not followed: {error}"


def _path_row(start: tuple[float, ...], path: SystemPath | str) -> list[Entry]:
    if isinstance(path, str):
        return [place_text(start), "", "", "", path]
    end, events = path.trajectory.end, str(len(path.trajectory.events))
    time, because = decimal(float_text(end.t)), f"{end.reason}{BRANCHES[path.trajectory.unique]}"
    return [place_text(start), events, time, place_text(end.state, 4), because]


def _path_figure(subject: SystemSubject, start: tuple[float, ...], path: SystemPath) -> Figure:
    place = ",".join(f"{x:.12g}" for x in start)
    return Figure(
        "solution",
        (f"The first of these solutions: every state over time, with its events, from {place_text(start)}.",),
        f"A solution of {one_line(subject.scene.name)} over time.",
        subject.invocation.line("simulate", f"--from={place}", "--until", f"{UNTIL:g}", "-o", "path.svg"),
        path.content,
    )


# ---- what sections need, and their order ---------------------------------------------------------


def _several_fields(subject: SystemSubject) -> str:
    switches = "the field may switch at any time, and this is about one field in each cell"
    return "" if subject.scene.has_one_field else switches


def _no_cells(subject: SystemSubject) -> str:
    try:
        subject.polygons if subject.is_in_plane else subject.sign_cells  # noqa: B018 - whether they are built
    except BeyondReachError as error:
        return str(error)
    return ""


def _not_in_plane(subject: SystemSubject) -> str:
    return "" if subject.is_in_plane else "it is about systems in two states, without roots of them"


def _no_function(subject: SystemSubject) -> str:
    if subject.shown is not None or subject.result.is_in_time_of_states:
        return ""
    entry = subject.result.deciding.entry
    by_function = entry is not None and "function" in entry["hypotheses"]
    return "V is in the verdict, and what is shown of it in a certificate" if by_function else "no V is looked at"


def _no_parts(subject: SystemSubject) -> str:
    return "" if isinstance(subject.result.deciding.proofs, Parts) else UNMISSED


def _no_leading_terms(subject: SystemSubject) -> str:
    return "" if subject.result.by(Method.LEADING) else "what decides are not the leading terms"


def _no_picture(subject: SystemSubject) -> str:
    beyond = "the checked square is beyond what floats, which pictures need, hold"
    is_known = LEAST <= subject.scene.check.half_width <= LARGEST
    return _not_in_plane(subject) or _several_fields(subject) or ("" if is_known else beyond)


SYSTEM_PARTS = (
    ReportPart("verdict", verdict_section),
    ReportPart("system", system_section),
    ReportPart("cells", cells_section, _no_cells),
    ReportPart("borders", borders_section, lambda subject: _not_in_plane(subject) or _several_fields(subject)),
    ReportPart("point", point_section, _no_cells),
    ReportPart("lyapunov", lyapunov_section, _no_function),
    ReportPart("parts", parts_section, _no_parts),
    ReportPart("leading-terms", leading_section, _no_leading_terms),
    ReportPart("portrait", portrait_section, _no_picture),
    ReportPart("trajectories", paths_section, _several_fields),
)
