"""What a check of a plain system, and an audit of a Lyapunov function, have found."""

from __future__ import annotations

import shlex
from abc import abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

from nonsmooth.proofs.findings import Record, Translation
from nonsmooth.proofs.system_decision import STABILITY, StabilityResult
from nonsmooth.proofs.system_facts import (
    approach_words,
    arrival_words,
    audit_facts,
    basin_words,
    displacement_facts,
    gain_words,
    global_words,
    rate_words,
    reached_words,
    region_rate_words,
    reshaped_words,
    rewriting_words,
    system_facts,
)
from nonsmooth.proofs.systems.domain import DecayKind
from nonsmooth.proofs.systems.findings import Method
from nonsmooth.reports.output.document import Block, findings, sentences
from nonsmooth.reports.output.facts import fact_record, fact_rows, with_exact
from nonsmooth.reports.output.progress import progress
from nonsmooth.reports.studies.result import FORMATS, DataTable, Formats, Result, short_lines
from nonsmooth.symbolic.messages.scene_error import SceneError, one_line
from nonsmooth.symbolic.numbers.number_field import angle_notes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from rich.console import RenderableType

    from nonsmooth.proofs.findings import Fact
    from nonsmooth.proofs.system_audit import AuditResult
    from nonsmooth.proofs.systems.findings import ExaminedFunction
    from nonsmooth.reports.exchange.formulas import FieldFormulas
    from nonsmooth.symbolic.systems.switched_system import SwitchedSystem


# ---- files for other programs --------------------------------------------------------------------
#
# Files of a decided plain system for other programs: provers (.smt2, .kyx), and the field with V (.py, .c).


MOST_TERMS = 16  # of a V that lines name whole
PROGRAM_LANGUAGES = {".py": "python", ".c": "c"}


def _program(result: Any, ending: str) -> bytes:
    return result.formulas().program(PROGRAM_LANGUAGES[ending]).encode()


def _problem(result: Any, ending: str) -> bytes:
    """The inequalities that the certificate of a check of a plain system rests on.

    Raises:
        NoCertificateError: where there is no certificate.
        SceneError: for a verdict that rests on no inequality.
    """
    from nonsmooth.proofs.checker.descriptions import describe
    from nonsmooth.reports.exchange.obligations import keymaerax_text, obligations_of, smtlib_text

    certificate = result.certificate()
    states = " and ".join(f"z{k} of {name}" for k, name in enumerate(result.evidence.scene.states))
    head = [f"{result.evidence.scene.name}: written by nonsmooth. What its certificate states:"]
    head += [f"  {line}" for line in describe(certificate["statement"])]
    head += [f"In displacements from the point over the half-width of the checked cube: {states},"]
    head += ["or what the certificate names in place of a state (a root, sine and cosine)."]
    head += ["A query with weights w is about all mixtures of fields that are tangent to a surface: sliding."]
    text = smtlib_text if ending == ".smt2" else keymaerax_text
    return text(obligations_of(certificate, result.evidence.scene.origin), head).encode()


EXPORTS: Formats = {
    ".smt2": _problem,
    ".kyx": _problem,
    ".py": _program,
    ".c": _program,
}


# ---- results -------------------------------------------------------------------------------------


SYSTEM_SCHEMA = "nonsmooth-check/1"
AUDIT_SCHEMA = "nonsmooth-audit/1"
LARGER = "--region best certifies a larger region, in about a minute"
UNSOUGHT = "no larger region was sought: its programs are too large for --region fast, --region best tries them"


MEANINGS = {
    Translation.ASYMPTOTICALLY_STABLE: "every solution from near the equilibrium stays near it and comes to it",
    Translation.STABLE: "every solution from near the equilibrium stays near it",
    Translation.UNSTABLE: "from as near the equilibrium as one likes some solution goes away",
}  # of the verdicts, for solutions of the inclusion


KINDS_OF_RATES = {
    DecayKind.FINITE: "in finite time",
    DecayKind.EXPONENTIAL: "exponentially",
    DecayKind.ALGEBRAIC: "algebraically",
}


class SystemAnswer(NamedTuple):
    """What somebody wants to know of a plain system.

    Attributes:
        question: a word or two.
        answer: likewise.
        sentence: what it says, with its numbers and where they hold.
    """

    question: str
    answer: str
    sentence: str


class FactResult(Result):
    """A headline, and what was found by its names."""

    @property
    @abstractmethod
    def found(self) -> Sequence[Fact]:
        """What was found."""

    @property
    @abstractmethod
    def verdict(self) -> str:
        """In words."""

    @abstractmethod
    def headline(self) -> str:
        """What was judged."""

    def table(self) -> DataTable:
        """One line for each thing that is said."""
        return DataTable(("what", "found"), fact_rows(self.found))

    def blocks(self) -> Sequence[Block]:
        """The headline, and the lines as a table."""
        return [*sentences(self.headline()), findings(fact_rows(self.found))]

    def summary(self) -> str:
        """The verdict."""
        return self.verdict


@dataclass(frozen=True, repr=False)
class SystemCheckResult(FactResult):
    """What a check of a plain system found: the V that proves it, or what the scene's V shows, and the derivatives.

    ``save`` writes the problem for other provers too (``.smt2``, ``.kyx``), and the field with V as a program (``.py``,
    ``.c``).

    Attributes:
        evidence: everything that was proved; ``evidence.check()`` asks the stand-alone checker.
        shows_evidence: whether a terminal shows all of it.
        hint: what a longer search may find; empty without.
        required: what exit status 0 says, of REQUIRABLE (:mod:`nonsmooth.proofs.system_decision`).
    """

    formats: ClassVar[Formats] = {**FORMATS, **EXPORTS}

    evidence: StabilityResult
    shows_evidence: bool = False
    hint: str = ""
    required: tuple[str, ...] = (STABILITY,)

    @property
    def verdict(self) -> str:
        """Asymptotically stable, stable, unstable or undecided."""
        return str(self.evidence.verdict)

    @property
    def reason(self) -> str:
        """Why, in one sentence."""
        return self.evidence.reason

    def certificate(self) -> Record:
        """What ``--certificate`` writes; see :meth:`Result.certificate`."""
        from nonsmooth.proofs.system_certificates import certificate_of

        return certificate_of(self.evidence)

    def with_region(self, search: str) -> SystemCheckResult:
        """The same with a larger region, where one is certified: see ``nonsmooth check --region``.

        In two states it consists of triangles, in three of tetrahedra, beside a sublevel set of
        another V as in more states.

        Args:
            search: ``fast`` or ``best``.

        Raises:
            ValueError: for another search.
        """
        if search not in ("fast", "best"):
            raise ValueError(f"search: required fast or best, received {search!r}")
        if not self.evidence.has_local_region:
            return self
        from nonsmooth.proofs.many_states.reshaped_region import TooMuchWorkError
        from nonsmooth.proofs.system_certificates import find_region_of_another_function, find_region_of_simplices

        in_plane, basin, reshaped = self.evidence.scene.is_planar, None, None
        hint = ""
        with progress(f"{self.verdict}; region") as report:

            def announce(what: str, done: int, total: int) -> None:
                report(done, total, what)

            if not in_plane:
                try:
                    reshaped = find_region_of_another_function(self.evidence, search, announce)
                except TooMuchWorkError:
                    hint = UNSOUGHT
            evidence = replace(self.evidence, reach=replace(self.evidence.reach, reshaped=reshaped))
            basin = find_region_of_simplices(evidence, search, announce)
            hint = LARGER if basin and search == "fast" else hint
        reach = replace(self.evidence.reach, basin=basin, reshaped=reshaped)
        return replace(self, evidence=replace(self.evidence, reach=reach), hint=hint)

    def draw(self, ax: Axes) -> None:
        """Of two states the certified triangles, with the border of the region; without these the phase portrait.

        Raises:
            TypeError: in one state, in three and more, and without triangles for several right-hand sides, and beside
                square roots of states.
        """
        system, basin = self.evidence.scene, self.evidence.reach.basin
        has_portrait = system.has_one_field and system.by_roots is None
        if not system.is_planar or not (basin or has_portrait):
            required = "a system in two states with one right-hand side and no roots of states, for a picture"
            raise TypeError(f"required {required}, received {system.name} in {', '.join(system.stated_states)}")
        if basin is None:
            from nonsmooth.reports.checks.phase_portrait import PhasePortrait

            PhasePortrait(system, self.evidence).draw(ax)
        else:
            from nonsmooth.reports.figures.cells import draw_triangles

            draw_triangles(ax, basin)
        x, y = system.states
        ax.set(xlabel=x, ylabel=y, aspect="equal", title=f"{one_line(system.name)}: {self.verdict}")

    @property
    def _function(self) -> ExaminedFunction | None:
        """The function that shows stability; None where none does."""
        functions = (finding.function for finding in reversed(self.evidence.findings))
        return next((function for function in functions if function is not None and not function.grows), None)

    @property
    def lyapunov(self) -> str | None:
        """The function that shows stability, as text; None where none does."""
        return None if self._function is None else self._function.text

    def formulas(self) -> FieldFormulas:
        """The stated field and the function that shows stability, for SymPy, CasADi, Python and C.

        ``formulas().sympy()``, ``.casadi()``, ``.program("python")`` and ``.program("c")``.
        """
        from nonsmooth.reports.exchange.formulas import formulas_of

        return formulas_of(self.evidence.scene, self._function)

    @property
    def exit_status(self) -> int:
        """0 where what is required is shown, stability unless told; 1 where it is refuted, else 3."""
        return self.evidence.status(self.required)

    @property
    def found(self) -> Sequence[Fact]:
        """See :class:`FactResult`."""
        return tuple(system_facts(self.evidence))

    def facts(self) -> Record:
        """The JSON record of ``nonsmooth check --json``."""
        scene = self.evidence.scene
        head = {"schema": SYSTEM_SCHEMA, "scene": scene.name, "states": list(scene.states)}
        radius = with_exact({"radius": scene.check.radius})
        return {**head, **radius, **fact_record(self.found), "notes": list(angle_notes(scene.field))}

    def headline(self) -> str:
        """The system."""
        scene = self.evidence.scene
        return f"{one_line(scene.name)}: plain switched system in {', '.join(scene.stated_states)}"

    def views(self) -> Sequence[RenderableType]:
        """The answers, with what the letters in them stand for, or with all that was found."""
        from rich.console import Group
        from rich.text import Text

        from nonsmooth.reports.output.terminal import MORE, answers_table, blocks_view, notes_lines

        scene = self.evidence.scene
        head = Text(one_line(scene.name), "bold")
        head.append(f": plain switched system in {', '.join(scene.stated_states)}", "not bold")
        stated = fact_rows(displacement_facts(scene)) if len(scene.states) > 1 else []
        rewritten = rewriting_words(scene, in_time_of_states=self.evidence.is_in_time_of_states)
        stated += [("field", rewritten)] if rewritten else []
        details: list[RenderableType] = [Text(f"{name}: {words}") for name, words in stated]
        if self.shows_evidence:
            details = [blocks_view([findings(fact_rows(self.found))])]
        more: list[RenderableType] = [] if self.shows_evidence else [Text(MORE, "dim")]
        answers = answers_table(system_answers(self.evidence))
        if self.hint:
            more.append(Text(self.hint, "dim"))
        if self.evidence.verdict in (Translation.STABLE, Translation.UNDECIDED):
            more += [Text(line, "dim") for line in _smaller(scene)]
        if self.evidence.method is Method.EQUILIBRIUM:
            more.append(Text(f"nonsmooth equilibria {shlex.quote(scene.origin)} finds what rests about it", "dim"))
        return [Group(head, answers, *details, *notes_lines(scene.field), *more)]

    def __repr__(self) -> str:
        return short_lines(f"{self.evidence.scene.name}: {self.verdict}", fact_rows(self.found))


def _smaller(scene: SwitchedSystem) -> list[str]:
    """The command that writes a smaller system, whose equilibria may be isolated; empty where there is none."""
    from nonsmooth.symbolic.systems.reduction import reduce_system

    try:
        meaning = "; ".join(reduce_system(scene).meaning)
    except SceneError:
        return []
    return [f"nonsmooth reduce {shlex.quote(scene.origin)} writes a smaller system: {meaning}"]


@dataclass(frozen=True, repr=False)
class AuditedFunction(FactResult):
    """The verdict on somebody's Lyapunov function.

    Attributes:
        evidence: what was proved.
    """

    evidence: AuditResult

    @property
    def verdict(self) -> str:
        """Valid, invalid or undecided."""
        return str(self.evidence.verdict)

    @property
    def exit_status(self) -> int:
        """0 valid, 1 invalid, 3 undecided."""
        return self.evidence.verdict.exit_status

    @property
    def found(self) -> Sequence[Fact]:
        """See :class:`FactResult`."""
        return tuple(audit_facts(self.evidence))

    def facts(self) -> Record:
        """The JSON record of ``nonsmooth audit --json``."""
        return {"schema": AUDIT_SCHEMA, "scene": self.evidence.scene.name, **fact_record(self.found)}

    def headline(self) -> str:
        """What is audited."""
        return f"{one_line(self.evidence.scene.name)}: audit of a Lyapunov function"


# ---- answers about a plain system ----------------------------------------------------------------


def system_answers(result: StabilityResult) -> Iterator[SystemAnswer]:
    """Whether the point is stable, from where and how fast solutions come to it, and what proves it."""
    verdict = result.verdict
    if verdict is Translation.UNDECIDED:
        yield SystemAnswer("stability", str(verdict), result.reason)
    else:
        yield SystemAnswer("stability", str(verdict), MEANINGS[verdict])
    if verdict is Translation.ASYMPTOTICALLY_STABLE:
        yield _from_where(result)
        yield _how_fast(result)
        if result.reach.gain is not None:
            yield SystemAnswer("disturbed", "bounded", gain_words(result.reach.gain, result.scene.states))
    if result.reach.approach is not None:
        words = approach_words(result.reach.approach, result.scene.states)
        yield SystemAnswer("approaches", "equilibria", words)
    if verdict is not Translation.UNDECIDED:
        yield SystemAnswer("proved by", str(result.method), _proof_words(result))
    tried = result.given
    if tried is not None and tried is not result.function and not result.scene.check.is_default:
        words = f"V = {tried.text}: {tried.reason} (on {tried.domain.text(result.scene.states)})"
        yield SystemAnswer("the scene's V", tried.decrease.name.lower(), words)


def _from_where(result: StabilityResult) -> SystemAnswer:
    """The most starts that are certified to reach an asymptotically stable point."""
    question, reach, states = "from where", result.reach, result.scene.states
    if reach.everywhere:
        why = "" if reach.global_entry is None else f": {global_words(reach.global_entry, result.scene.stated_states)}"
        if reach.global_entry is None and reach.homogeneous is not None:
            why = f": the field is {reach.homogeneous}"
        return SystemAnswer(question, "everywhere", f"every start reaches the equilibrium{why}")
    if reach.basin is not None:
        about = reshaped_words(reach.reshaped, states) if reach.reshaped else ""
        about = about or (reached_words(reach.region, states) if reach.region else "")
        return SystemAnswer(question, "a region", f"{about}; {basin_words(reach.basin, states)}")
    if reach.reshaped is not None:
        return SystemAnswer(question, "a region", reshaped_words(reach.reshaped, states))
    if reach.region is not None:
        return SystemAnswer(question, "a region", reached_words(reach.region, states))
    for fact in result.deciding.facts:
        if fact.key == "region" and fact.words:  # in one state an interval
            return SystemAnswer(question, "an interval", fact.words)
    return SystemAnswer(question, "from near it", "how far around it is not certified")


def _how_fast(result: StabilityResult) -> SystemAnswer:
    """The rate at which solutions come to an asymptotically stable point."""
    question, reach, states = "how fast", result.reach, result.scene.states
    farther = f"; {region_rate_words(reach.region_rate, states)}" if reach.region_rate is not None else ""
    rate = "" if reach.rate is None else f"{rate_words(reach, states)}{farther}"
    if reach.homogeneous is not None and reach.homogeneous.arrives:
        if reach.arrival is not None:
            said = [arrival_words(reach.arrival, result.scene.stated_states), f"the field is {reach.homogeneous}"]
        else:
            said = [f"every solution arrives, as the field is {reach.homogeneous}"]
            rate = rate or "no bound is proved"
        return SystemAnswer(question, "in finite time", "; ".join([*said, *([rate] if rate else [])]))
    if reach.rate is not None:
        return SystemAnswer(question, KINDS_OF_RATES[reach.rate.decay], rate)
    if reach.in_finite_time:
        return SystemAnswer(
            question, "in finite time", "solutions near the equilibrium arrive; no bound on the time is proved"
        )
    return SystemAnswer(question, "not known", "no rate is proved")


def _proof_words(result: StabilityResult) -> str:
    """The reason, behind the V that it speaks of."""
    function = result.function
    if function is None:
        return result.reason
    return f"{brief_function(function)}, on {function.domain.text(result.scene.states)}: {result.reason}"


def brief_function(function: ExaminedFunction) -> str:
    """V as a formula, or of how many terms a long one is."""
    terms = len(list(function.formula.summands))
    return f"a V of {terms} terms" if terms > MOST_TERMS else f"V = {function.text}"
