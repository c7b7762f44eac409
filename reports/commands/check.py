"""``nonsmooth check``: Theorem 4 clause by clause, or the stability of a plain switched system."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from nonsmooth.reports.console import UNDECIDED, RefusedError, refusals_named, write_json, write_views
from nonsmooth.reports.options import (
    AllowOutside,
    At,
    CertificateFile,
    Continuum,
    Json,
    NoPrune,
    Radius,
    RulesOption,
    SceneTexts,
    chosen_rules,
)

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from nonsmooth.analysis.continuum.prediction import Prediction
    from nonsmooth.proofs.theorem4_result import CellCheck, SmoothCheck
    from nonsmooth.symbolic.scene import Scene
    from nonsmooth.symbolic.switched_system import SwitchedSystem


def check(  # noqa: PLR0913, PLR0917  # one parameter for each option of the command
    scenes: SceneTexts,
    rule: RulesOption = None,
    radius: Radius = None,
    at: At = None,
    allow_outside: AllowOutside = False,
    no_prune: NoPrune = False,
    certificate: CertificateFile = None,
    continuum: Continuum = False,
    json: Json = False,
) -> int:
    """Check Theorem 4 clause by clause, or the stability of a plain switched system; of many scenes in one table.

    Exit status: 0 holds (or stable), 1 fails or hypotheses not met, 2 bad input, 3 undecided; of many the worst.
    """
    from nonsmooth.symbolic.files.system_file import load_any
    from nonsmooth.symbolic.switched_system import SwitchedSystem

    rules = chosen_rules(rule)
    path = None if certificate is None else _certificate_path(certificate, len(rules))
    loaded = [
        load_any(scene, rule=name, radius=radius, at=at, allow_outside=allow_outside)
        for scene in scenes
        for name in rules
    ]
    if len(scenes) > 1:
        _require_one_scene({"--certificate": certificate is not None, "--continuum": continuum}, len(scenes))
        return _check_many(loaded, prune=not no_prune, json=json)
    if isinstance(loaded[0], SwitchedSystem):
        _require_array(loaded[0], {"a certificate": certificate is not None, "--continuum": continuum})
        return _check_system(loaded[0], json=json)
    arrays = [scene for scene in loaded if not isinstance(scene, SwitchedSystem)]
    return _check_array(arrays, path, prune=not no_prune, continuum=continuum, json=json)


def _check_many(scenes: Sequence[Scene | SwitchedSystem], *, prune: bool, json: bool) -> int:
    """Many scenes: one line each, the worst exit status."""
    from nonsmooth.reports.summary import check_all, summary_view, worst_status

    lines = check_all(scenes, prune=prune)
    if json:
        from nonsmooth.reports.records import checks_record

        write_json(checks_record(line.record for line in lines))
    else:
        write_views([summary_view(lines)])
    return worst_status(lines)


def _check_array(scenes: list[Scene], path: Path | None, *, prune: bool, continuum: bool, json: bool) -> int:
    """One array, under one contact rule or all."""
    from nonsmooth.proofs.theorem4 import check_theorem4
    from nonsmooth.proofs.verified import verified

    found = _predictions(scenes[0]) if continuum else None
    results = []
    for scene in scenes:
        with refusals_named(scene):
            results.append(verified(check_theorem4(scene, prune=prune)))
    if path is not None:
        _write_certificate(results[0], path)
    if json:
        _write_records(results, found)
    else:
        _write_views(results, found)
    statuses = [result.verdict.exit_status for result in results]
    return next((status for status in (1, UNDECIDED) if status in statuses), 0)


def _write_records(results: list[CellCheck | SmoothCheck], found: tuple[Prediction, ...] | None) -> None:
    from nonsmooth.reports.records import check_record, checks_record

    if found is None:
        records = [check_record(result) for result in results]
    else:
        from nonsmooth.reports.continuum import continuum_record

        records = [check_record(result, continuum_record(found, result)) for result in results]
    write_json(checks_record(records) if len(records) > 1 else records[0])


def _write_views(results: list[CellCheck | SmoothCheck], found: tuple[Prediction, ...] | None) -> None:
    from nonsmooth.reports.terminal import check_view, legend, notes_lines

    views = [check_view(result) for result in results]
    if found is not None:
        from nonsmooth.reports.continuum import continuum_view

        views.append(continuum_view(found, results))
    write_views([*views, *notes_lines(results[0].scene.field), legend()])


def _predictions(scene: Scene) -> tuple[Prediction, ...]:
    """The continuous idealization, refused where no field stands for the array."""
    from nonsmooth.analysis.continuum.idealization import NoIdealizationError, predictions

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


def _check_system(scene: SwitchedSystem, *, json: bool) -> int:
    """Stability of a plain switched system: 0 stable, 1 unstable or no equilibrium, 3 undecided."""
    from nonsmooth.proofs.systems.system_stability import system_check
    from nonsmooth.proofs.verified import verified

    result = verified(system_check(scene))
    if json:
        from nonsmooth.reports.system_views import system_record

        write_json(system_record(result))
    else:
        from nonsmooth.reports.system_views import system_view

        write_views([system_view(result)])
    return result.exit_status


def _certificate_path(target: str, rules: int) -> Path:
    """Where the certificate of one check goes, refused before any work."""
    from nonsmooth.reports.files import output_path

    if rules > 1:
        raise RefusedError("--certificate: required one contact rule, received all")
    return output_path(target, (".json",))


def _write_certificate(result: CellCheck | SmoothCheck, path: Path) -> None:
    """The certificate of one check."""
    from nonsmooth.proofs.certificate import CertificateError, build_certificate, certificate_text
    from nonsmooth.reports.files import write_whole

    try:
        certificate = build_certificate(result)
    except CertificateError as error:
        raise RefusedError(f"{result.scene.origin}: {error}") from None
    write_whole(path, certificate_text(certificate).encode())
    if certificate["feedback"]["verdict"] != result.feedback.verdict:
        print(f"{path}: feedback stands as undecided: the checker follows no law by directions of c", file=sys.stderr)
