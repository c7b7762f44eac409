"""What ``nonsmooth check`` writes about one array: JSON, or views of a terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nonsmooth.reports.console import write_json, write_views

if TYPE_CHECKING:
    from rich.console import RenderableType

    from nonsmooth.analysis.continuum import Prediction
    from nonsmooth.proofs.answers.failures import Failure
    from nonsmooth.proofs.clauses.workspace import Announce
    from nonsmooth.reports.interface.check_result import CheckResult


def failed_wheels(result: CheckResult, announce: Announce) -> tuple[Failure, ...]:
    """The answers with any one wheel failed."""
    from nonsmooth.proofs.answers.failures import failures_of

    announce("any one wheel failed")
    return failures_of(result.evidence.scene)


def write_records(
    results: list[CheckResult], found: tuple[Prediction, ...] | None, failures: list[tuple[Failure, ...]] | None
) -> None:
    """One record, or one for each contact rule."""
    from nonsmooth.reports.records import check_record, checks_record

    records = []
    for k, result in enumerate(results):
        continuum = None
        if found is not None:
            from nonsmooth.reports.continuum import continuum_record

            continuum = continuum_record(found, result.evidence)
        failed = None if failures is None else failures[k]
        records.append(check_record(result.evidence, result.answers, continuum, failed))
    write_json(checks_record(records) if len(records) > 1 else records[0])


def write_check_views(
    results: list[CheckResult],
    found: tuple[Prediction, ...] | None,
    failures: list[tuple[Failure, ...]] | None,
    *,
    evidence: bool,
) -> None:
    """The answers and the verdicts of the clauses; why, the failures and the continuum, where they were asked for."""
    from rich.text import Text

    from nonsmooth.reports.answers import answers_view
    from nonsmooth.reports.terminal import MORE, check_view, clauses_view, headline, legend, notes_lines

    views: list[RenderableType] = []
    for k, result in enumerate(results):
        check = result.evidence
        answers = [headline(check), answers_view(check, result.answers)]
        views += [_stacked(*answers), check_view(check)] if evidence else [_stacked(*answers, clauses_view(check))]
        if failures is not None:
            from nonsmooth.reports.failures import failures_view

            views.append(failures_view(failures[k]))
    if found is not None:
        from nonsmooth.reports.continuum import continuum_view

        views.append(continuum_view(found, [result.evidence for result in results]))
    views += notes_lines(results[0].evidence.scene.field)
    write_views([*views, legend() if evidence else Text(MORE, "dim")])


def _stacked(*views: RenderableType) -> RenderableType:
    from rich.console import Group

    return Group(*views)
