"""A part of the golden matrix, and whether its comparison would find what it is for: planted changes, each of them."""

from __future__ import annotations

import copy
import json
import re
import shutil
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from tests.golden.compare import differences
from tests.golden.contents import page, plain, text_lines
from tests.golden.expectations import Change, accept, accounted, changes, digest, expectations, fold
from tests.golden.matrix import HERE, Record, Row, rows, run_row

TESTED = [row for row in rows() if row.tested]
LONGEST_LINE = 500  # characters of a refusal; the longest lists ten keys


@cache
def expected() -> dict[str, Record]:
    return {row.line: record for row, record in expectations().items()}


def refused(before: Any, after: Any) -> list[str]:
    """The differences that are not allowed."""
    return [str(difference) for difference in differences(before, after) if not difference.allowed]


# ---- the matrix ----------------------------------------------------------------------------------


@pytest.mark.parametrize("row", TESTED, ids=lambda row: row.line)
def test_a_row_says_what_it_said(row: Row) -> None:
    assert refused(expected()[row.line], run_row(row.line)) == []


def test_every_row_is_there_once_and_has_a_record() -> None:
    lines = [row.line for row in rows()]
    assert len(set(lines)) == len(lines)
    assert set(lines) == set(expected())


def test_no_record_was_changed_without_a_reason() -> None:
    """Its digest is the frozen one, or stands in changes.toml."""
    known = {line: mark for line, mark in accounted().items() if mark != "removed"}
    assert known == {line: digest(record) for line, record in expected().items()}


def test_the_matrix_is_as_large_as_it_should_be() -> None:
    count = {name: sum(row.section == name for row in rows()) for name in {row.section for row in rows()}}
    assert count["check-scenes"] == 19 * 4
    assert count["families"] == 95
    assert count["refusals"] >= 150
    assert count["python"] >= 75
    assert len(rows()) - count["python"] >= 450


UNWRITTEN = re.compile(
    r": certificate: required|: --law: required (a certified feedback law|a roll row|rule nearest for)"
)


@pytest.mark.parametrize("section", ["refusals", "refused-options"])
def test_a_refusal_is_one_line_with_status_2_and_nothing_else(section: str) -> None:
    """No output, no file; the line is short, printable, and says what was required and what was received."""
    for row in (row for row in rows() if row.section == section):
        record = expected()[row.line]
        *before, step = record["steps"]
        (line,) = step["err"]
        answered = ["out"] if UNWRITTEN.search(line) else []  # the file alone is refused, after the work
        assert [step["status"], list(step)] == [2, ["status", *answered, "err"]], row.line
        assert line.startswith("nonsmooth: "), row.line
        assert line.isprintable(), row.line
        assert len(line) <= LONGEST_LINE, row.line
        assert "files" not in record or before, row.line
        if "check refused-" in row.line:
            assert ": required " in line, row.line
            assert ", received " in line, row.line


def test_what_python_refuses_is_one_line() -> None:
    for row in (row for row in rows() if row.section == "refused-in-python"):
        line = expected()[row.line]["raised"]
        assert line.isprintable(), row.line
        assert re.fullmatch(r"(Scene|Value|Type|Design|Sweep|Output)Error: .*required .*", line), row.line
        assert len(line) <= LONGEST_LINE, row.line


# ---- planted changes -----------------------------------------------------------------------------

CHECK = "check four-wheel --json"
WORDS = "check four-wheel"
CHAIN = "check relay-chain --json"
VERIFIED = "check four-wheel --certificate c.json && verify c.json && verify c.json four-wheel"
CELLS = "partition four-wheel --json"
PICTURE = "partition ring-5 -o cells.svg"
REFUSED = "check four-wheel --radius 0"
PATH = "simulate four-wheel --from 0.2,0.4,0.3 --feedback --gain 2 --json"
TABLE = "simulate four-wheel --from 0.2,0.4,0 -o path.csv"
BOX = "check tolerances.toml --json"
ERROR = "ns.load('nope')"
STUDY = "precision four-wheel --study minimizers-ellipse --runs 1 --time-limit 1 --json"


def at(record: Any, path: str) -> tuple[Any, Any]:
    """The container and the key at the end of a path."""
    *way, last = (int(key) if key.isdigit() else key for key in path.split("/"))
    for key in way:
        record = record[key]
    return record, last


def put(path: str, value: Any) -> Callable[[Record], None]:
    """Another value at a path; a function makes it from the old one."""

    def change(record: Record) -> None:
        container, key = at(record, path)
        container[key] = value(container[key]) if callable(value) else value

    return change


def drop(path: str) -> Callable[[Record], None]:
    def change(record: Record) -> None:
        container, key = at(record, path)
        del container[key]

    return change


OUT = "steps/0/out"
PLANTED: dict[str, tuple[str, Callable[[Record], None]]] = {
    "a digit of an exact value": (CHECK, put(f"{OUT}/translation/exact/worst_rate", "-3")),
    "a verdict": (CHECK, put(f"{OUT}/translation/verdict", "stable")),
    "a verdict that is undecided": (CHECK, put(f"{OUT}/theorem4/verdict", "undecided")),
    "an exit status": (CHECK, put("steps/0/status", 1)),
    "a float in its ninth digit": (CHECK, put(f"{OUT}/rotation/drift/0", lambda x: x * (1 + 4e-9))),
    "a key that is missing": (CHECK, drop(f"{OUT}/answers/heading")),
    "a key that is new": (CHECK, put(f"{OUT}/answers/further", {})),
    "a null": (CHECK, put(f"{OUT}/translation/witness", "none")),
    "a smaller region of an array": (CHECK, put(f"{OUT}/translation/region/radius", 0.25)),
    "a slower law": (CHECK, put(f"{OUT}/feedback/rate", 0.19)),
    "a word": (WORDS, put(f"{OUT}/0", lambda text: text.replace("wheels", "wheel"))),
    "a digit in words": (WORDS, put(f"{OUT}/0", lambda text: text.replace("4", "5"))),
    "a line": (WORDS, drop(f"{OUT}/1")),
    "a smaller level of the same V": (CHAIN, put(f"{OUT}/lyapunov/region/level", 0.25)),
    "a smaller rate": (CHAIN, put(f"{OUT}/lyapunov/rate/kappa", 0.5)),
    "no rate": (CHAIN, put(f"{OUT}/lyapunov/rate", None)),
    "another V with a smaller region": (CHAIN, put(f"{OUT}/lyapunov/V", "2*Abs(x) + 2*Abs(y) + 2*Abs(z)")),
    "a certificate that is not accepted": (VERIFIED, put("steps/1/status", 1)),
    "a claim that is not shown": (VERIFIED, drop("steps/1/out/2")),
    "a cell": (CELLS, drop(f"{OUT}/cells/0")),
    "a corner of a cell": (CELLS, put(f"{OUT}/cells/0/polygon/1/0", lambda x: x + 1e-8)),
    "a picture without a text": (PICTURE, drop("files/cells.svg/texts/ends/0")),
    "a picture that is moved": (PICTURE, put("files/cells.svg/coordinates/mean", lambda x: x + 1e-3)),
    "a file": (PICTURE, drop("files/cells.svg")),
    "a refusal in other words": (REFUSED, put("steps/0/err/0", lambda text: text.replace("required", "needs"))),
    "a point of a path": (PATH, put(f"{OUT}/state/mean", lambda x: x + 1e-6)),
    "a row of a table": (TABLE, drop("files/path.csv/0")),
    "a larger radius of a box": (BOX, put(f"{OUT}/robust/radius", lambda x: 2 * x)),
    "a less accurate method": (STUDY, put(f"{OUT}/rows/0/error", lambda x: 100 * x + 1e-6)),
    "another error": (ERROR, put("raised", lambda text: text.replace("SceneError", "ValueError"))),
}


@pytest.fixture
def coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    """Sizes of regions by few samples."""
    monkeypatch.setattr("tests.golden.compare.SAMPLES", 13)


@pytest.mark.usefixtures("coarse")
@pytest.mark.parametrize("name", PLANTED)
def test_a_planted_change_is_found(name: str) -> None:
    line, change = PLANTED[name]
    record = copy.deepcopy(expected()[line])
    assert refused(expected()[line], record) == []
    change(record)
    assert refused(expected()[line], record) != []


STRONGER: dict[str, tuple[str, Callable[[Record], None]]] = {
    "a larger region": (CHECK, put(f"{OUT}/translation/region/radius", 0.75)),
    "a faster law": (CHECK, put(f"{OUT}/feedback/rate", 0.5)),
    "another V with the same region": (CHAIN, put(f"{OUT}/lyapunov/V", "Abs(z) + Abs(x) + Abs(y)")),
    "a smaller radius of a box": (BOX, put(f"{OUT}/robust/radius", lambda x: x / 2)),
    "another run time": (CHECK, put(f"{OUT}/seconds", {"partition": 1})),
}


@pytest.mark.usefixtures("coarse")
@pytest.mark.parametrize("name", STRONGER)
def test_what_is_stronger_is_allowed(name: str) -> None:
    line, change = STRONGER[name]
    record = copy.deepcopy(expected()[line])
    change(record)
    assert record != expected()[line]
    assert refused(expected()[line], record) == []


def test_undecided_may_become_decided_and_not_the_other_way_round() -> None:
    open_record = {"translation": {"verdict": "undecided", "reason": "a tie", "region": None}, "radius": 1}
    decided = {"translation": {"verdict": "stable", "reason": "V", "region": {"radius": 1}}, "radius": 1}
    assert refused(open_record, decided) == []
    assert refused(decided, open_record) != []
    assert refused(open_record, {**decided, "radius": 2}) != []


# ---- records and reasons -------------------------------------------------------------------------


def test_a_faster_machine_may_end_in_time_and_a_slower_product_not() -> None:
    late = {"outcome": "time-out", "error": None, "note": "not done within 1 s"}
    done = {"outcome": "done", "error": 1e-3, "note": ""}
    assert not refused({"rows": [late]}, {"rows": [done]})
    assert refused({"rows": [done]}, {"rows": [late]})


def test_an_accepted_change_carries_its_reason_and_differences(tmp_path: Path) -> None:
    row = next(row for row in rows() if row.line == CHECK)
    accept([Change(row, {"value": 1}, [])], [], "frozen", tmp_path)
    assert accounted(tmp_path) == {CHECK: digest({"value": 1})}
    accept([Change(row, {"value": 2}, ['.value: 1 -> 2 "\x7f"'])], [], 'because "it" grew', tmp_path)
    assert accounted(tmp_path) == {CHECK: digest({"value": 2})}
    assert expectations(tmp_path) == {row: {"value": 2}}
    log = tmp_path / "changes.toml"
    assert 'reason = "because \\"it\\" grew"' in log.read_text(encoding="utf-8")
    assert "1 -> 2" in log.read_text(encoding="utf-8")
    fold(tmp_path)
    assert "1 -> 2" not in log.read_text(encoding="utf-8")
    assert changes(tmp_path) == [
        {"reason": 'because "it" grew', "rows": [{"row": CHECK, "digest": digest({"value": 2})}]}
    ]
    accept([Change(row, {"value": 3}, [".value: 2 -> 3"])], [], "again", tmp_path)
    assert [change["reason"] for change in changes(tmp_path)] == ['because "it" grew', "again"]
    assert accounted(tmp_path) == {CHECK: digest({"value": 3})}


def test_a_record_that_was_changed_in_silence_is_found(tmp_path: Path) -> None:
    """Folded changes say for each row what the whole audit trail says."""
    for name in ("frozen.txt", "changes.toml"):
        shutil.copy(HERE / name, tmp_path)
    before = accounted(tmp_path)
    fold(tmp_path)
    assert accounted(tmp_path) == before
    for line, record in expected().items():
        silent = copy.deepcopy(record)
        silent["steps" if "steps" in silent else "value"] = "something else"
        assert digest(silent) != before[line]


def test_long_lists_become_their_ends_and_sums() -> None:
    numbers = [[k, "exact"] for k in range(100)]
    short = plain(numbers)
    assert (short["length"], short["ends"][0], short["ends"][-1], short["mean"]) == (
        100,
        [0, "exact"],
        [99, "exact"],
        49.5,
    )
    other = copy.deepcopy(numbers)
    other[50][1] = "exacter"
    assert refused(short, plain(other)) != []
    assert refused(short, plain([*numbers[:50], [50.001, "exact"], *numbers[51:]])) != []


def test_text_is_unwrapped_and_pictures_become_their_texts() -> None:
    assert text_lines("╭──┬──╮\n│ a  │ b │\n╰──┴──╯\n x  y \n") == ["a | b", "x y"]
    found = page('<svg><path d="M 1 2 L 3 -4"/><!-- title --><text x="5">word</text></svg>')
    assert found["texts"] == ["title", "word"]
    assert (found["tags"], found["coordinates"]["numbers"]) == ({"path": 1, "svg": 1, "text": 1}, 5)


def test_records_are_plain_json() -> None:
    for record in expected().values():
        assert json.loads(json.dumps(record, allow_nan=False)) == record
