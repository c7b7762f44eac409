"""``nonsmooth check``: Theorem 4 clause by clause, or the stability of a plain switched system."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from nonsmooth.reports.check_files import CheckFiles
from nonsmooth.reports.check_output import failed_wheels, write_check_views, write_records
from nonsmooth.reports.console import UNDECIDED, write_json, write_views
from nonsmooth.reports.options import (
    ALL_RULES,
    AUTO,
    AllowOutside,
    AtOrAuto,
    CertificateFile,
    Continuum,
    Evidence,
    Fail,
    Headings,
    Json,
    LawFile,
    NoPrune,
    Radius,
    Require,
    RulesOption,
    SceneTexts,
    asks_for_failures,
    required_answers,
    under_all_rules,
)
from nonsmooth.reports.refusals import RefusedError, refusals_named
from nonsmooth.symbolic.rule import CONTACT_RULES

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from nonsmooth.analysis.continuum import Prediction
    from nonsmooth.proofs.clauses.workspace import Announce
    from nonsmooth.symbolic.contact_set import TipsError
    from nonsmooth.symbolic.scene import Scene
    from nonsmooth.symbolic.switched_system import SwitchedSystem


class FurtherQuestions(NamedTuple):
    """What is asked beside the answers and clauses."""

    continuum: bool
    failures: bool
    evidence: bool


def check(  # noqa: PLR0913, PLR0917  # one parameter for each option of the command
    scenes: SceneTexts,
    rule: RulesOption = None,
    radius: Radius = None,
    at: AtOrAuto = None,
    allow_outside: AllowOutside = False,
    no_prune: NoPrune = False,
    certificate: CertificateFile = None,
    law: LawFile = None,
    require: Require = None,
    continuum: Continuum = False,
    headings: Headings = False,
    fail: Fail = None,
    evidence: Evidence = False,
    json: Json = False,
) -> int:
    """Check Theorem 4 clause by clause, or the stability of a plain switched system; of many scenes in one table.

    Exit status: 0 holds (or stable), 1 fails, hypotheses not met, or tips, 2 bad input, 3 undecided; of many the worst.
    """
    from nonsmooth.symbolic.contact_set import TipsError
    from nonsmooth.symbolic.files.system_file import load_any
    from nonsmooth.symbolic.scene import Scene
    from nonsmooth.symbolic.switched_system import SwitchedSystem

    required, failures = required_answers(require), asks_for_failures(fail)
    best, compares = at == AUTO, rule == ALL_RULES
    files = CheckFiles.asked(certificate, law, len(CONTACT_RULES) if compares else 1)
    named, fixed_at = None if compares else rule, None if best else at
    loaded: list[Scene | SwitchedSystem] = []
    for text in scenes:
        scene = load_any(text, rule=named, radius=radius, at=fixed_at, allow_outside=allow_outside)
        if compares:
            _require_arrays([scene], f"--rule {ALL_RULES}")
        loaded += under_all_rules(scene) if compares and isinstance(scene, Scene) else [scene]
    if best:
        _require_arrays(loaded, "--at auto")
    if len(scenes) > 1:
        loaded = [_at_best_point(scene) if best else scene for scene in loaded]
        asked = {"--certificate": files.certificate is not None, "--law": files.law is not None, "--evidence": evidence}
        _require_one_scene({**asked, "--continuum": continuum, "--headings": headings, "--fail": failures}, len(scenes))
        return _check_many(loaded, required, prune=not no_prune, json=json)
    if isinstance(loaded[0], SwitchedSystem):
        of_arrays = {"--law": law is not None, "--continuum": continuum, "--headings": headings, "--fail": failures}
        _require_array(loaded[0], of_arrays)
        return _check_system(loaded[0], files.certificate, evidence=evidence, json=json)
    arrays = [scene for scene in loaded if not isinstance(scene, SwitchedSystem)]
    options = {"best": best, "prune": not no_prune, "around": headings}
    try:
        beside = FurtherQuestions(continuum, failures, evidence)
        return _check_array(arrays, files, options, required=required, beside=beside, json=json)
    except TipsError as tipping:
        return _answer_tipping(arrays[0], tipping, required, json=json)


def _answer_tipping(scene: Scene, tipping: TipsError, required: Sequence[str], *, json: bool) -> int:
    """A body that does not stand at the checked pose: that is the answer, under every contact rule."""
    from nonsmooth.reports.interface.tipped_result import TippedResult

    result = TippedResult(scene, tipping)
    if json:
        write_json(result.to_dict())
    else:
        from nonsmooth.reports.answers import tipped_view

        write_views([tipped_view(result.scene, [result.position, result.heading, result.pose])])
    return result.exit_status(required)


def _at_best_point(scene: Scene | SwitchedSystem) -> Scene | SwitchedSystem:
    """The array at the best rest point of its square."""
    from nonsmooth.proofs.answers.best_point import at_best_point
    from nonsmooth.symbolic.switched_system import SwitchedSystem

    if isinstance(scene, SwitchedSystem):
        return scene
    with refusals_named(scene):
        return at_best_point(scene)


def _require_arrays(scenes: Sequence[Scene | SwitchedSystem], option: str) -> None:
    """Refuse plain systems for an option of arrays."""
    from nonsmooth.symbolic.switched_system import SwitchedSystem

    for scene in scenes:
        if isinstance(scene, SwitchedSystem):
            raise RefusedError(f"{scene.origin}: required an array of wheels for {option}, received a plain system")


def _check_many(scenes: Sequence[Scene | SwitchedSystem], required: Sequence[str], *, prune: bool, json: bool) -> int:
    """Many scenes: one line each, the worst exit status."""
    from nonsmooth.reports.summary import check_all, summary_view, worst_status

    lines = check_all(scenes, required, prune=prune, records=json)
    if json:
        from nonsmooth.reports.records import checks_record

        write_json(checks_record(line.record for line in lines))
    else:
        write_views([summary_view(lines)])
    return worst_status(lines)


def _check_array(  # one keyword for each option
    scenes: list[Scene],
    files: CheckFiles,
    options: dict[str, Any],
    *,
    required: Sequence[str],
    beside: FurtherQuestions,
    json: bool,
) -> int:
    """One array, under one contact rule or all."""
    from nonsmooth.reports.interface.check_result import check_scene, compared
    from nonsmooth.reports.progress import steps

    found = _predictions(scenes[0]) if beside.continuum else None
    results, alone = [], len(scenes) == 1
    with steps("check") as announce:
        for scene in scenes:
            with refusals_named(scene):
                heard = announce if alone else _with_rule(scene, announce)
                results.append(check_scene(scene, **options, ask_others=alone, announce=heard))
        announce("where bodies go, headings of rest, and the other rules")
        results = compared(results)
        failures = [failed_wheels(result, announce) for result in results] if beside.failures else None
    results[0] = files.write(results[0])
    if json:
        write_records(results, found, failures)
    else:
        write_check_views(results, found, failures, evidence=beside.evidence)
    statuses = [result.exit_status(required) for result in results]
    return next((status for status in (1, UNDECIDED) if status in statuses), 0)


def _with_rule(scene: Scene, announce: Announce) -> Announce:
    """Steps of one rule among several."""
    return lambda step: announce(f"rule {scene.contact.rule}: {step}")


def _predictions(scene: Scene) -> tuple[Prediction, ...]:
    """The continuous idealization, refused where no field stands for the array."""
    from nonsmooth.analysis.continuum import NoIdealizationError, predictions

    try:
        return predictions(scene)
    except NoIdealizationError as error:
        raise RefusedError(f"{scene.origin}: {error}") from None


def _require_one_scene(asked: dict[str, bool], count: int) -> None:
    """Refuse what is made for one scene."""
    for option in (name for name, given in asked.items() if given):
        raise RefusedError(f"{option}: required one scene, received {count}")


def _require_array(scene: SwitchedSystem, asked: dict[str, bool]) -> None:
    """Refuse what only an array of wheels has."""
    wanted = next((name for name, given in asked.items() if given), None)
    if wanted is not None:
        raise RefusedError(
            f"{scene.origin}: required an array of wheels for {wanted}, received a plain switched system"
        )


def _check_system(scene: SwitchedSystem, certificate: Path | None, *, evidence: bool, json: bool) -> int:
    """Stability of a plain switched system: 0 stable, 1 unstable or no equilibrium, 3 undecided."""
    from nonsmooth.proofs.system_decision import decide_system
    from nonsmooth.proofs.verified import verified
    from nonsmooth.reports.progress import steps

    with steps("stability") as announce:
        result = decide_system(scene)
        announce("verification of the evidence")
        verified(result)
    if certificate is not None:
        from nonsmooth.reports.check_files import write_system_certificate

        write_system_certificate(result, certificate)
    if json:
        from nonsmooth.reports.system_views import system_record

        write_json(system_record(result))
    else:
        from nonsmooth.reports.system_views import system_view

        write_views([system_view(result, evidence=evidence)])
    return result.exit_status
