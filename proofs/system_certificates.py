"""Certificates of plain systems: for each verdict the theorem that shows it, with evidence for the checker.

A theorem's hypotheses are taken from the result of a check: the function V that decided, its domain, what was proved of
regions and rates.  Evidence that the check has found is written as it is, what is missing is searched
(:mod:`nonsmooth.proofs.kernel.search`); so a verdict may have a certificate however it was decided.  What is written
has passed the checker.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import partial
from itertools import product
from typing import Any, TypeAlias

from nonsmooth.proofs.checker.cells import System
from nonsmooth.proofs.checker.files import read
from nonsmooth.proofs.checker.roots import read_subject
from nonsmooth.proofs.checker.statements import VERSION, refusal
from nonsmooth.proofs.checker.theorems import Statement
from nonsmooth.proofs.kernel.search import NotShownError, Search, stability_hypotheses
from nonsmooth.proofs.kernel.second_function import find_second
from nonsmooth.proofs.kernel.sign_cells import BeyondReachError, IrrationalError, surfaces_of
from nonsmooth.proofs.kernel.stated_cells import StatedCells, stated_cells
from nonsmooth.proofs.kernel.subject import NoCertificateError, about, exact_text
from nonsmooth.proofs.many_states.conclusion import ManyStateMethod
from nonsmooth.proofs.many_states.decision import ManyStateResult
from nonsmooth.proofs.many_states.facts import rate_words as many_rate_words
from nonsmooth.proofs.many_states.facts import region_words as many_region_words
from nonsmooth.proofs.scalar_theorems import scalar_theorem
from nonsmooth.proofs.strategies import show_verdict
from nonsmooth.proofs.system_decision import DecidedSystem
from nonsmooth.proofs.systems.conclusion import Method
from nonsmooth.proofs.systems.derivatives import Decrease
from nonsmooth.proofs.systems.scalar_stability import ScalarResult
from nonsmooth.proofs.systems.system_facts import (
    gain_words,
    proving_pieces,
    proving_text,
    rate_words,
    reached_words,
    region_rate_words,
    rewriting_words,
)
from nonsmooth.proofs.systems.system_stability import SystemResult
from nonsmooth.proofs.systems.written_potential import PotentialPiece
from nonsmooth.proofs.verdicts import Translation
from nonsmooth.symbolic.enclosed_numbers import NoEnclosureError, enclose_numbers
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.piecewise import PiecewiseExpression, parse_piecewise
from nonsmooth.symbolic.scene_error import one_line
from nonsmooth.symbolic.switched_system import SwitchedSystem

LEFT_OUT = "left out"  # key of the notes
MOST_LEFT_OUT, LONGEST = 16, 400  # lines of it that are read, and characters of each
NEARLY = Fraction(63, 64)  # of the level of a largest region, where all of it is not shown
UNSHOWN = "the checker does not show it"

Record: TypeAlias = dict[str, Any]


@dataclass(frozen=True)
class Option:
    """What a theorem may state beyond the verdict.

    Attributes:
        hypotheses: that it needs.
        words: what a check prints of it.
    """

    hypotheses: Record
    words: str


@dataclass(frozen=True)
class Candidate:
    """A theorem that may show a verdict.

    Attributes:
        theorem: its name.
        hypotheses: without proofs.
        options: each is stated if it is shown too.
        known: evidence that the check has found already, by the names of claims.
        needs_second: whether V does not fall everywhere, and further functions have to be found.
    """

    theorem: str
    hypotheses: Record
    options: tuple[Option, ...] = ()
    known: Record = field(default_factory=dict)
    needs_second: bool = False


def certificate_of(result: DecidedSystem) -> Record:
    """The certificate of a verdict on a plain system; it has passed the checker.

    Raises:
        NoCertificateError: for an undecided verdict, for numbers with roots, and where no theorem's hypotheses are
            shown: what the first one lacks.
    """
    if result.verdict is Translation.UNDECIDED:
        raise NoCertificateError("a certificate needs a verdict, received undecided")
    result = replace(result, scene=in_rational_numbers(result.scene))
    subject = about(result.scene)
    system, reasons = read_subject(subject), list[str]()
    try:
        for show in _ways(result, system):
            try:
                draft = show()
            except NotShownError as error:
                reasons.append(str(error))
                continue
            for further in _further(result):
                draft.add(system, further)
            draft.left_out += _beyond_words(result, draft)
            return _checked(result.scene, subject, draft)
    except IrrationalError:
        expected = "a certificate of a plain system needs rational numbers, received some with roots"
        raise NoCertificateError(expected) from None
    except BeyondReachError as error:
        reasons.append(str(error))
    raise NoCertificateError(f"{UNSHOWN}: {reasons[0]}")


def in_rational_numbers(system: SwitchedSystem) -> SwitchedSystem:
    """What a certificate about a system speaks of: the system, or one in rational numbers that encloses it.

    Raises:
        NoCertificateError: where there is none.
    """
    try:
        return enclose_numbers(system)
    except NoEnclosureError as error:
        raise NoCertificateError(f"a certificate of a plain system needs rational numbers, received {error}") from None


def _shown(system: System, candidate: Candidate) -> Draft:
    """The evidence of a theorem with as many of its options as are shown, and what is left out.

    Raises:
        NotShownError: where the verdict itself is not shown.
    """
    search, hypotheses = Search(known=candidate.known), candidate.hypotheses
    if candidate.needs_second:
        hypotheses = hypotheses | {"second": _second(system, hypotheses, search)}
    every = hypotheses.copy()
    for option in candidate.options:
        every |= option.hypotheses
    with suppress(NotShownError):
        entry, statements = search.entry(system, candidate.theorem, every)
        return Draft([entry], statements, [])
    entry, statements = search.entry(system, candidate.theorem, hypotheses)
    left_out = []
    for option in candidate.options:
        more = {**hypotheses, **option.hypotheses}
        try:
            entry, statements = search.entry(system, candidate.theorem, more)
        except NotShownError as error:
            left_out.append(f"{option.words}: {UNSHOWN}: {error}")
        else:
            hypotheses = more
    return Draft([entry], statements, left_out)


def _second(system: System, hypotheses: Record, search: Search) -> Record:
    """Functions that rise one after the other where V, which does not rise, is kept.

    Raises:
        NotShownError: where none are found.
    """
    found = find_second(system, hypotheses["cells"], hypotheses["function"], search)
    if found is None:
        raise NotShownError("no functions were found that rise where V is kept")
    return found


@dataclass
class Draft:
    """A certificate that is being written: its evidence, what that shows, and what is left out in words."""

    evidence: list[Record]
    statements: list[Statement]
    left_out: list[str]

    def add(self, system: System, option: Option) -> None:
        """One more use of theorem ``lyapunov``, if it is shown: below its level, else below one a little smaller.

        V may stand still on the border of a largest region.
        """
        level = Fraction(option.hypotheses["level"])
        for share in (Fraction(1), NEARLY):
            try:
                entry, statements = Search().entry(
                    system, "lyapunov", {**option.hypotheses, "level": str(level * share)}
                )
            except NotShownError as error:
                if share == 1:
                    self.left_out.append(f"{option.words}: {UNSHOWN}: {error}")
                continue
            self.evidence.append(entry)
            self.statements += [own for own in statements if own not in self.statements]
            return


def _checked(system: SwitchedSystem, subject: Record, draft: Draft) -> Record:
    """A certificate that the checker accepts.

    Raises:
        NoCertificateError: where it does not, within its limits of work.
    """
    noted = {**notes(system), LEFT_OUT: draft.left_out} if draft.left_out else notes(system)
    certificate = {
        "version": VERSION,
        "statement": {"subject": subject, "claims": draft.statements},
        "evidence": draft.evidence,
        "notes": noted,
    }
    refused = refusal(certificate, len(certificate_text(certificate)))
    if refused:
        raise NoCertificateError(f"{UNSHOWN}: required {refused}")
    return certificate


# ---- theorems that may show a verdict ----------------------------------------------------------


def _ways(result: DecidedSystem, system: System) -> Iterator[Callable[[], Draft]]:
    """Ways to show a verdict, in the order in which they are tried."""
    if isinstance(result, ScalarResult):
        yield partial(_shown, system, Candidate(*scalar_theorem(result, system)))
        return
    by_functions = _in_many_states(result) if isinstance(result, ManyStateResult) else _in_the_plane(result)
    for candidate in by_functions:
        yield partial(_shown, system, candidate)
    yield partial(_by_strategies, result)


def _by_strategies(result: DecidedSystem) -> Draft:
    """By what shows the verdict near the point, or a function that is searched now."""
    entry, statements = show_verdict(result.scene, str(result.verdict))
    return Draft([entry], statements, [])


def _in_the_plane(result: SystemResult) -> Iterator[Candidate]:
    """The V that decided, on its domain."""
    system, domain = result.scene, result.domain
    if result.proving is None or domain is None:
        return
    grows = result.method is Method.GROWTH
    # Where V grows on all of the plane a square is enough, and bounded.
    radius = system.check.radius if grows and domain.radius is None else domain.radius
    function, cells = _stated_function(system, radius, proving_pieces(result), proving_text(result))
    if grows:
        hypotheses = {"cells": cells.record, "function": _negated(function), "second": None}
        yield Candidate("instability", {**hypotheses, "direction": _open_direction(system, cells.surfaces)})
        return
    options = []
    if result.everywhere:
        options.append(Option({"everywhere": True}, "all starts in the plane reach the equilibrium"))
    if result.near is not None:
        words = reached_words(result.near, system.states)
        options.append(Option({"level": exact_text(result.near.level)}, words))
    if result.rate is not None and system.by_roots is None:  # rates are in the time of the roots
        rate = {"kind": result.rate.decay.name.lower(), "kappa": exact_text(result.rate.kappa)}
        options.append(Option({"rate": rate}, rate_words(result)))
        if result.gain is not None and result.gain.rate == result.rate:
            gain = {"rate": rate, "gain": exact_text(result.gain.gamma)}
            options.append(Option(gain, gain_words(result)))
    weak = result.method is Method.INVARIANCE
    yield Candidate(
        "lyapunov", stability_hypotheses(cells.record, function, str(result.verdict)), tuple(options), needs_second=weak
    )
    if result.searched is not None and result.lyapunov.verdict is Decrease.WEAK:
        yield _by_stated_function(result)


def _by_stated_function(result: SystemResult) -> Candidate:
    """The scene's own V and LaSalle's principle, for a searched V that falls, of higher degree, and is not shown."""
    radius, text = result.reported_domain.radius, one_line(result.scene.check.lyapunov.text)
    function, cells = _stated_function(result.scene, radius, (), text)
    return Candidate("lyapunov", stability_hypotheses(cells.record, function, str(result.verdict)), needs_second=True)


def _in_many_states(result: ManyStateResult) -> Iterator[Candidate]:
    """The V that decided, on its cube."""
    system, growth, proving = result.scene, result.evidence.growth, result.proving
    if growth is not None and result.verdict is Translation.UNSTABLE:
        yield Candidate("instability", growth.entry["hypotheses"], known=growth.entry["proofs"])
    if proving is None:
        return
    if result.method is ManyStateMethod.INVARIANCE and result.evidence.attraction is not None:
        known = result.evidence.attraction
        yield Candidate("lyapunov", known["hypotheses"], known=known["proofs"])
        return
    own = proving.entry(region=result.region, rate=result.rate)
    hypotheses = own["hypotheses"] | {"verdict": str(result.verdict), "everywhere": False, "level": None, "rate": None}
    options = []
    if own["hypotheses"]["everywhere"]:
        options.append(Option({"everywhere": True}, "all starts in the space reach the equilibrium"))
    if result.region is not None:
        words = many_region_words(result.region, system.states)
        options.append(Option({"level": own["hypotheses"]["level"]}, words))
    if result.rate is not None:
        options.append(Option({"rate": result.rate.record}, many_rate_words(result)))
    yield Candidate("lyapunov", hypotheses, tuple(options), own["proofs"])


def _stated_function(
    system: SwitchedSystem, radius: Number | None, pieces: Sequence[PotentialPiece], text: str
) -> tuple[str | list[list[str]], StatedCells]:
    """V as a certificate states it, and the cells of the system and of V.

    Args:
        system: in any number of states.
        radius: half the side of the cube; None for the whole space.
        pieces: of a V that is known on cones; V is one formula where there are none, or one.
        text: this formula.
    """
    if radius is not None:
        exact_text(radius)
    if len(pieces) <= 1:
        own = str(pieces[0].potential) if pieces else text
        return own, stated_cells(system, radius, surfaces_of(system, _parsed(own, system)))
    sides = [_sides(system, piece) for piece in pieces]
    cells = stated_cells(system, radius, [line for own in sides for line, _ in own])
    return [[cells.signs(own), str(piece.potential)] for own, piece in zip(sides, pieces, strict=True)], cells


def _parsed(text: str, system: SwitchedSystem) -> PiecewiseExpression:
    return parse_piecewise(text, system.states)


def _sides(system: SwitchedSystem, piece: PotentialPiece) -> list[tuple[Polynomial, int]]:
    """The lines through both rays of a cone, each with its sign inside."""
    if piece.start is None or piece.end is None:
        raise NoCertificateError("a certificate needs a V on cones with both rays")
    x, y = system.coordinates()
    first, last = (y * ray[0] - x * ray[1] for ray in (piece.start, piece.end))
    return [(first, 1), (last, -1)]


def _negated(function: str | list[list[str]]) -> Any:
    if isinstance(function, str):
        return f"-({function})"
    return [[signs, f"-({own})"] for signs, own in function]


def _open_direction(system: SwitchedSystem, surfaces: Sequence[Polynomial]) -> list[str]:
    """A direction that leads from the point into a cell: no surface vanishes along it."""
    for size in range(1, 20):
        for direction in product(range(-size, size + 1), repeat=len(system.states)):
            if any(direction) and all(_varies(surface, direction) for surface in surfaces):
                return list(map(str, direction))
    raise NoCertificateError("a certificate needs a direction that leads into a cell, found none")


def _varies(surface: Polynomial, direction: Sequence[int]) -> bool:
    """Whether a polynomial is not zero along a ray from the origin: the sums of terms of one degree decide."""
    by_degree: dict[int, Number] = {}
    for exponents, coefficient in surface.terms.items():
        factor = 1
        for x, exponent in zip(direction, exponents, strict=True):
            factor *= x**exponent
        degree = sum(exponents)
        by_degree[degree] = by_degree.get(degree, surface.field.zero) + coefficient * factor
    return any(by_degree.values())


def _further(result: DecidedSystem) -> Iterator[Option]:
    """A region that reaches beyond the square on which V falls everywhere, and the rate there: asked below a level."""
    if not isinstance(result, SystemResult) or result.region is None or result.region == result.near:
        return
    system, region, far = result.scene, result.region, result.region_rate
    function, cells = _stated_function(system, region.radius, proving_pieces(result), proving_text(result))
    own = {**stability_hypotheses(cells.record, function, str(result.verdict)), "below": True}
    words = reached_words(region, system.states)
    yield Option({**own, "level": exact_text(region.level)}, words)
    if far is not None:
        rate = {"kind": "exponential", "kappa": exact_text(far.kappa)}
        yield Option({**own, "level": exact_text(far.level), "rate": rate}, region_rate_words(result))


# ---- what a certificate does not hold ----------------------------------------------------------


def _beyond_words(result: DecidedSystem, draft: Draft) -> Iterator[str]:
    """What a check says that the certificate has no words for, or no theorem."""
    if isinstance(result, SystemResult):
        yield from _beyond_in_the_plane(result, draft)
    elif isinstance(result, ManyStateResult) and result.everywhere and not _attracts_everywhere(draft):
        yield "all starts in the space reach the equilibrium: V is certified on a cube"


def _beyond_in_the_plane(result: SystemResult, draft: Draft) -> Iterator[str]:
    states, kinds = result.scene.states, {kind for statement in draft.statements for kind in statement}
    if result.near is not None and "attracts" not in kinds and not any("level" in own for own in draft.left_out):
        yield f"{reached_words(result.near, states)}: another theorem shows the verdict"
    if result.rate is not None and "rate" not in kinds and not draft.left_out:
        yield f"{rate_words(result)}: another theorem shows the verdict"
    if result.everywhere and not _attracts_everywhere(draft):
        yield "all starts in the plane reach the equilibrium: the verdict is certified near the point"
    if result.finite_time:
        yield "solutions near the equilibrium arrive in finite time: certificates hold no times of roots"


def _attracts_everywhere(draft: Draft) -> bool:
    return {"attracts": "everywhere"} in draft.statements


def notes(system: SwitchedSystem) -> Record:
    """The name of the scene, and the stated formulas where the right-hand sides are others; nothing that is proved."""
    found: Record = {"scene": system.name}
    if system.written:
        found["stated"] = [[one_line(formula) for formula in member] for member in system.written]
        found["right-hand sides"] = rewriting_words(system)
    return found


# ---- files -------------------------------------------------------------------------------------


def certificate_text(certificate: Record) -> str:
    """As the file is written."""
    return json.dumps(certificate, indent=1, ensure_ascii=True) + "\n"


def left_out(certificate: Record) -> list[str]:
    """What the notes of a certificate say that it does not hold, as lines; the checker reads no notes."""
    noted = certificate.get("notes")
    said = noted.get(LEFT_OUT, []) if isinstance(noted, dict) else []
    lines = said if isinstance(said, list) else []
    return [one_line(str(line))[:LONGEST] for line in lines[:MOST_LEFT_OUT]]


def find_system_difference(file: str, system: SwitchedSystem) -> str:
    """The first key in which a certificate that was accepted is about another system; empty where there is none.

    Args:
        file: of the certificate.
        system: to compare with, formula by formula as text.

    Raises:
        NoCertificateError: for a point that no certificate can name.
    """
    data, _ = read(file)
    subject = data["statement"]["subject"]
    own = about(in_rational_numbers(system))
    return next((f"other {key}" for key, value in own.items() if subject[key] != value), "")
