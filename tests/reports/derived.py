"""Derivation reports of built-in scenes that several files of tests read: each is derived once in a process."""

from __future__ import annotations

from functools import cache

from nonsmooth.reports.checks.subject import Invocation
from nonsmooth.reports.derivations.derivation import ReportResult, derive_report, render_report
from nonsmooth.reports.derivations.parts import names_of
from nonsmooth.reports.papers.murphey_burdick_2001.audit import audit_paper
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.messages.scene_kind import SceneKind

PART_NAMES = names_of(SceneKind.ARRAY)  # of the parts of an array's report


@cache
def derived(name: str, rule: str | None = None) -> ReportResult:
    """The report that ``nonsmooth derive`` writes."""
    options = () if rule is None else ("--rule", rule)
    return derive_report(load_scene(name, rule=rule), Invocation(name, options))


def derived_afresh(name: str, rule: str | None = None) -> ReportResult:
    """The same, nothing of it computed before."""
    audit_paper.cache_clear()
    return derived.__wrapped__(name, rule)


@cache
def page(name: str, rule: str | None = None) -> str:
    """The page of a report, drawn once."""
    return render_report(derived(name) if rule is None else derived(name, rule), ".html")
