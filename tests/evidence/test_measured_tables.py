"""The study of measured tables in small: bodies confirm answers and refute forged ones; a stopped one goes on."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.evidence.measured_tables import RULES, Bodies, Lines, Question, answered, judged, questions, study
from tests.thorough import but, keep, thorough


@pytest.fixture(scope="module")
def bodies(tmp_path_factory: pytest.TempPathFactory) -> Bodies:
    """On one table, whose paths are followed once."""
    return Bodies(Question("measured", 1, "ellipse"), Lines(tmp_path_factory.mktemp("bodies") / "bodies.jsonl"))


@pytest.mark.parametrize("rule", but(["nearest", "roller"], RULES))
def test_bodies_confirm_what_is_said_of_a_table(rule: str, tmp_path: Path) -> None:
    question = Question("measured", 1, rule)
    answer = answered(question)
    assert answer["verdict"] == ("stays near" if rule == "box" else "comes near")
    assert not judged(answer, Bodies(question, Lines(tmp_path / "bodies.jsonl")))


@pytest.mark.parametrize(
    "forged",
    keep(
        1,
        [
            {"verdict": "comes near", "ends_within": 2.2, "within": 26.0, "after": 0.1},  # they do not so soon
            {"verdict": "comes near", "ends_within": 1.7, "within": 26.0, "after": 4.0},  # and end 1.96 mm off
            {"verdict": "comes near", "ends_within": 2.2, "within": 26.0, "swings_out_to": 25.9, "after": 4.0},
            {"verdict": "leaves"},
            {"verdict": "comes home", "accuracy": 1.5},
        ],
    ),
)
def test_bodies_refute_what_is_not_so(forged: dict[str, object], bodies: Bodies) -> None:
    assert judged({"accuracy": 3.65, **forged}, bodies) == "wrong"


@thorough  # the tests above have bodies confirm and refute for less
def test_a_table_that_brings_bodies_near_is_no_open_question(bodies: Bodies) -> None:
    assert judged({"verdict": "undecided", "accuracy": 3.65}, bodies) == "open"
    assert not judged({"verdict": "undecided", "accuracy": 1.5}, bodies)


def test_a_study_goes_on_where_it_was_stopped(tmp_path: Path) -> None:
    asked = [Question("measured", 5, "box")]
    assert study(iter(asked), tmp_path) == 0
    answers = tmp_path / "answers.jsonl"
    first = json.loads(answers.read_text(encoding="utf-8"))
    forged = json.dumps({**first, "verdict": "stays near", "stays_within": 1e-3})
    answers.write_text(forged + '\n{"key": "measured 5 el', encoding="utf-8")  # a line that was cut off
    assert study(iter(asked), tmp_path) == 0
    assert len(answers.read_text(encoding="utf-8").splitlines()) == 2


def test_every_table_is_asked_about_under_the_rules_that_it_has() -> None:
    asked = list(questions(range(2), ["measured", "symmetric"], in_turn=False))
    assert [question.kind for question in asked].count("measured") == 8
    assert {question.rule for question in asked if question.kind == "symmetric"} == {"ellipse", "roller"}


@thorough  # test_bodies_confirm_what_is_said_of_a_table is the small one
def test_forty_tables_under_every_rule(tmp_path: Path) -> None:
    assert study(questions(range(40), ["measured"], in_turn=False), tmp_path) == 0
