"""``nonsmooth check``: Theorem 4 clause by clause, or the stability of a plain switched system."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nonsmooth.reports.choices import RuleOrAll
from nonsmooth.reports.console import UNDECIDED, RefusedError, refusals_named, write_json, write_views
from nonsmooth.reports.options import At, CertificateFile, Continuum, Json, NoPrune, Radius, RulesOption, SceneText

if TYPE_CHECKING:
    from nonsmooth.analysis.continuum.prediction import Prediction
    from nonsmooth.proofs.theorem4_result import CellCheck, EllipseCheck
    from nonsmooth.symbolic.scene import Scene
    from nonsmooth.symbolic.system import SystemScene


def check(
    scene: SceneText,
    rule: RulesOption = None,
    radius: Radius = None,
    at: At = None,
    no_prune: NoPrune = False,
    certificate: CertificateFile = None,
    continuum: Continuum = False,
    json: Json = False,
) -> int:
    """Check Theorem 4 clause by clause, or the stability of a plain switched system."""
    from nonsmooth.proofs.theorem4 import check_theorem4
    from nonsmooth.proofs.verified import verified
    from nonsmooth.symbolic.files.system_file import load_any
    from nonsmooth.symbolic.scene import Scene

    several = rule is RuleOrAll.ALL
    scenes = []
    for name in [None] if rule is None else rule.rules:
        loaded = load_any(scene, rule=name, radius=radius, at=at)
        if not isinstance(loaded, Scene):
            _require_array(loaded, {"a certificate": certificate is not None, "--continuum": continuum})
            return _check_system(loaded, json=json)
        scenes.append(loaded)
    found = _predictions(scenes[0]) if continuum else None
    results = []
    for loaded in scenes:
        with refusals_named(loaded):
            results.append(verified(check_theorem4(loaded, prune=not no_prune)))
    if certificate is not None:
        _write_certificate(results, certificate)
    if json:
        _write_records(results, found, several=several)
    else:
        _write_views(results, found)
    statuses = [result.verdict.exit_status for result in results]
    return next((status for status in (1, UNDECIDED) if status in statuses), 0)


def _write_records(
    results: list[CellCheck | EllipseCheck], found: tuple[Prediction, ...] | None, *, several: bool
) -> None:
    from nonsmooth.reports.records import check_record, checks_record

    if found is None:
        records = [check_record(result) for result in results]
    else:
        from nonsmooth.reports.continuum import continuum_record

        records = [check_record(result, continuum_record(found, result)) for result in results]
    write_json(checks_record(records) if several else records[0])


def _write_views(results: list[CellCheck | EllipseCheck], found: tuple[Prediction, ...] | None) -> None:
    from nonsmooth.reports.terminal import check_view, legend

    views = [check_view(result) for result in results]
    if found is not None:
        from nonsmooth.reports.continuum import continuum_view

        views.append(continuum_view(found, results))
    write_views([*views, legend()])


def _predictions(scene: Scene) -> tuple[Prediction, ...]:
    """The continuous idealization, refused where no field stands for the array."""
    from nonsmooth.analysis.continuum.idealization import NoIdealizationError, predictions

    try:
        return predictions(scene)
    except NoIdealizationError as error:
        raise RefusedError(f"{scene.origin}: {error}") from None


def _require_array(scene: SystemScene, asked: dict[str, bool]) -> None:
    """Refuse what only an array of wheels has."""
    wanted = next((name for name, given in asked.items() if given), None)
    if wanted is not None:
        raise RefusedError(f"{scene.origin}: required an array of wheels for {wanted}")


def _check_system(scene: SystemScene, *, json: bool) -> int:
    """Stability of a plain switched system: 0 stable, 1 unstable or no equilibrium, 3 undecided."""
    from nonsmooth.proofs.systems.system_stability import system_check
    from nonsmooth.proofs.verdicts import Translation
    from nonsmooth.proofs.verified import verified

    result = verified(system_check(scene))
    if json:
        from nonsmooth.reports.system_views import system_record

        write_json(system_record(result))
    else:
        from nonsmooth.reports.system_views import system_view

        write_views([system_view(result)])
    return {Translation.UNSTABLE: 1, Translation.UNDECIDED: UNDECIDED}.get(result.verdict, 0)


def _write_certificate(results: list[CellCheck | EllipseCheck], target: str) -> None:
    """One certificate for one check."""
    from nonsmooth.proofs.certificate import CertificateError, build_certificate, certificate_text
    from nonsmooth.reports.files import output_path, write_whole

    if len(results) > 1:
        raise RefusedError("--certificate: required one contact rule, received all")
    path = output_path(target, (".json",))
    try:
        text = certificate_text(build_certificate(results[0]))
    except CertificateError as error:
        raise RefusedError(f"{results[0].scene.origin}: {error}") from None
    write_whole(path, text.encode())
