"""The study ``check``: Theorem 4 clause by clause, or the stability of a plain switched system; of many scenes too."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Any, TypeAlias

from nonsmooth.reports.output.files import output_path, write_whole
from nonsmooth.reports.output.progress import notice, progress, steps
from nonsmooth.reports.output.refusals import RefusedError, UnwrittenError, bad_input, refusals_named
from nonsmooth.reports.output.study_options import FAIL, LawName, Options, RegionSearch, SceneTexts, option
from nonsmooth.reports.studies.study import SceneStudy, StudyRequest
from nonsmooth.symbolic.mechanics.rule import CONTACT_RULES, MIXED
from nonsmooth.symbolic.messages.scene_error import SceneError, one_line, shown
from nonsmooth.symbolic.messages.scene_kind import SceneKind

if TYPE_CHECKING:
    from nonsmooth.analysis.bodies.continuum import Prediction
    from nonsmooth.analysis.cells.partition import Partition
    from nonsmooth.proofs.clauses.workspace import Announce
    from nonsmooth.reports.checks.check_results import CheckResult, SummaryLine
    from nonsmooth.reports.checks.system_results import SystemCheckResult
    from nonsmooth.reports.studies.result import Result
    from nonsmooth.symbolic.mechanics.scene import Scene
    from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

    AnyScene: TypeAlias = Scene | SwitchedSystem

ALL_RULES = "all"
AUTO = "auto"  # for --at: the best rest point of the square
THEOREM = "theorem4"
# The questions, and the theorem; tests hold them to the registry.
REQUIRABLE = ("position", "heading", "pose", "inertia", "tolerances", THEOREM)
CERTIFICATES, LAWS = (".json",), (".py", ".c", ".st", ".csv")  # what these files may end in
ONE_FAILS = (None, 1, "1", "any")  # of --fail
OF_SYSTEMS = ("stability", "attraction", "everywhere", "approach")  # the same of a plain system
OF_ONE_ARRAY = ("law", "law_name", "continuum", "headings", "fail")
OF_ONE_SCENE = ("certificate", "evidence", "region", *OF_ONE_ARRAY)


@dataclass(frozen=True, kw_only=True)
class CheckOptions(Options):
    """What is asked of a check."""

    rule: str | None = option(
        None, "Contact rule; replaces the scene's.", names=lambda: (*CONTACT_RULES, MIXED, ALL_RULES)
    )
    at: Any = option(
        None,
        "The point to check, such as 0,1/4; replaces the scene's. auto: the best rest point of the square.",
        str | None,
        metavar="X,Y|auto",
    )
    accuracy: Any = option(
        None, "How near a body must come, such as 1/100; replaces the scene's.", str | None, metavar="LENGTH"
    )
    prune: bool = option(True, "Leave nothing out; the verdicts are the same.", flag="--no-prune")
    certificate: str | None = option(
        None, "Write a certificate for verify: .json (one scene; of an array, rule nearest or box).", metavar="FILE"
    )
    law: str | None = option(
        None,
        "Write the certified feedback law as a program, .py, .c or .st (Structured Text of IEC 61131-3), or as a .csv "
        "table of regions and speeds (one scene).",
        metavar="FILE",
    )
    law_name: LawName = option(
        LawName.CERTIFIED,
        "With --law: another law (rule nearest), certified or not, which the file then says.",
    )
    require: str | None = option(
        None,
        f"What exit status 0 means, of {', '.join(REQUIRABLE)}: comes home or near, keeps, can be held, stable and "
        f"settles (simulated), certified, holds. Of a plain system, of {', '.join(OF_SYSTEMS)}: solutions stay near, "
        "come from near or from everywhere, approach equilibria.",
        metavar="NAME,...",
    )
    continuum: bool = option(False, "Add what a continuous field would do to an object.")
    headings: bool = option(False, "Look for headings at which a body rests around the checked point too.")
    fail: Any = option(None, FAIL, str | None, metavar="1|any")
    region: RegionSearch = option(
        RegionSearch.AUTO,
        "Certify a larger region, too: by triangles, of a plain system in two states or an array under nearest or box, "
        "by another V in more states, in three by tetrahedra, too; fast takes seconds, best a minute; auto: fast of a "
        "plain system.",
    )
    evidence: bool = option(False, "Print why, too: each clause, or V and its derivatives, with all numbers.")

    def required_of(self, scene: AnyScene) -> tuple[str, ...]:
        """The answers that exit status 0 asks for; the theorem alone unless told, of a plain system its stability.

        Raises:
            RefusedError: for a name that is none.
        """
        is_system = scene.kind is SceneKind.SYSTEM
        known = OF_SYSTEMS if is_system else REQUIRABLE
        if self.require is None:
            return (OF_SYSTEMS[0] if is_system else THEOREM,)
        names = tuple(name.strip() for name in str(self.require).split(","))
        unknown = next((name for name in names if name not in known), None)
        if unknown is not None:
            where = f"{scene.origin}: " if is_system else ""
            raise RefusedError(f"{where}--require: required names among {', '.join(known)}, received {unknown[:60]!r}")
        return names


class CheckStudy(SceneStudy[CheckOptions]):
    """A check of one scene or of many."""

    argument = SceneTexts
    options = CheckOptions
    changes = (*SceneStudy.changes, "accuracy")

    def load(self, scene: Sequence[str], options: CheckOptions, **changes: Any) -> list[AnyScene]:
        """The scenes that are named."""
        for name, chosen in (("rule", ALL_RULES), ("at", AUTO)):
            changes[name] = None if changes[name] == chosen else changes[name]
        return [super(CheckStudy, self).load(text, options, **changes) for text in scene]

    def refuse(self, asked: StudyRequest[CheckOptions], path: Path | None) -> None:
        """Refuse what cannot be asked of these scenes."""
        options, scenes = asked.options, _listed(asked.scene)
        if options.fail not in ONE_FAILS:
            raise RefusedError(f"--fail: required 1 or any, one wheel at a time, received {shown(options.fail)}")
        for flag, file, endings in (("--certificate", options.certificate, CERTIFICATES), ("--law", options.law, LAWS)):
            if file is not None:
                if options.rule == ALL_RULES:
                    raise RefusedError(f"{flag}: required one contact rule, received all")
                output_path(str(file), endings)
        if not options.law:
            asked.refuse(("law_name",), "--law", "none")
        for scene in scenes:
            required = options.required_of(scene)
            if scene.kind is SceneKind.ARRAY and "inertia" in required and options.rule != ALL_RULES:
                from nonsmooth.proofs.answers.answer import require_dynamics

                require_dynamics(scene, "--require inertia")
            if scene.kind is SceneKind.ARRAY and "tolerances" in required:
                from nonsmooth.proofs.answers.answer import require_tolerances

                require_tolerances(scene)
            if scene.kind is SceneKind.SYSTEM:
                _require_array(scene, f"--rule {ALL_RULES}" * (options.rule == ALL_RULES), "a plain system")
                finder = f"a plain system, of which nonsmooth equilibria {quote(scene.origin)} finds the places of rest"
                _require_array(scene, "--at auto" * (options.at == AUTO), finder)
                _require_array(scene, "--no-prune" * ("prune" in asked.given), "a plain switched system")
        if len(scenes) > 1:
            asked.refuse(OF_ONE_SCENE, "one scene", str(len(scenes)))
        elif scenes[0].kind is SceneKind.SYSTEM:
            wanted = next((name for name in OF_ONE_ARRAY if name in asked.given), "")
            _require_array(scenes[0], f"--{wanted}" if wanted else "", "a plain switched system")
        if "region" in asked.given and asked.options.region is not RegionSearch.NONE:
            _require_several_states(scenes[0])

    def run(self, scene: AnyScene | Sequence[AnyScene], options: CheckOptions) -> Result:
        """Check; write the files that were asked for."""
        scenes = [ruled for one in _listed(scene) for ruled in _under_rules(one, options)]
        if len(_listed(scene)) > 1:
            return _check_many(scenes, options)
        if scenes[0].kind is SceneKind.SYSTEM:
            return _check_system(scenes[0], options)
        return _check_array(scenes, options)


CHECK = CheckStudy()


def _listed(scene: Any) -> Sequence[AnyScene]:
    return scene if isinstance(scene, list) else [scene]


def _require_array(scene: AnyScene, option: str, received: str) -> None:
    """Refuse an option of arrays, if there is one, for another scene."""
    if option:
        raise RefusedError(f"{scene.origin}: required an array of wheels for {option}, received {received}")


def _require_several_states(scene: AnyScene) -> None:
    """Refuse a search for the region of a plain system in one state, whose region is known exactly."""
    if scene.kind is SceneKind.SYSTEM and len(scene.states) == 1:
        required = "required a plain system in two states or more, or an array, for --region"
        raise RefusedError(f"{scene.origin}: {required}, received one state")


def _under_rules(scene: Any, options: CheckOptions) -> list[Any]:
    """The scene, or its wheels under every contact rule, and itself too where its wheels have different ones."""
    if options.rule != ALL_RULES:
        return [scene]
    from nonsmooth.symbolic.mechanics.springs import under_rule

    ruled = [under_rule(scene, name) for name in CONTACT_RULES]
    return [*ruled, scene] if scene.contact.rule == MIXED else ruled


# ---- one array -----------------------------------------------------------------------------------


def check_array(  # one keyword for each choice
    scene: Scene,
    *,
    prune: bool = True,
    best: bool = False,
    ask_others: bool = True,
    around: bool = False,
    beside: bool = True,
    announce: Announce | None = None,
    built: Partition | None = None,
) -> CheckResult:
    """Check an array.

    Args:
        scene: the array.
        prune: leave out what no verdict needs.
        best: check at the best rest point of the square instead of the scene's point.
        ask_others: let the answers say what the other contact rules say.
        around: look for headings of rest around the checked point too.
        beside: also search for other equilibria, count contact states and sample rates, on which no verdict rests.
        announce: told the name of each step as it begins.
        built: all cells of the square, where they are known already.

    Raises:
        RefusalError: where the motion is not determined.
        TipsError: where the body does not stand at the checked pose.
        SceneError: where a wheel lies exactly under its edge.
    """
    from nonsmooth.proofs.clauses.workspace import unheard
    from nonsmooth.proofs.theorem4 import check_theorem4
    from nonsmooth.reports.checks.check_results import CheckResult

    announce, rest_points = announce or unheard, None
    if best:
        from nonsmooth.proofs.answers.destinations import best_point  # paths: only a search loads them
        from nonsmooth.symbolic.mechanics.contact_set import standing

        announce("the best rest point of the square")
        chosen = best_point(standing(scene))
        scene, rest_points = chosen.scene, chosen.found
    found = check_theorem4(scene, prune=prune, beside=beside, announce=announce, built=built)
    return CheckResult(found, ask_others, around, rest_points)


def _check_array(scenes: Sequence[Scene], options: CheckOptions) -> Result:
    """One array, under one contact rule or all; a body that tips is an answer, under every rule."""
    from nonsmooth.reports.checks.check_results import TippedResult, compared
    from nonsmooth.symbolic.mechanics.contact_set import TipsError

    if options.headings and scenes[0].body is None:
        why = "without an outline of the body ([body] shape) all wheels carry it at every heading, and it moves alike"
        notice(scenes[0].origin, f"--headings: none to look for: {why}")
    continuum = _predictions(scenes[0]) if options.continuum else None
    try:
        with steps("check") as announce:
            results = [_under_one_rule(scene, options, len(scenes) == 1, continuum, announce) for scene in scenes]
            if len(results) > 1:
                return compared(results)
    except TipsError as tipping:
        tipped = TippedResult(scenes[0], tipping)
        asked = [f"--{name}" for name in ("continuum", "fail") if getattr(options, name)]
        if asked:
            notice(scenes[0].origin, f"{' and '.join(asked)}: nothing is said of a body that tips")
        if options.certificate or options.law:
            raise UnwrittenError(
                f"{scenes[0].origin}: required a body that stands, received one that tips", tipped
            ) from tipping
        return tipped
    return _with_files(results[0], options)


def _under_one_rule(
    scene: Scene, options: CheckOptions, alone: bool, continuum: tuple[Prediction, ...] | None, announce: Announce
) -> CheckResult:
    """The check of an array under one rule, alone or among several."""
    with refusals_named(scene):
        result = check_array(
            scene,
            prune=options.prune,
            best=options.at == AUTO,
            ask_others=alone,
            around=options.headings,
            announce=announce if alone else lambda step: announce(f"rule {scene.contact.rule}: {step}"),
        )
    failures = None
    if options.fail:
        from nonsmooth.proofs.answers.failures import failures_of

        announce("any one wheel failed")
        failures = failures_of(result.scene)
    result = replace(result, required=options.required_of(scene), shows_evidence=options.evidence)
    if options.region not in (RegionSearch.AUTO, RegionSearch.NONE):
        result = result.with_triangles(str(options.region))
    return replace(result, continuum=continuum, failures=failures)


def _predictions(scene: Scene) -> tuple[Prediction, ...]:
    """The continuous idealization, refused where no field stands for the array."""
    from nonsmooth.analysis.bodies.continuum import NoIdealizationError, predictions

    with bad_input(scene, NoIdealizationError):
        return predictions(scene)


def _with_files(result: CheckResult, options: CheckOptions) -> CheckResult:
    """The result, compared with its certificate; the files that were asked for, unless it contradicts itself."""
    if not (options.certificate or options.law):
        return result
    _ = result.answers  # all of them: they may contradict what would be written
    certificate = None
    if options.certificate:
        from nonsmooth.proofs.kernel.subject import NoCertificateError

        try:
            result, certificate = result.certified()
        except NoCertificateError as error:
            raise UnwrittenError(f"{result.scene.origin}: {error}", result) from error
    if result.contradictions:
        for path in filter(None, (options.certificate, options.law)):
            notice(path, "not written: what the check says contradicts itself")
        return result
    if options.law:
        from nonsmooth.reports.laws.law_table import NoLawError

        try:
            law = result.law(options.law_name)
        except NoLawError as error:
            raise UnwrittenError(f"{result.scene.origin}: --law: {error}", result) from None
        law.save(options.law)
        notice(options.law, f"the {options.law_name} law of {len(result.scene.wheels)} wheels")
    if options.certificate and certificate:
        _write_certificate(certificate, result, options.certificate)
    return result


def _write_certificate(certificate: dict[str, Any], result: CheckResult, file: str) -> None:
    from nonsmooth.proofs.certificate import certificate_text, stated_words
    from nonsmooth.proofs.checker.theorem4 import CLAUSES

    check, stated, notes = result.evidence, stated_words(certificate), []
    said = {**{name: clause.verdict for name, clause in check.results.items()}, "theorem 4": check.verdict}
    for name in CLAUSES:
        if stated.get(name, "undecided") != said[name]:
            why = "follows no law by directions of c" if name == "feedback" else "leaves it open"
            notes.append(f"{name} stands as undecided: the checker {why}")
    _write_accepted(file, certificate_text(certificate), notes)


def _write_accepted(file: str, text: str, notes: Iterable[str]) -> None:
    """Write a certificate that the stand-alone checker has accepted, say so, and what it leaves out."""
    write_whole(Path(file), text.encode())
    notice(file, "the certificate, accepted by the stand-alone checker")
    for note in notes:
        notice(file, note)


# ---- plain systems, and many scenes --------------------------------------------------------------


def check_system(system: SwitchedSystem) -> SystemCheckResult:
    """Check a plain system."""
    from nonsmooth.proofs.system_decision import decide_system
    from nonsmooth.reports.checks.system_results import SystemCheckResult

    with steps("stability"):
        return SystemCheckResult(decide_system(system))


def _check_system(system: Any, options: CheckOptions) -> SystemCheckResult:
    """The stability of a plain system, with a region unless told; its certificate where asked for."""
    required = options.required_of(system)
    result = replace(check_system(system), shows_evidence=options.evidence, required=required)
    is_asked, search = options.region is not RegionSearch.AUTO, options.region
    if not is_asked:
        search = RegionSearch.FAST if len(system.states) > 1 else RegionSearch.NONE
    if search is not RegionSearch.NONE:
        result = result.with_region(str(search))
        if is_asked and result.evidence.reach.basin is None and result.evidence.reach.reshaped is None:
            what = "triangles are" if len(system.states) == 2 else "larger region is"
            notice(system.origin, f"--region {search}: no {what} certified beyond the rest")
    if options.certificate:
        from nonsmooth.proofs.kernel.subject import NoCertificateError
        from nonsmooth.proofs.system_certificates import certificate_text, left_out

        try:
            certificate = result.certificate()
        except NoCertificateError as error:
            raise UnwrittenError(f"{system.origin}: {error}", result) from error
        notes = (f"left out: {line}" for line in left_out(certificate))
        _write_accepted(options.certificate, certificate_text(certificate), notes)
    return result


def _check_many(scenes: Sequence[Any], options: CheckOptions) -> Result:
    """One line for each scene."""
    from nonsmooth.reports.checks.check_results import SummaryResult

    if options.at == AUTO:
        from nonsmooth.proofs.answers.destinations import best_point

        chosen = []
        for scene in scenes:
            with refusals_named(scene):
                chosen.append(best_point(scene).scene)
        scenes = chosen

    def checked(*, records: bool) -> tuple[SummaryLine, ...]:
        lines = []
        with progress("checked") as report:
            for done, scene in enumerate(scenes):
                report(done, len(scenes))
                lines.append(_summary_line(scene, options, records=records))
        return tuple(lines)

    return SummaryResult(checked)


def _summary_line(scene: Any, options: CheckOptions, *, records: bool) -> SummaryLine:
    """One scene among many; one that is refused stops no other."""
    from nonsmooth.analysis.cells.partition import RefusalError
    from nonsmooth.proofs.answers.answers import exit_status
    from nonsmooth.reports.checks.answers import CHECK_SCHEMA
    from nonsmooth.reports.checks.check_results import NONE, REFUSED, SummaryLine, TippedResult
    from nonsmooth.symbolic.mechanics.contact_set import TipsError

    if scene.kind is SceneKind.SYSTEM:
        found = replace(check_system(scene), required=options.required_of(scene))
        return SummaryLine(scene.origin, NONE, (found.verdict,), NONE, found.exit_status, found.facts())
    rule = str(scene.contact.rule)
    try:
        result = check_array(scene, prune=options.prune)
        record = result.facts() if records else {}
        answers = tuple(str(answer.verdict) for answer in (result.position, result.heading, result.pose))
        status = exit_status(result.evidence, options.required_of(scene))
        return SummaryLine(scene.origin, rule, answers, result.theorem4, status, record)
    except TipsError as tipping:
        tipped = TippedResult(scene, tipping)
        answers = (str(tipped.position.verdict), NONE, NONE)
        return SummaryLine(scene.origin, rule, answers, tipped.theorem4, tipped.exit_status, tipped.facts())
    except (RefusalError, SceneError) as error:
        refusal = one_line(str(error))
        record = {"schema": CHECK_SCHEMA, "scene": scene.name, "rule": rule, "refused": refusal}
        return SummaryLine(scene.origin, rule, (REFUSED,), NONE, 2, record, refusal)
