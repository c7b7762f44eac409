"""The study of published functions: what it reads, and that fractions and the audit must agree."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

from tests.evidence.published_functions import bounded, contradiction, examined, published, refuted, text

# x0' = -12 x0, x1' = x0 x1 - x1; V = x0^2 + x1^2 - and the same with a V that rises where x0 x1 < 0
GOOD = "1|INT+ 2 <SPECIAL_3> * INT- 1 2 x0 <SPECIAL_3> + * x0 x1 * INT- 1 x1\t+ ^ x0 INT+ 2 ^ x1 INT+ 2"
BAD = (
    "2|INT+ 2 <SPECIAL_3> * INT- 1 2 x0 <SPECIAL_3> * INT- 1 x1\t+ ^ x0 INT+ 2 + * INT+ 5 * x0 x1 * INT+ 9 ^ x1 INT+ 2"
)


def test_lines_are_read_and_judged_twice(tmp_path: Path) -> None:
    file = tmp_path / "own"
    file.write_text(f"{GOOD}\n{BAD}\n")
    good, bad = published(file)
    assert good.field[0] == {(1, 0): Fraction(-12)}
    assert text(good.function, ["a", "b"]) == "(1)*a**2 + (1)*b**2"
    found = examined(good)
    assert (found["verdict"], found["rises_along"], contradiction(good, found)) == ("valid", None, "")
    found = examined(bad)
    assert found["verdict"] == "invalid"
    assert found["rises_along"] is not None
    assert contradiction(bad, found) == ""


def test_answers_that_fractions_contradict_are_named(tmp_path: Path) -> None:
    file = tmp_path / "own"
    file.write_text(f"{GOOD}\n{BAD}\n")
    good, bad = published(file)
    assert (
        contradiction(bad, {"verdict": "valid", "witness": None, **refuted(bad)}) == "valid, but V rises near the point"
    )
    claimed = {"verdict": "invalid", "witness": ["1/8", "1/8"], **refuted(good)}
    assert contradiction(good, claimed) == "invalid, but V is positive and does not rise at its witness"


def test_what_takes_too_long_is_stopped_and_says_so(tmp_path: Path) -> None:
    file = tmp_path / "own"
    file.write_text(f"{GOOD}\n{BAD}\n")
    good, bad = published(file)
    assert bounded(good, 20) == examined(good)
    stopped = bounded(bad, 0)
    assert stopped["verdict"] == "undecided"
    assert "stopped after 0 s" in str(stopped["reason"])
    assert stopped["rises_along"] is not None
