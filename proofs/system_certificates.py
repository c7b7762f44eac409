"""Certificates of plain systems: for each verdict the theorem that shows it, with evidence for the checker.

A theorem's hypotheses are taken from the result of a check: the function V that decided, its domain, what was proved of
regions and rates.  In three states and more the check itself has found evidence, which is written as it is; all other
is searched (:mod:`nonsmooth.proofs.kernel.search`), so a verdict may have a certificate however it was decided.  What
is written has passed the checker.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import partial
from typing import Any

from nonsmooth.proofs.checker.basin import NAMES
from nonsmooth.proofs.checker.cells import System
from nonsmooth.proofs.checker.files import read
from nonsmooth.proofs.checker.parts import CONTINUOUS, roots_of
from nonsmooth.proofs.checker.roots import read_subject
from nonsmooth.proofs.checker.statements import VERSION
from nonsmooth.proofs.checker.theorems import Statement
from nonsmooth.proofs.checker.work import RejectedError
from nonsmooth.proofs.falling_function import growth_hypotheses, stated_function
from nonsmooth.proofs.findings import Record, Translation
from nonsmooth.proofs.kernel.arrival import Arrival
from nonsmooth.proofs.kernel.cells import BeyondReachError, stated_cells
from nonsmooth.proofs.kernel.homogeneity import Homogeneity
from nonsmooth.proofs.kernel.search import NotShownError, Search, stability_hypotheses
from nonsmooth.proofs.kernel.second_function import find_second
from nonsmooth.proofs.kernel.subject import NoCertificateError, about, exact_text, subjects_of
from nonsmooth.proofs.many_states.reshaped_region import find_reshaped_region
from nonsmooth.proofs.parts import Parts
from nonsmooth.proofs.system_facts import (
    arrival_words,
    gain_words,
    rate_words,
    reached_words,
    region_rate_words,
    rewriting_words,
)
from nonsmooth.proofs.systems.basin import EFFORTS, CertifiedBasin, find_basin, find_basin_in_space
from nonsmooth.proofs.systems.basin_mesh import Announce
from nonsmooth.proofs.systems.derivatives import Decrease
from nonsmooth.proofs.systems.domain import DecayKind, Domain, ReshapedRegion, SublevelRegion
from nonsmooth.proofs.systems.findings import DecidedSystem, ExaminedFunction, Method, Reach
from nonsmooth.proofs.systems.scalar_stability import distance_hypotheses
from nonsmooth.proofs.theorem_searches import scalar_theorem, show_verdict
from nonsmooth.proofs.verified import verified
from nonsmooth.symbolic.files.system_builder import with_order
from nonsmooth.symbolic.messages.scene_error import one_line
from nonsmooth.symbolic.systems.switched_system import (
    MOST_ORDER,
    Enclosed,
    NoEnclosureError,
    SwitchedSystem,
    enclose_numbers,
)

LEFT_OUT = "left out"  # key of the notes
MOST_LEFT_OUT, LONGEST = 16, 400  # lines of it that are read, and characters of each
REACH = 8  # half-widths of the checked cube: how far tetrahedra are looked for
NEARLY = Fraction(63, 64)  # of the level of a largest region, where all of it is not shown
UNSHOWN = "the checker does not show it"


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
        known: evidence that the check has found already, by the names of claims, of a subject in rational numbers.
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
    certificates, reasons = [], []
    for scene in subjects_of(result.scene):
        try:
            certificates.append(_certificate_about(replace(result, scene=scene)))
        except NoCertificateError as error:
            reasons.append(error)
            continue
        if LEFT_OUT not in certificates[-1]["notes"]:
            return certificates[-1]
    if not certificates:
        raise reasons[0]
    return certificates[0]


def _certificate_about(result: DecidedSystem) -> Record:
    """The certificate of a verdict on a plain system as it stands, or on one that encloses it.

    Raises:
        NoCertificateError: see :func:`certificate_of`.
    """
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
            draft.add_global(system, result.reach.global_entry)
            if result.reach.homogeneous is not None:
                draft.add_homogeneous(system, result.scene, result.reach.homogeneous)
            if result.reach.approach is not None and not system.numbers:
                entry = result.reach.approach
                draft.add_entry(system, entry["theorem"], entry["hypotheses"], entry["proofs"])
            if result.reach.arrival is not None:
                draft.add_arrival(system, result.reach.arrival, result.scene.stated_states)
            if result.reach.basin is not None and system.numbers:
                raise NoCertificateError("a certificate of a mesh of triangles needs rational numbers")
            if result.reach.basin is not None:
                draft.add_entry(system, "basin", result.reach.basin.hypotheses, _known_of(result.reach.reshaped))
                for polygon in result.reach.basin.never:
                    draft.add_entry(system, "outside", polygon)
            if result.reach.reshaped is not None and result.reach.basin is None:  # its mesh is about this region
                reshaped = result.reach.reshaped
                draft.add_entry(system, "lyapunov", reshaped.hypotheses, reshaped.region.proofs)
            draft.left_out += _beyond_words(result, draft)
            return _checked(result.scene, subject, draft)
    except BeyondReachError as error:
        reasons.append(str(error))
    if result.scene.by_roots is not None and result.scene.rewriting.waves and result.scene.rewriting.denominators:
        raise NoCertificateError("a certificate does not state denominators with states beside roots and sines of them")
    raise NoCertificateError(f"{UNSHOWN}: {reasons[0]}")


def _known_of(region: ReshapedRegion | None) -> Mapping[str, Any] | None:
    """The evidence of a region that a mesh is about."""
    return None if region is None else region.region.proofs


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
    search, hypotheses = Search(known={} if system.numbers else candidate.known), candidate.hypotheses
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
    second = find_second(system, hypotheses["cells"], hypotheses["function"], search)
    if second is None:
        raise NotShownError("no functions were found that rise where V is kept")
    return second


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
        level = option.hypotheses["level"]
        for share in (Fraction(1), *([] if level is None else [NEARLY])):
            stated_level = None if level is None else str(Fraction(level) * share)
            try:
                self.add_entry(system, "lyapunov", {**option.hypotheses, "level": stated_level})
            except NotShownError as error:
                if share == 1:
                    self.left_out.append(f"{option.words}: {UNSHOWN}: {error}")
                continue
            return

    def add_global(self, system: System, entry: Record | None) -> None:
        """That every start reaches the point, by a V on the whole space, where that is shown.

        What is known is evidence of a system in rational numbers; of irrational ones it is searched again.
        """
        if entry is not None and system.numbers:
            with suppress(NotShownError):
                self.add_entry(system, entry["theorem"], entry["hypotheses"])
        elif entry is not None and not _attracts_everywhere(self):
            self.evidence.append(entry)
            self.statements += [{"attracts": "everywhere"}]

    def add_homogeneous(self, system: System, scene: SwitchedSystem, homogeneity: Homogeneity) -> None:
        """That every start reaches the point, or arrives, as the field is homogeneous, where that is shown."""
        with suppress(NotShownError, BeyondReachError):
            self.add_entry(system, "homogeneous", homogeneity.hypotheses(scene, self.evidence[0]))

    def add_arrival(self, system: System, arrival: Arrival, states: Sequence[str]) -> None:
        """After which time solutions are at the point, where that is shown."""
        if any(entry["hypotheses"] == arrival.entry["hypotheses"] for entry in self.evidence):
            return
        try:
            self.add_entry(system, "lyapunov", arrival.entry["hypotheses"], arrival.entry["proofs"])
        except NotShownError as error:
            self.left_out.append(f"{arrival_words(arrival, states)}: {UNSHOWN}: {error}")

    def add_entry(
        self, system: System, theorem: str, hypotheses: Record, known: Mapping[str, Any] | None = None
    ) -> None:
        """One more theorem, with the evidence that is known of its claims.

        Raises:
            NotShownError: where a hypothesis is not shown.
        """
        entry, statements = Search(known=known).entry(system, theorem, hypotheses)
        self.evidence.append(entry)
        self.statements += [statement for statement in statements if statement not in self.statements]


def _checked(system: SwitchedSystem, subject: Record, draft: Draft) -> Record:
    """A certificate that the checker accepts.

    Raises:
        NoCertificateError: beyond its limits of work.
        UnverifiedError: where it rejects what its own theorems showed while evidence was searched.
    """
    in_time = draft.evidence[0]["hypotheses"].get("roots") is not None
    noted = notes(system, in_time_of_states=in_time)
    noted |= {LEFT_OUT: draft.left_out} if draft.left_out else {}
    certificate = {
        "version": VERSION,
        "statement": {"subject": subject, "claims": draft.statements},
        "evidence": draft.evidence,
        "notes": noted,
    }
    return verified(certificate, certificate_text)


# ---- theorems that may show a verdict ----------------------------------------------------------


def _ways(result: DecidedSystem, system: System) -> Iterator[Callable[[], Draft]]:
    """Ways to show a verdict, in the order in which they are tried."""
    if result.deciding.theorem is Method.SIGNS:
        yield lambda: _shown(system, Candidate(*scalar_theorem(result, system)))
        return
    if result.deciding.theorem is Method.CHOICE and result.deciding.entry is None:
        raise NoCertificateError("a certificate does not state right-hand sides without sines beside enclosed ones")
    if isinstance(result.deciding.proofs, Parts):
        yield partial(by_parts, result.deciding.proofs, system)
    arrival = result.reach.arrival
    known = (result.reach.global_entry, None if arrival is None else arrival.entry)
    for candidate in (*_candidates(result), *map(_of_entry, filter(None, known))):
        yield partial(_shown, system, candidate)
    yield partial(_by_searches, result)


def by_parts(parts: Parts, system: System) -> Draft:
    """By the verdicts on parts, and by how fast those come to the point that carry others.

    Raises:
        NotShownError: where one of them has no certificate.
    """
    results = list(parts.results)
    for k in parts.carried:  # by a V that does not increase, also where more is known of orbits
        by_function = tuple(finding for finding in results[k].findings if finding.theorem is Method.LYAPUNOV)
        results[k] = replace(results[k], findings=by_function or results[k].findings)
    try:
        known = [certificate_of(part) for part in results]
    except NoCertificateError as error:
        raise NotShownError(f"a part has no certificate: {error}") from None
    entries = [
        next(
            (entry for entry in certificate["evidence"] if parts.carried and _has_rate(entry)),
            certificate["evidence"][0],
        )
        for certificate in known
    ]
    slide = parts.slide
    if slide is None:
        listed: list[Record] = [
            {"states": list(result.scene.stated_states), "entry": entry}
            for result, entry in zip(parts.results, entries, strict=True)
        ]
        if roots_of(system):
            for entry, certificate in zip(listed, known, strict=True):
                entry.update(_roots_in(certificate["statement"]["subject"]))
        if len(listed) > 1 and parts.results[-1].verdict is Translation.UNSTABLE:
            listed[-1]["leaves"] = True
        for k in parts.carried:
            listed[k]["carried"] = True
        for k in parts.jumping:
            listed[k]["jumps"] = True
        try:
            entry, statements = Search().entry(system, "cascade", {"parts": listed})
        except NotShownError:
            if not parts.jumping:
                raise
            for k in parts.jumping:
                listed[k]["jumps"] = CONTINUOUS
            entry, statements = Search().entry(system, "cascade", {"parts": listed})
    else:
        hypotheses = {"cells": slide.cells, "surface": slide.number, "state": slide.state, "entry": entries[0]}
        entry, statements = Search().entry(system, "sliding", hypotheses)
    return Draft([entry], statements, [])


def _roots_in(subject: Record) -> Record:
    """The roots of states that a subject names, none where it has none, and their orders."""
    return {"roots": [], **{key: subject[key] for key in ("roots", "orders") if key in subject}}


def _has_rate(entry: Record) -> bool:
    rate = entry["hypotheses"].get("rate")
    return rate is not None and rate["kind"] != DecayKind.ALGEBRAIC


def _by_searches(result: DecidedSystem) -> Draft:
    """By what shows the verdict near the point, or a function that is searched now."""
    entry, statements = show_verdict(result.scene, str(result.verdict))
    return Draft([entry], statements, [])


def _candidates(result: DecidedSystem) -> Iterator[Candidate]:
    """The theorem that decided, with the V that did."""
    entry, function = result.deciding.entry, result.function
    if entry is not None:
        yield _of_entry(entry)
    elif function is not None and function.grows:
        yield Candidate("instability", growth_hypotheses(result.scene, function))
    elif function is not None:
        yield _by_function(result, function)
        yield from _by_stated_function(result)


def _of_entry(entry: Record) -> Candidate:
    """A theorem with evidence that is known."""
    return Candidate(entry["theorem"], entry["hypotheses"], known=entry["proofs"])


def _by_function(result: DecidedSystem, function: ExaminedFunction) -> Candidate:
    """A V that falls, on its domain, with its region, its rate and its gain."""
    system, reach, verdict = result.scene, result.reach, str(result.verdict)
    stated, cells = stated_function(system, function.stated_on.radius, function)
    hypotheses, proofs = stability_hypotheses(cells.record, stated, verdict), function.known_proofs(reach)
    options = []
    forms = reach.everywhere and reach.global_entry is None and reach.homogeneous is None
    if forms and (not proofs or function.domain.radius is None):
        options.append(Option({"everywhere": True}, f"all starts in {_whole(system)} reach the equilibrium"))
    options += _options_on(function.stated_on, reach, system)
    weak = result.deciding.theorem is Method.INVARIANCE
    return Candidate("lyapunov", hypotheses, tuple(options), proofs, needs_second=weak)


def _options_on(domain: Domain, reach: Reach, system: SwitchedSystem) -> Iterator[Option]:
    """Region, rate and gain, of those that hold on a domain."""
    states = system.states
    if reach.near is not None and domain.radius is not None:
        yield Option({"level": exact_text(reach.near.level)}, reached_words(reach.near, states))
    if reach.rate is None or system.by_roots is not None:  # rates are in the time of the roots
        return
    rate = reach.rate.record
    if reach.rate.domain == domain:
        yield Option({"rate": rate}, rate_words(reach, states))
    gain = reach.gain
    if gain is not None and gain.domain == domain and gain.rate == reach.rate:
        # Where everything comes no region is stated, but the one that a disturbance does not leave.
        level = {} if gain.level is None or reach.near is not None else {"level": exact_text(gain.level)}
        yield Option({"rate": rate, "gain": exact_text(gain.gamma), **level}, gain_words(gain, states))


def _whole(system: SwitchedSystem) -> str:
    return "the plane" if system.is_planar else "the space"


def _by_stated_function(result: DecidedSystem) -> Iterator[Candidate]:
    """The scene's own V and LaSalle's principle, for a searched V that falls, of higher degree, and is not shown."""
    system, given = result.scene, result.given
    if not system.is_planar or given is None or result.function.formula == given.formula:
        return
    if given.decrease is Decrease.WEAK:
        function, cells = stated_function(system, given.stated_on.radius, given)
        yield Candidate(
            "lyapunov", stability_hypotheses(cells.record, function, str(result.verdict)), needs_second=True
        )


def _further(result: DecidedSystem) -> Iterator[Option]:
    """What holds elsewhere than where the theorem states V.

    Rate and gain that hold in the whole space, or on a cube alone; and a region that reaches beyond the square on which
    V falls everywhere, with the rate there, asked below a level.
    """
    system, reach, function = result.scene, result.reach, result.function
    region, far = reach.region, reach.region_rate
    if function is None and reach.rate is None:
        return
    for domain in dict.fromkeys(bound.domain for bound in (reach.rate, reach.gain) if bound is not None):
        if function is not None and domain == function.stated_on:
            continue
        hypotheses = _stated_on(result, domain)
        for option in _options_on(domain, reach, system):
            yield Option(hypotheses | option.hypotheses, option.words)
    if region is None or function is None or region == reach.near:
        return
    hypotheses = _stated_region(result, region)
    yield Option(hypotheses, reached_words(region, system.states))
    if far is not None:
        rate = {"kind": "exponential", "kappa": exact_text(far.kappa)}
        yield Option(
            {**hypotheses, "level": exact_text(far.level), "rate": rate}, region_rate_words(far, system.states)
        )


def _stated_region(result: DecidedSystem, region: SublevelRegion) -> Record:
    """The hypotheses of theorem ``lyapunov`` with the level of the region: below it, if V falls nowhere else."""
    radius = result.scene.field(region.radius) if isinstance(region.radius, Fraction) else region.radius
    hypotheses = _stated_on(result, Domain(radius))
    return {**hypotheses, "below": not region.falls, "level": exact_text(region.level)}


def _stated_on(result: DecidedSystem, domain: Domain) -> Record:
    """The hypotheses of theorem ``lyapunov`` with the V that decides, on a domain; in one state with the distance."""
    if result.function is None and result.reach.rate is not None:
        return distance_hypotheses(result.scene, replace(result.reach.rate, domain=domain))
    stated, cells = stated_function(result.scene, domain.radius, result.function)
    return stability_hypotheses(cells.record, stated, str(result.verdict))


def _shown_region(system: System, local: Record, search: Search) -> Record:
    """A region with evidence, or one below a level a little smaller: V may stand still on the border of a largest one.

    Raises:
        NotShownError: where neither is shown.
    """
    try:
        search.entry(system, "lyapunov", local)
    except NotShownError:
        local = {**local, "level": str(Fraction(local["level"]) * NEARLY)}
        search.entry(system, "lyapunov", local)
    return local


def find_region_of_simplices(result: DecidedSystem, asked: str, announce: Announce) -> CertifiedBasin | None:
    """A mesh around the certified level set of V, which the checker has accepted; None without one.

    Where formulas are known on the checked square or cube alone, because of denominators, so is the mesh.

    Args:
        result: of a system in two states, or in three; there the mesh is about the region by another V, where there is
            one.
        asked: how much may be done for it, of EFFORTS.
        announce: told what is done, how much of it, and of how much.
    """
    region = result.reach.region
    has_mesh = len(result.scene.states) in NAMES and result.scene.by_roots is None
    if not has_mesh or region is None or not result.has_local_region:
        return None
    try:
        result = replace(result, scene=in_rational_numbers(result.scene))
        system, scene = read_subject(about(result.scene)), result.scene
        surfaces = stated_cells(scene, scene.check.radius).record["surfaces"]
        radius, further = scene.check.half_width, result.reach.reshaped
        search = Search(known=_known_of(further))
        stated = _stated_region(result, region) if further is None else further.hypotheses
        local = _shown_region(system, stated, search)
        if scene.is_planar:
            limit = radius if scene.rewriting.denominators else None
            basin = find_basin(system, local, surfaces, EFFORTS[asked], limit, announce)
        elif scene.rewriting.denominators:
            basin = None
        else:
            basin = find_basin_in_space(system, local, surfaces, asked, REACH * radius, announce)
        if basin is not None:
            search.entry(system, "basin", basin.hypotheses)
    except (NoCertificateError, NotShownError, BeyondReachError, RejectedError):  # such as of sines of products
        return None
    return basin


def find_region_of_another_function(result: DecidedSystem, asked: str, announce: Announce) -> ReshapedRegion | None:
    """A larger region by a V that is reshaped, which the checker has accepted; None without one.

    Args:
        result: of a system in three states and more, with a V that falls and does not bend.
        asked: how much may be done for it, of EFFORTS.
        announce: told what is done, how much of it, and of how much.

    Raises:
        TooMuchWorkError: where the programs are too large for what is asked.
    """
    function = result.function
    if not result.has_local_region:
        return None
    scene = result.scene
    limit = Fraction(exact_text(scene.check.radius)) if scene.rewriting.denominators else None
    try:
        reshaped = find_reshaped_region(scene, function.formula, asked, announce, limit=limit)
        if reshaped is not None:
            subject, draft = about(scene), Draft([], [], [])
            draft.add_entry(read_subject(subject), "lyapunov", reshaped.hypotheses, reshaped.region.proofs)
            _checked(scene, subject, draft)
    except (NoCertificateError, NotShownError, BeyondReachError):
        return None
    return reshaped


# ---- what a certificate does not hold ----------------------------------------------------------


def _beyond_words(result: DecidedSystem, draft: Draft) -> Iterator[str]:
    """What a check says that the certificate has no words for, or no theorem."""
    reach, states = result.reach, result.scene.states
    kinds = {kind for statement in draft.statements for kind in statement}
    if reach.near is not None and "attracts" not in kinds and not any("level" in line for line in draft.left_out):
        yield f"{reached_words(reach.near, states)}: another theorem shows the verdict"
    if reach.rate is not None and "rate" not in kinds and not draft.left_out:
        yield f"{rate_words(reach, states)}: another theorem shows the verdict"
    if reach.everywhere and not _attracts_everywhere(draft):
        where = "the verdict is certified near the point" if result.scene.is_planar else "V is certified on a cube"
        yield f"all starts in {_whole(result.scene)} reach the equilibrium: {where}"
    if result.deciding.refutes:
        yield f"the equilibrium does not attract: {result.deciding.refutes}: certificates show stability alone"
    if reach.in_finite_time and "arrives" not in kinds:
        yield "solutions near the equilibrium arrive in finite time: certificates hold no times of roots"


def _attracts_everywhere(draft: Draft) -> bool:
    return {"attracts": "everywhere"} in draft.statements


def notes(system: SwitchedSystem, *, in_time_of_states: bool = False) -> Record:
    """The name of the scene, and the stated formulas where the right-hand sides are others; nothing that is proved."""
    record: Record = {"scene": system.name}
    if system.rewriting.written:
        record["stated"] = [[one_line(formula) for formula in member] for member in system.rewriting.written]
        rewritten = rewriting_words(system, in_time_of_states=in_time_of_states)
        record |= {"right-hand sides": rewritten} if rewritten else {}
    return record


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
        SceneError: for formulas that cannot be used with as many terms of sines as the certificate takes.
    """
    data, _ = read(file)
    subject = data["statement"]["subject"]
    order = subject.get("order", 0)  # of sines and cosines, which a check chooses where there are no roots
    if system.rewriting.waves and system.by_roots is None and order != system.rewriting.order:
        system = with_order(system, order)
    # Bounds of norms are stated themselves: nothing says of which order they are.
    orders = range(MOST_ORDER + 1) if Enclosed.NORMS in system.rewriting.encloses else (system.rewriting.order,)
    systems = (system if order == system.rewriting.order else with_order(system, order) for order in orders)
    known = [stated for asked in systems for stated in subjects_of(asked)]
    differences = [_difference(about(stated), subject) or _of_others_alone(data, stated) for stated in known]
    return differences[0] if all(differences) else ""


def _of_others_alone(certificate: Record, system: SwitchedSystem) -> str:
    """What an accepted certificate says of its right-hand sides, and so not of the stated ones; empty where nothing.

    Fractions are cleared by a positive factor, which changes speeds.  Where several right-hand sides enclose a stated
    one, what is true of all their solutions is true of those of the stated one, and one solution shows nothing.
    """
    statement = certificate["statement"]
    if system.rewriting.scale is not None and any({"rate", "gain"} & set(claim) for claim in statement["claims"]):
        return "rates of right-hand sides without fractions"
    encloses = len(statement["subject"]["rhs"]) > len(system.stated_lists)
    if encloses and {"stability": "unstable"} in statement["claims"] and _follows_one(certificate["evidence"]):
        return "one solution of right-hand sides that enclose the stated ones"
    return ""


def _follows_one(evidence: Any) -> bool:
    """Whether a theorem in some evidence, or in parts of it, shows one solution that leaves."""
    if isinstance(evidence, list):
        return any(map(_follows_one, evidence))
    return isinstance(evidence, dict) and (
        evidence.get("theorem") in ("choice", "escape") or any(map(_follows_one, evidence.values()))
    )


def _difference(stated: Record, subject: Record) -> str:
    return next((f"other {key}" for key in {**stated, **subject} if stated.get(key) != subject.get(key)), "")
