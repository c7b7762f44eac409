"""A new theorem is a function of the checker, a strategy and a line for each; a new kind of evidence likewise."""

from __future__ import annotations

from dataclasses import replace
from importlib import import_module
from inspect import signature
from typing import Any

import pytest

from nonsmooth.proofs import theorem_searches
from nonsmooth.proofs.checker.positivity import KINDS as SHOWN_KINDS
from nonsmooth.proofs.checker.statements import THEOREMS, refusal
from nonsmooth.proofs.kernel.search import KINDS, NotShownError
from nonsmooth.proofs.system_certificates import certificate_of, certificate_text
from nonsmooth.proofs.system_decision import STRATEGIES, decide_system
from nonsmooth.proofs.systems.findings import Method
from nonsmooth.reports.checks.check import check_system
from tests.plain import built
from tests.rehearsals.still import CONSTANTS, NO_MOTION, STILL, show_by_constants, show_still


@pytest.fixture(autouse=True)
def _registered(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(THEOREMS, "still", show_still)
    monkeypatch.setattr(theorem_searches, "THEOREM_SEARCHES", (STILL, *theorem_searches.THEOREM_SEARCHES))
    monkeypatch.setitem(SHOWN_KINDS, "constant", show_by_constants)
    monkeypatch.setattr("nonsmooth.proofs.kernel.search.KINDS", [CONSTANTS, *KINDS])


def test_a_theorem_and_its_evidence_stand_in_certificates() -> None:
    entry, shown = theorem_searches.show_verdict(built(["0", "0", "0*sign(x)"]), "stable")
    assert (entry["theorem"], shown) == ("still", [{"stability": "stable"}])
    assert set(map(str, entry["proofs"].values())) == {str({"constant": True})}
    subject = {"states": ["x", "y", "z"], "rhs": [["0", "0", "0*sign(x)"]], "at": ["0", "0", "0"]}
    certificate: dict[str, Any] = {
        "version": "nonsmooth-certificate/2",
        "statement": {"subject": subject, "claims": shown},
        "evidence": [entry],
    }
    assert not refusal(certificate, 10_000)
    subject["rhs"] = [["0", "0", "x**2"]]
    assert refusal(certificate, 10_000) == "numbers that are large enough"


def test_other_strategies_follow() -> None:
    with pytest.raises(NotShownError):
        theorem_searches.show_verdict(built(["0", "0", "y"]), "stable")
    result = decide_system(built(["-sign(x)", "-sign(y)"], lyapunov="Abs(x) + Abs(y)"))
    certificate = certificate_of(result)
    assert not refusal(certificate, len(certificate_text(certificate)))
    assert {"constant": True} in certificate["evidence"][0]["proofs"].values()


def test_a_strategy_decides(monkeypatch: pytest.MonkeyPatch) -> None:
    """A function and a line; what it finds is said, verified and certified as any other verdict."""
    monkeypatch.setattr("nonsmooth.proofs.system_decision.STRATEGIES", [NO_MOTION, *STRATEGIES])
    result = check_system(built(["0", "0", "0*sign(x)"])).evidence
    assert (str(result.verdict), result.method) == ("stable", "no motion")
    assert certificate_of(result)["evidence"][0]["theorem"] == "still"
    assert decide_system(built(["-x", "-y", "-z"])).method == Method.LYAPUNOV
    claimed = replace(result, scene=built(["x", "y", "z"]))
    assert not claimed.check()


def test_every_strategy_of_the_registry_is_a_function_of_a_point() -> None:
    """Modules are named, so that they are imported when they are asked: nothing else would tell a wrong name."""
    for strategy in STRATEGIES:
        function = getattr(import_module(strategy.module), strategy.function)
        assert list(signature(function).parameters) == ["point"], strategy
        assert function.__module__ == strategy.module
