"""The report of a plain system: verdict, formulas, Filippov's inclusion, what decides stability, picture, solutions."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import cached_property

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.cells.switched_cells import FieldCell, square_regions, system_cells
from nonsmooth.analysis.fields.stated_field import StatedField
from nonsmooth.analysis.trajectories.result import Trajectory, TrajectoryError
from nonsmooth.proofs.findings import Record, Translation
from nonsmooth.proofs.system_decision import StabilityResult, decide_system
from nonsmooth.proofs.system_facts import (
    gain_words,
    rate_words,
    region_rate_words,
    region_words,
    rewriting_words,
    system_facts,
)
from nonsmooth.proofs.systems.border_motion import BorderKind, BorderPart, sliding_velocity
from nonsmooth.proofs.systems.domain import disturbance_letter
from nonsmooth.proofs.systems.findings import DERIVATIVES, ExaminedFunction, Method, PlaneFunction
from nonsmooth.proofs.systems.ray_moves import values_at_origin
from nonsmooth.reports.checks.phase_portrait import PhasePortrait
from nonsmooth.reports.checks.subject import (
    BACCIOTTI_CERAGIOLI,
    FILIPPOV,
    HOMOGENEITY,
    SHEVITZ_PADEN,
    Reference,
    ReportPart,
    ReportSubject,
)
from nonsmooth.reports.checks.system_results import SystemCheckResult, system_answers
from nonsmooth.reports.output.document import (
    Block,
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
from nonsmooth.reports.output.prose import listed, paragraph, with_formulas
from nonsmooth.reports.output.refusals import LARGEST, LEAST
from nonsmooth.reports.simulations.paths import follow_system
from nonsmooth.reports.simulations.simulate_options import SimulateOptions
from nonsmooth.symbolic.formulas.enclosed_functions import kinds_text
from nonsmooth.symbolic.formulas.formula_text import tidied
from nonsmooth.symbolic.formulas.surfaces import symbol_latex
from nonsmooth.symbolic.messages.scene_error import SceneError, one_line
from nonsmooth.symbolic.numbers.number_text import float_text, place_text
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.numbers.printing import Summand, latex_sum, number_summands
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem, require_plane

TONES = {
    Translation.ASYMPTOTICALLY_STABLE: Tone.GOOD,
    Translation.STABLE: Tone.FAIR,
    Translation.UNSTABLE: Tone.BAD,
    Translation.UNDECIDED: Tone.OPEN,
}
STARTS = ((0.4, 0.8), (-0.8, 0.4), (-0.4, -0.8), (0.8, -0.4))  # of the half-width of the square, from its middle
UNTIL = 10.0  # last time of the solutions that are shown
SHOWN_BORDERS = 60  # rows; a picture shows the others
LADDER = (
    "Three sets bound the derivative of V along solutions, each inside the one before, and the last one decides: all "
    "products of gradients and velocities that meet at a point (naive), the set of Shevitz and Paden, and that of "
    "Bacciotti and Ceragioli. Their signs over the domain without the point:"
)


class SystemSubject(ReportSubject):
    """A plain system in two states.

    Raises:
        SceneError: for another number of states.
    """

    scene: SwitchedSystem
    left_out = ()

    def __post_init__(self) -> None:
        require_plane(self.scene)

    @cached_property
    def result(self) -> StabilityResult:
        """The stability of the checked point."""
        return decide_system(self.scene)

    @property
    def headline(self) -> str:
        """The stability of the checked point."""
        return str(self.result.verdict)

    @cached_property
    def cells(self) -> tuple[FieldCell, ...]:
        """The cells of the checked square, measured from the checked point."""
        return system_cells(self.scene, square_regions(self.scene.check.radius))

    @cached_property
    def portrait(self) -> PhasePortrait:
        """Cells, borders and picture.

        Raises:
            SceneError: under arbitrary switching.
        """
        return PhasePortrait(self.scene)

    @property
    def records(self) -> Record:
        """The verdict, and the phase portrait of one field."""
        portrait = self.portrait.facts() if self.scene.has_one_field else None
        return {"check": SystemCheckResult(self.result).facts(), "phase_portrait": portrait}

    @property
    def works(self) -> list[Reference]:
        """Filippov, the authors of the derivatives of V, and of leading terms where these decide."""
        works = [FILIPPOV, SHEVITZ_PADEN, BACCIOTTI_CERAGIOLI]
        return [*works, HOMOGENEITY] if self.result.by(Method.LEADING) is not None else works


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
    system = subject.scene
    check = system.check
    where = paragraph(
        "Checked at {}, on the square of half-width {} about it. On switching surfaces the values of the formulas are "
        "ignored: solutions are those of Filippov's inclusion.",
        point(check.equilibrium),
        point([check.radius]) if len(str(check.radius)) > len("1000000") else Code(str(check.radius)),
    )
    blocks: list[Block] = []
    members = system.members
    if system.written:
        blocks += [_formulas(system.states, formulas) for formulas in system.written]
        blocks.append(paragraph("{} What is proved of the following is proved of that.", rewriting_words(system)))
    if system.others and system.has_one_field:
        blocks.append(paragraph("At every point the field is a mixture of these {}:", str(len(members))))
    elif system.others:
        blocks.append(paragraph("The field is any of these {}, or a mixture, at any time:", str(len(members))))
    if system.overlaps:
        blocks.append(paragraph("They differ only where tables of regions overlap: each takes another table first."))
    shown = tidied if system.written else str  # formulas of the user stay as they are
    blocks += [_formulas(system.states, [shown(rhs.text) for rhs in member.rhs]) for member in members]
    return Section("The system", (*blocks, where))


def _formulas(states: Sequence[str], formulas: Sequence[str]) -> Listing:
    lines = (f"{name}' = {one_line(text)}" for name, text in zip(states, formulas, strict=True))
    return Listing("\n".join(lines))


# ---- Filippov's inclusion -------------------------------------------------------------------------


def cells_section(subject: SystemSubject) -> Section:
    """The pieces of the square on which the fields are polynomials."""
    states = subject.scene.states
    words = paragraph(
        "The switching surfaces and the axes through the checked point cut the square into {} cells. On each the field "
        "is {}. Corners and rates are written in the displacement from the point, whose entries are called "
        "like the states.",
        str(len(subject.cells)),
        f"a polynomial in the states and in {kinds_text(subject.scene.names)} of them"
        if subject.scene.names
        else "a polynomial",
    )
    rows = [row for k, cell in enumerate(subject.cells) for row in _cell_rows(k, cell, subject)]
    header: list[Entry] = ["cell", "corners", *(Math(rf"\dot{{{state_latex(name)}}}", f"{name}'") for name in states)]
    return Section("Cells", (words, table(header, rows, (0.07, 0.41, 0.26, 0.26))))


def _cell_rows(index: int, cell: FieldCell, subject: SystemSubject) -> Iterable[list[Entry]]:
    """A row for the field of a cell, or for each that may act there."""
    states = subject.scene.states
    where: Text = listed([point((x / w, y / w)) for x, y, w in cell.region.generators])
    for guard in cell.region.guards:
        bound = polynomial_math(guard, states)
        where = (*where, "; ", Math(f"{bound.latex} > 0", f"{bound.plain} > 0"))
    known = [subject.portrait.fields[index]] if subject.scene.names else map(StatedField, cell.velocities)
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
    values = [point(value) for value in values_at_origin(subject.cells)]
    latex, plain = r",\allowbreak\ ".join(value.latex for value in values), ", ".join(value.plain for value in values)
    words = paragraph(
        "At the checked point F is the convex hull of the values of the fields of all cells that touch it: {}. "
        "The point is an equilibrium if 0 is in this hull; here that {}.",
        Math(latex, plain),
        str(subject.result.equilibrium),
    )
    return Section("The checked point", (words,))


# ---- what decides --------------------------------------------------------------------------------


def lyapunov_section(subject: SystemSubject) -> Section:
    """The V that proves the verdict, with the derivatives, its region and its rate; else what the scene's V shows."""
    result, reach, states = subject.result, subject.result.reach, subject.scene.states
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
        blocks.append(paragraph("With a disturbance {}: {}.", disturbance_letter(states), gain_words(reach, states)))
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
    """Filippov solutions from four starts, followed from event to event."""
    system = subject.scene
    radius = system.check.half_width
    middle = system.check.place
    rows: list[list[Entry]] = []
    for shares in STARTS:
        start = tuple(m + share * radius for m, share in zip(middle, shares, strict=True))
        try:
            path = follow_system(system, SimulateOptions(start=start, until=UNTIL)).trajectory
        except (SceneError, TrajectoryError, ValueError) as error:
            rows.append([place_text(start), "", "", "", f"not followed: {error}"])
            continue
        rows.append(_path_row(start, path))
    words = paragraph("Filippov solutions from four starts, followed from event to event until t = {}:", f"{UNTIL:g}")
    header = ("start", "events", "ends at t", "in", "because")
    return Section("Solutions", (words, table(header, rows, (0.2, 0.1, 0.13, 0.25, 0.32))))


def _path_row(start: tuple[float, ...], path: Trajectory) -> list[Entry]:
    end = path.end
    others = {True: "", False: "; other solutions branch off", None: "; uniqueness not decided"}[path.unique]
    time = decimal(float_text(end.t))
    return [place_text(start), str(len(path.events)), time, place_text(end.state, 4), f"{end.reason}{others}"]


# ---- what sections need, and their order ---------------------------------------------------------


def _several_fields(subject: SystemSubject) -> str:
    switches = "the field may switch at any time, and this is about one field in each cell"
    return "" if subject.scene.has_one_field else switches


def _no_picture(subject: SystemSubject) -> str:
    beyond = "the checked square is beyond what floats, which pictures need, hold"
    is_known = LEAST <= subject.scene.check.half_width <= LARGEST
    return _several_fields(subject) or ("" if is_known else beyond)


SYSTEM_PARTS = (
    ReportPart("verdict", verdict_section),
    ReportPart("system", system_section),
    ReportPart("cells", cells_section),
    ReportPart("borders", borders_section, _several_fields),
    ReportPart("point", point_section),
    ReportPart("lyapunov", lyapunov_section),
    ReportPart(
        "leading-terms",
        leading_section,
        lambda subject: "" if subject.result.by(Method.LEADING) else "what decides are not the leading terms",
    ),
    ReportPart("portrait", portrait_section, _no_picture),
    ReportPart("trajectories", paths_section, _several_fields),
)


# ---- formulas ------------------------------------------------------------------------------------


GREEK = frozenset({
    "alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "kappa", "lambda", "mu", "nu", "xi",
    "rho", "sigma", "tau", "phi", "chi", "psi", "omega",
})  # fmt: skip


def state_latex(name: str) -> str:
    """A state's name: one letter or a Greek one as a symbol with its index, a word as a word."""
    stem, _, index = name.partition("_")
    if stem in GREEK:
        stem = rf"\{stem}"
    elif len(stem) != 1:
        word = name.replace("_", r"\_")
        return rf"\mathit{{{word}}}"
    return symbol_latex(f"{stem}_{index}") if index else stem


def polynomial_math(polynomial: Polynomial, states: Sequence[str]) -> Math:
    """A polynomial in the displacement, whose entries are called like the states.

    Args:
        polynomial: in as many variables as there are states.
        states: their names.
    """
    return _polynomial_math(polynomial, states, list(map(state_latex, states)))


def _polynomial_math(polynomial: Polynomial, names: Sequence[str], symbols: Sequence[str]) -> Math:
    """A polynomial by the plain names of its variables and by their symbols in LaTeX."""
    named = replace(polynomial, variables=tuple(names))
    summands: list[Summand] = []
    for exponents, coefficient in sorted(polynomial.terms.items(), key=lambda term: (-sum(term[0]), term[0][::-1])):
        powers = [_power(symbol, k) for symbol, k in zip(symbols, exponents, strict=True) if k]
        summands.append(_term(number_summands(coefficient), powers))
    return Math(latex_sum(summands) if summands else "0", str(named))


def stated_math(field: StatedField, states: Sequence[str]) -> tuple[Math, ...]:
    """The rate of each state, with its sines and cosines."""
    waves = [polynomial_math(wave.argument, states) for wave in field.waves]
    named = [{"atan": "arctan"}.get(wave.kind, wave.kind) for wave in field.waves]
    latex = [rf"\{name}\left({math.latex}\right)" for name, math in zip(named, waves, strict=True)]
    return tuple(
        _polynomial_math(rate, field.names(states), [*map(state_latex, states), *latex]) for rate in field.rates
    )


def _power(symbol: str, exponent: int) -> str:
    return symbol if exponent == 1 else rf"{symbol}^{{{exponent}}}"


def _term(coefficients: list[Summand], powers: list[str]) -> Summand:
    """A coefficient times powers; a sum as a coefficient stands in parentheses."""
    if len(coefficients) > 1:
        text = latex_sum(coefficients)
        return Summand(False, "", " ".join([rf"\left({text}\right)", *powers]) if powers else text)
    (only,) = coefficients
    shown = [only.latex] * (only.latex != "1" or not powers)
    return Summand(only.negative, "", " ".join([*shown, *powers]))
