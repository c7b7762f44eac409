"""The study ``design``: which headings, speeds and positions meet what is required, and do best."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Generic, NamedTuple, TypeVar

from nonsmooth.analysis.cells.contact_rule import all_rules, rule_of
from nonsmooth.proofs.answers.answer import require_dynamics
from nonsmooth.proofs.findings import Record
from nonsmooth.reports.designs.freedom import KINDS, ORDERS, WHEELS, Freedom, Orbits, largest_symmetry, orbits_of
from nonsmooth.reports.designs.search import (
    OBJECTIVES,
    Design,
    DesignGoal,
    Evaluation,
    SmallestChoice,
    Told,
    evaluate,
    find_design,
)
from nonsmooth.reports.output.document import Block, sentences, table
from nonsmooth.reports.output.entries import as_json, entry, toml_text
from nonsmooth.reports.output.facts import fact_record
from nonsmooth.reports.output.files import output_path
from nonsmooth.reports.output.progress import notice, progress
from nonsmooth.reports.output.refusals import option_named
from nonsmooth.reports.output.study_options import Options, option
from nonsmooth.reports.simulations.heading_maps import require_outline
from nonsmooth.reports.studies.result import DataTable, Formats, Result, short_lines
from nonsmooth.reports.studies.study import SceneStudy, StudyRequest
from nonsmooth.symbolic.files.documents import deep_nesting_refused, read_document
from nonsmooth.symbolic.files.scene_file import build_scene, one_by_one
from nonsmooth.symbolic.files.scene_values import read_exact
from nonsmooth.symbolic.formulas.trees import ExpressionError
from nonsmooth.symbolic.mechanics.contact_set import standing
from nonsmooth.symbolic.mechanics.scene import LoadTable, Scene
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact, one_line
from nonsmooth.symbolic.numbers.number_text import float_text
from nonsmooth.symbolic.numbers.plane import in_floats

if TYPE_CHECKING:
    from nonsmooth.proofs.answers.answer import Answer
    from nonsmooth.reports.designs.search import Design, DesignGoal, Evaluation, SmallestChoice
    from nonsmooth.symbolic.mechanics.scene import Scene, Wheel


# ---- what is asked for ---------------------------------------------------------------------------
#
# What is asked of a design, read from what a user wrote: what may change, what is required, how long to search.


FREE = (*KINDS, WHEELS)
REQUIRED = ("position", "heading", "pose")
MOST_CHECKS = 100_000
LARGEST_SEED = 2**32 - 1  # of NumPy's Mersenne twister
FINEST = 1000  # denominator of the usual distance that wheels may move


class DesignError(ValueError):
    """``keyword: required ..., received ...``; the command line puts two dashes before it."""


def read_wish(scene: Scene, require: str, maximize: str, checks: int, seed: int) -> DesignGoal:
    """What is required and maximized.

    Args:
        scene: the given array.
        require: names of answers, with commas.
        maximize: name of an objective.
        checks: how many arrays are checked at most.
        seed: of the search.

    Raises:
        DesignError: for what cannot be used.
        SceneError: for a tolerance to maximize that the scene does not state, and a margin under a rule without one.
    """
    (objective, *others) = _names(maximize, "maximize", tuple(OBJECTIVES))
    if others:
        raise DesignError(f"maximize: required one name, received {maximize[:60]!r}")
    if not 1 <= checks <= MOST_CHECKS:
        raise DesignError(f"checks: required a number from 1 to {MOST_CHECKS}, received {checks}")
    if not 0 <= seed <= LARGEST_SEED:
        raise DesignError(f"seed: required a number from 0 to {LARGEST_SEED}, received {str(seed)[:60]}")
    if objective == "tolerance" and scene.tolerances is None:
        raise SceneError(scene.source, "tolerance", "a [tolerance] table to maximize it", StatedFact("nothing"))
    if objective == "margin" and not rule_of(scene).keeps_rows:
        known = " or ".join(f'"{rule.name}"' for rule in all_rules() if rule.keeps_rows)
        wanted = f"{known}, of which the margin of feedback is known, to maximize it"
        raise SceneError(scene.source, "contact.rule", wanted, scene.contact.rule)
    if objective == "settling":
        require_dynamics(scene, "maximize")
    if objective == "heading":
        require_outline(scene)
    return DesignGoal(_names(require, "require", REQUIRED), objective, checks, seed)


def read_freedom(scene: Scene, free: str, move: Any, symmetry: int | None) -> Freedom:
    """What may change.

    Args:
        scene: the given array.
        free: names of what may change, with commas.
        move: how far wheels may move in x and y; None for a quarter of the side of the checked square.
        symmetry: turns that leave the array as it is: 1, 2 or 4; None for the most that it has.

    Raises:
        DesignError: for what cannot be used.
    """
    kinds = _names(free, "free", FREE)
    if WHEELS in kinds and len(kinds) > 1:
        raise DesignError(f"free: required wheels alone, received {free[:60]!r}")
    if WHEELS in kinds and isinstance(scene.contact.loads, LoadTable):
        raise DesignError("free: required loads that some of the wheels have too, received loads stated for all wheels")
    distance = _distance(scene, move)
    if move is not None and "positions" not in kinds:
        raise DesignError(f"move: required positions among what is free, received {', '.join(kinds)}")
    return replace(Freedom(kinds, move=distance), order=_order(scene, symmetry))


def _names(text: str, keyword: str, known: tuple[str, ...]) -> tuple[str, ...]:
    """Names of a list with commas, in the order in which they are known."""
    names = {name.strip() for name in str(text).split(",")}
    unknown = sorted(names - set(known))
    if unknown:
        raise DesignError(f"{keyword}: required names among {', '.join(known)}, received {unknown[0][:60]!r}")
    return tuple(name for name in known if name in names)


def _distance(scene: Scene, move: Any) -> Fraction:
    if move is None:
        return (Fraction(scene.check.half_width) / 2).limit_denominator(FINEST)
    try:
        given = read_exact(entry(move))
        number, turns = (given, Fraction(0)) if isinstance(given, Fraction) else given.parts_in_pi()
    except ExpressionError:
        number = turns = Fraction(0)
    if turns or number <= 0:
        raise DesignError(f"move: required a positive rational number such as 1/10, received {str(move)[:60]!r}")
    return number


def _order(scene: Scene, asked: int | None) -> int:
    """Of the symmetry to keep: the largest that the scene has unless another is asked for."""
    if asked is None:
        return largest_symmetry(scene)
    if asked not in ORDERS or orbits_of(scene, asked) is None:
        allowed = ", ".join(str(order) for order in ORDERS if orbits_of(scene, order) is not None)
        raise DesignError(f"symmetry: required one of {allowed} for the places of these wheels, received {asked}")
    return asked


# ---- fewest wheels -------------------------------------------------------------------------------
#
# Every choice is an exact scene that is checked, so that where all smaller ones are refuted none of them suffices.


LEAST = 2  # wheels: under no rule a body stands on fewer


def find_fewest(
    base: Mapping[str, Any], folder: Path, scene: Scene, order: int, wish: DesignGoal, told: Told
) -> Design:
    """The smallest choice of the wheels under the body that meets what is required; of that size the best.

    Args:
        base: the document of the given scene.
        folder: where its files lie.
        scene: the same, read.
        order: of the symmetry that choices keep.
        wish: what is asked for.
        told: called with the choices checked and allowed.
    """
    under = standing(scene)
    given = evaluate(scene, wish.required, OBJECTIVES[wish.maximize])
    orbits = orbits_of(under, order) or tuple((k,) for k in range(len(under.wheels)))
    best: tuple[Evaluation, dict[str, Any], Scene] | None = None
    checks = undecided = 0
    for chosen in _choices(orbits):
        if best is not None and len(chosen) > len(best[2].wheels):
            break
        if checks >= wish.checks:
            break
        document = _document(base, under, chosen)
        candidate = build_scene(document, scene.name, folder / f"{scene.name}.toml")
        found = evaluate(candidate, wish.required, OBJECTIVES[wish.maximize])
        checks += 1
        told(checks, wish.checks)
        undecided += bool(found.unmet) and not found.is_refuted
        if not found.unmet and (best is None or found.cost < best[0].cost):
            best = found, document, candidate
    count = None if best is None else len(best[2].wheels)
    fewest = SmallestChoice(count, undecided, checks < wish.checks or best is not None, len(orbits[0]))
    if best is None or count == len(scene.wheels):  # nothing smaller than the scene itself
        return Design(dict(base), scene, given, given, checks, fewest=fewest)
    return Design(best[1], best[2], best[0], given, checks, fewest=fewest)


def _choices(orbits: Orbits) -> Iterator[tuple[int, ...]]:
    """Sets of wheels made of whole orbits, which have one size, by their number."""
    for count in range(1, len(orbits) + 1):
        for some in combinations(orbits, count):
            chosen = sorted(wheel for orbit in some for wheel in orbit)
            if len(chosen) >= LEAST:
                yield tuple(chosen)


def _document(base: Mapping[str, Any], scene: Scene, chosen: tuple[int, ...]) -> dict[str, Any]:
    return one_by_one(base, replace(scene, wheels=tuple(scene.wheels[place] for place in chosen)))


# ---- the design that is named --------------------------------------------------------------------


def find_named(
    base: Mapping[str, Any], folder: Path, scene: Scene, freedom: Freedom, wish: DesignGoal, told: Told
) -> Design:
    """What :func:`nonsmooth.reports.designs.search.find_design` or ``find_fewest`` finds, with a name and a source."""
    if freedom.kinds == (WHEELS,):
        design = find_fewest(base, folder, scene, freedom.order, wish, told)
    else:
        design = find_design(base, folder, scene, freedom, wish, told)
    if design.best is design.base:  # the given array keeps its name
        return design
    how = f"designed from {scene.name}: {', '.join(wish.required)} required, {wish.maximize} maximized"
    rest = {key: value for key, value in design.document.items() if key not in ("name", "description")}
    return replace(design, document={"name": f"{scene.name}-designed", "description": how, **rest})


# ---- what is found -------------------------------------------------------------------------------


Held = TypeVar("Held")  # what Python holds of a scene: a :class:`nonsmooth.Array`

SCHEMA = "nonsmooth-design/1"
SCENES = (".toml",)
DIGITS = 4
HARDLY = 0.01  # share below which a gain is hardly one
ROUNDING = 2.0**-20  # share by which certified bounds of alike arrays differ
MEASUREMENTS = "precision,stress"  # sections of a report that take minutes
WHAT = {
    "rate": "how fast bodies come home",
    "gain": "kappa, how fast feedback holds the pose",
    "margin": "the part of the distance by which feedback may misjudge the position",
    "basin": "radius of the disc whence bodies come home",
    "tolerance": "the multiple of the tolerances that is certified",
    "settling": "one over the time in which bodies with inertia settle (simulated)",
    "heading": "the widest arc of headings, in degrees, from which a body returns to one of them (sampled)",
}


@dataclass(frozen=True, kw_only=True)
class DesignOptions(Options):
    """What may change, what is required, and how long is searched."""

    free: str = option(
        "headings", "What may change: headings,speeds,positions; or which wheels there are.", metavar="NAMES"
    )
    require: str = option("position", "Answers that must be good: position,heading,pose.", metavar="NAMES")
    maximize: str = option(
        "rate",
        "rate (at which bodies come home), gain or margin (of feedback), basin (whence they come home), tolerance, "
        "settling (with inertia, simulated), or heading (how many return to one, sampled).",
        metavar="NAME",
    )
    move: Any = option(
        None, "How far a wheel may move in x and y; a quarter of the square's side.", str | None, metavar="D"
    )
    symmetry: int | None = option(None, "Turns that leave the array as it is; the most it has.", metavar="1|2|4")
    checks: int = option(300, "How many arrays are checked at most.", metavar="N")
    seed: int = option(1, "Of the search, which is repeatable.", metavar="S")
    output: str | None = option(None, "Write the scene that was found: .toml.", flag="-o --output", metavar="FILE")
    report: str | None = option(None, "Write the derivation report of what was found: .html, .md, ...", metavar="FILE")


class GivenArray(NamedTuple):
    """The array that a design starts from: its document, the folder of its tables, and what both mean."""

    document: Mapping[str, Any]
    folder: Path
    scene: Scene


@dataclass(frozen=True, repr=False)
class DesignResult(Result, Generic[Held]):
    """What a search for a better array found.

    Attributes:
        design: the scene of the best candidate, its answers, and those of the given array.
        wish: what was required and maximized.
        array: the best candidate, as a :class:`nonsmooth.Array`; the given array where none is better; None on the
            command line.
    """

    design: Design
    wish: DesignGoal
    array: Held | None = None

    formats: ClassVar[Formats] = {".toml": lambda found, ending: toml_text(found.design.document).encode()}

    @property
    def is_found(self) -> bool:
        """Whether the best candidate meets every requirement."""
        return self.design.is_found

    @property
    def value(self) -> float | None:
        """What was maximized, of the best candidate; None where it is not known."""
        return self.design.best.value

    @property
    def given_value(self) -> float | None:
        """The same of the given array."""
        return self.design.base.value

    @property
    def improved(self) -> bool | None:
        """Whether the best candidate does better than the given array; None where that is not known.

        It does where it alone meets the requirements, where it has fewer wheels and wheels were chosen, and where both
        do and more of what is maximized is known of it, by more than what bounds of a certificate may differ by without
        a reason (:data:`ROUNDING`).  A length per time, of arrival, does not compare with an exponential rate.
        """
        given, best = self.design.base, self.design.best
        if not self.is_found or best is given:
            return False
        if given.unmet or given.why_not or self.design.fewest is not None:
            return True
        if best.value is None or given.value is None:
            return None if best.value is None else True
        if len(set(self._units)) > 1:
            return None
        return best.value - given.value > ROUNDING * abs(given.value)

    @property
    def _units(self) -> list[str]:
        """The units of what was maximized, of the given array and of the best candidate: only those of rates differ."""
        from nonsmooth.reports.designs.search import rate_unit

        pair = (self.design.base, self.design.best) if self.wish.maximize == "rate" else ()
        return [rate_unit(found.answers[0]) for found in pair]

    def _measured(self, found: Evaluation) -> str:
        """What was maximized, of one array, in the units of the scene where it states some."""
        from nonsmooth.reports.designs.search import rate_unit

        text, units, objective = _text(found.value), self.design.scene.units, self.wish.maximize
        if found.value is None or not units.length or objective not in {"rate", "basin", "settling"}:
            return text
        arrives = objective == "rate" and rate_unit(found.answers[0]) != "1/time"
        return f"{text} {units.length if objective == 'basin' else units.speed if arrives else '1/s'}"

    @property
    def is_another(self) -> bool:
        """Whether another array than the given one is shown: a better one, or the nearest to what is required."""
        return self.design.best is not self.design.base and (self.improved is not False or not self.is_found)

    @property
    def unmet(self) -> tuple[str, ...]:
        """The requirements that the best candidate does not meet."""
        return tuple(self.design.best.unmet)

    @property
    def impossible(self) -> str:
        """Why nothing that may change meets the requirements; empty where that is not known."""
        return self.design.impossible

    @property
    def exit_status(self) -> int:
        """0 found, 1 nothing found that meets the requirements."""
        return 0 if self.is_found else 1

    def facts(self) -> Record:
        """What was asked, both arrays, and the document of the best."""
        design, wish = self.design, self.wish
        return {
            "schema": SCHEMA,
            "required": list(wish.required),
            "maximize": wish.maximize,
            "seed": wish.seed,
            "checks": design.checks,
            "found": design.is_found,
            "improved": self.improved,
            "impossible": design.impossible or None,
            "fewest": None if design.fewest is None else vars(design.fewest),
            "given": _evaluation(design.base),
            "best": _evaluation(design.best),
            "scene": as_json(design.document) if not design.impossible else None,
        }

    def table(self) -> DataTable:
        """One line for each wheel of the best candidate: place, direction of the rim, and speed."""
        lines = []
        for wheel in self.design.scene.wheels:
            x, y = (_text(float(entry)) for entry in wheel.position)
            lines.append((str(wheel.index), f"({x}, {y})", self._heading(wheel), _text(float(wheel.speed))))
        return DataTable(("wheel", "position", "heading", "speed"), lines)

    def _heading(self, wheel: Wheel) -> str:
        """A direction; in degrees where the scene has units, as tables of wheels are measured."""
        a, b = in_floats(wheel.unit_direction)
        if not self.design.scene.units.length:
            return f"({_text(a)}, {_text(b)})"
        return f"{_text(math.degrees(math.atan2(b, a)))} deg"

    def _change(self) -> str:
        """Whether anything is better than it was, and by how much."""
        what, given, best = WHAT[self.wish.maximize], self.given_value, self.value
        if self.improved is None:
            why = f"nothing is known of {what}"
            if given is not None and best is not None:
                before, after = (
                    f"{_text(value)} {unit}" for value, unit in zip((given, best), self._units, strict=True)
                )
                why = f"{what} is {before} of that and {after} of this, which do not compare"
            return f"whether that is better than the given array is not known: {why}"
        if self.design.base.unmet or self.design.base.why_not:
            missing = ", ".join(self.design.base.unmet) or self.design.base.why_not
            return f"improved: the given array lacks {missing}"
        if self.design.fewest is not None:
            return f"fewer wheels: {self.design.fewest.count}"
        if given is None or best is None:
            return f"improved: {what} is not known of the given array"
        # as many digits as tell them apart: 0.5 -> 0.5003, not 0.5 -> 0.5
        digits = next((n for n in range(DIGITS, 17) if float_text(given, n) != float_text(best, n)), 17)
        change = f"{what}: {float_text(given, digits)} -> {float_text(best, digits)}"
        if given <= 0:
            return f"improved: {change}"
        share = best / given - 1
        words = "improved, but hardly" if share < HARDLY else "improved"
        return f"{words}: {change} ({float_text(100 * share, 3)} % more)"

    def _without_feedback(self) -> str:
        """What a design makes of the open loop, which feedback hides, and how to keep what was not required."""
        pairs = list(zip(self.design.base.answers, self.design.best.answers, strict=False))
        changes = ", ".join(_from_to(before, after) for before, after in pairs[:2])
        worse = [before.name for before, after in pairs if after.exit_status and not before.exit_status]
        kept = f"; --require {','.join((*self.wish.required, *worse))} keeps what got worse" if worse else ""
        return f"without feedback: {changes}{kept}"

    def blocks(self) -> Sequence[Block]:
        """The outcome, both arrays side by side, and the wheels that were found; of no improvement the given array."""
        design = self.design
        arrays = {"the given array": design.base} | ({"the best found": design.best} if self.is_another else {})
        rows = [
            (answers[0].name, *map(_in_words, answers))
            for answers in zip(*(found.answers for found in arrays.values()), strict=False)
        ]
        rows.append((WHAT[self.wish.maximize], *(self._measured(found) for found in arrays.values())))
        said = [self.summary()]
        if self.is_another and design.base.answers and design.best.answers:
            said.append(self._without_feedback())
        refused = [f"the best is refused: {design.best.why_not}"] if design.best.why_not else []
        end = "every candidate is exact and its answers are proved; that none is better is not"
        return [
            *sentences(*said),
            table(("question", *arrays), rows, (1.0, *(2.0 for _ in arrays))),
            *sentences(*refused),
            *([table(*self.table(), (1.0, 2.0, 1.0, 1.0))] if self.is_another else []),
            *sentences(end if design.fewest is None else _fewest_words(design.fewest)),
        ]

    def summary(self) -> str:
        """What was found, in a line: first whether anything is better."""
        design, name = self.design, one_line(self.design.scene.name)
        if design.impossible:
            return f"{name}: no speeds meet the requirements: {design.impossible}"
        asked, checked = ", ".join(self.wish.required), f"{design.checks} array{'s' * (design.checks != 1)}"
        if not design.is_found:
            if len(self.wish.required) == 1:
                return f"{name}: none of {checked} meets {asked}"
            return f"{name}: none of {checked} meets all of {asked}; the nearest lacks {', '.join(design.best.unmet)}"
        if self.improved is False:
            return f"{name}: nothing is improved: of {checked} checked none is better than the given one"
        return f"{name}: {self._change()}; found with {asked} among {checked} checked"

    def _said(self) -> Iterator[tuple[str, str]]:
        for answer in self.design.best.answers:
            yield answer.name, _in_words(answer)
        objective = self.wish.maximize
        yield objective, f"{_text(self.value)}, {WHAT[objective]}; of the given array {_text(self.given_value)}"

    def __repr__(self) -> str:
        return short_lines(self.summary(), self._said())


class DesignStudy(SceneStudy[DesignOptions]):
    """A search for a better array."""

    options = DesignOptions
    changes = tuple(name for name in SceneStudy.changes if name != "exact")

    def load(self, scene: Any, options: DesignOptions, *, allow_outside: bool = False, **changes: Any) -> GivenArray:
        """The given array."""
        with deep_nesting_refused(scene):
            document, label, path = read_document(scene, **changes)
            return GivenArray(document, path.parent, build_scene(document, label, path, allow_outside=allow_outside))

    def refuse(self, asked: StudyRequest[DesignOptions], path: Path | None) -> None:
        """Refuse files that cannot be written."""
        from nonsmooth.reports.derivations.derivation import REPORT_FORMATS

        for file, endings in ((asked.options.output, SCENES), (asked.options.report, REPORT_FORMATS)):
            if file is not None:
                output_path(file, endings)

    def run(self, scene: GivenArray, options: DesignOptions) -> DesignResult[Any]:
        """Search, and write what was found."""
        from nonsmooth.reports.designs.design import DesignError, find_named, read_freedom, read_wish

        with option_named(DesignError):
            wish = read_wish(scene.scene, options.require, options.maximize, options.checks, options.seed)
            freedom = read_freedom(scene.scene, options.free, options.move, options.symmetry)
        with progress("checked") as told:
            result: DesignResult[Any] = DesignResult(find_named(*scene, freedom, wish, told), wish)
        files = [file for file in (options.output, options.report) if file is not None]
        if result.is_found and result.improved is False:
            for file in files:
                notice(file, "not written: the given array would stand in it unchanged")
        elif result.is_found:
            if options.output is not None:
                result.save(options.output)
            if options.report is not None:
                _write_report(result.design.document, scene.folder, options)
        return result


DESIGN = DesignStudy()


def _write_report(document: dict[str, Any], folder: Path, options: DesignOptions) -> None:
    """The derivation report of a scene that need not be on the disk, without what takes minutes.

    Its commands name the file that was written, or one of the scene's name in the reader's own folder.
    """
    from nonsmooth.reports.checks.subject import Invocation
    from nonsmooth.reports.derivations.derivation import derive_report
    from nonsmooth.reports.derivations.parts import chosen_parts
    from nonsmooth.symbolic.mechanics.contact_set import standing

    name, path = str(document["name"]), str(options.report)
    file = folder / f"{name}.toml"
    how = Invocation(str(options.output or file.name), (), ("--without", MEASUREMENTS, "-o", path))
    scene = standing(build_scene(document, name, file))
    derive_report(scene, how, chosen_parts((), MEASUREMENTS.split(","))).write_to(Path(path))


def _fewest_words(fewest: SmallestChoice) -> str:
    """What is proved of smaller choices."""
    if not fewest.all_checked:
        return "not all choices were checked (--checks allows more)"
    which = "no choice" if fewest.count is None else f"no choice of fewer than {fewest.count}"
    which += " of the wheels under the body"
    if fewest.order > 1:
        which += f" that keeps its symmetry (turns by 1/{fewest.order})"
    if fewest.undecided:
        return f"{which} is known to suffice; {fewest.undecided} choices are undecided, all others are refuted"
    return f"{which} suffices: all were checked and refuted"


def _in_words(answer: Answer) -> str:
    """An answer; a design shows no clauses below it."""
    from nonsmooth.proofs.answers.answer import WHY_BELOW

    return f"{answer.verdict}: {answer.sentence.replace(WHY_BELOW, '; check says why')}"


def _from_to(before: Answer, after: Answer) -> str:
    """``position comes home, as before (certified within 0.5 -> 0.031)``."""
    said = f"{before.name} {before.verdict}"
    said += f" -> {after.verdict}" if after.verdict != before.verdict else ", as before"
    within = [_text(float(answer.numbers["within"])) for answer in (before, after) if answer.numbers.get("within")]
    return f"{said} (certified within {within[0]} -> {within[1]})" if len(set(within)) > 1 else said


def _text(value: float | None) -> str:
    return "-" if value is None else float_text(value, DIGITS)


def _evaluation(found: Evaluation) -> Record:
    answers = {answer.name: {"verdict": str(answer.verdict), **fact_record(answer.facts)} for answer in found.answers}
    return {"value": found.value, "unmet": list(found.unmet), "why_not": found.why_not or None, "answers": answers}
