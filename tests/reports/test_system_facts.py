"""Facts of plain systems and audits: one list gives the rows of the terminal and the keys of JSON."""

from __future__ import annotations

from nonsmooth.proofs.findings.verdicts import Fact, Quantity, row_fact, text_fact, unsaid
from nonsmooth.reports.output.facts import fact_record, fact_rows


def test_a_nested_record_says_its_own_rows_in_their_place() -> None:
    inner = (text_fact("verdict", "stable", "stability"), Fact("gain", Quantity(0.5), "{}", ("1/2",), row="gain"))
    facts = [row_fact("first", "{} of {}", "1", "2"), Fact("outer", inner), Fact("last", "data only")]
    assert fact_rows(facts) == [("first", "1 of 2"), ("stability", "stable"), ("gain", "1/2")]
    assert fact_record(facts) == {
        "outer": {"verdict": "stable", "gain": 0.5, "exact": {}},
        "last": "data only",
    }


def test_facts_as_data_only_keep_their_record() -> None:
    facts = (text_fact("verdict", "stable", "stability"), Fact("gain", Quantity(0.5), "{}", ("1/2",), row="gain"))
    assert fact_rows(unsaid(facts)) == []
    assert fact_record(unsaid(facts)) == fact_record(facts)
