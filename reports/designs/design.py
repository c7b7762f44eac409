"""The study ``design``: which headings, speeds and positions meet what is required, and do best."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Generic, NamedTuple, TypeVar

from nonsmooth.proofs.findings import Record
from nonsmooth.reports.output.document import Block, sentences, table
from nonsmooth.reports.output.entries import as_json, toml_text
from nonsmooth.reports.output.facts import fact_record
from nonsmooth.reports.output.files import output_path
from nonsmooth.reports.output.progress import notice, progress
from nonsmooth.reports.output.refusals import option_named
from nonsmooth.reports.output.study_options import Options, option
from nonsmooth.reports.studies.result import DataTable, Formats, Result, short_lines
from nonsmooth.reports.studies.study import SceneStudy, StudyRequest
from nonsmooth.symbolic.files.documents import deep_nesting_refused, read_document
from nonsmooth.symbolic.files.scene_file import build_scene
from nonsmooth.symbolic.messages.scene_error import one_line
from nonsmooth.symbolic.numbers.number_text import float_text
from nonsmooth.symbolic.numbers.plane import in_floats

if TYPE_CHECKING:
    from nonsmooth.proofs.answers.answer import Answer
    from nonsmooth.reports.designs.search import Design, Evaluation, Fewest, Wish
    from nonsmooth.symbolic.mechanics.scene import Scene, Wheel

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
    wish: Wish
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
        rows.append((WHAT[self.wish.maximize], *(_text(found.value) for found in arrays.values())))
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
        from nonsmooth.reports.designs.request import DesignError, find_named, read_freedom, read_wish

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


def _fewest_words(fewest: Fewest) -> str:
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
