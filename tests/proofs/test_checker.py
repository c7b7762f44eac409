"""The stand-alone checker: what it accepts is true, and what is forged, damaged or malformed it rejects.

Mutants are another chapter (tests/proofs/test_forged_certificates.py), and what one condition alone refuses is in the
corpus (tests/certificates/array_conditions.py).  Here is what else is forged by hand, and a test of the oracle of
mutants.
"""

from __future__ import annotations

import ast
import copy
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any, TypeAlias

import pytest

from nonsmooth.proofs.certificate import build_certificate, certificate_text
from nonsmooth.proofs.checker import tower, work
from nonsmooth.proofs.checker.contact import Cells
from nonsmooth.proofs.checker.files import check_file
from nonsmooth.proofs.checker.positivity import Proofs
from nonsmooth.proofs.checker.statements import refusal
from nonsmooth.proofs.checker.theorem4 import Clauses
from nonsmooth.proofs.checker.wheels import read_array
from nonsmooth.proofs.checker.work import MAX_BYTES
from nonsmooth.proofs.theorem4 import check_cells
from nonsmooth.symbolic.mechanics.scene import Contact, LoadTable
from tests.array_certificates import check_certificate, claim_disc, claim_rate, evidence, proofs, said, say, subject
from tests.built_in import checked
from tests.conftest import Arrays, WheelData
from tests.four_wheel import SIDE
from tests.oracles.nearest_paths import Wheel as OracleWheel
from tests.oracles.rebuilt_arrays import assert_still_true
from tests.oracles.tied_arrays import LEAVES_FROM_1E_9, LEAVES_LIKE_A_ROOT, scene_of
from tests.thorough import few

Record: TypeAlias = dict[str, Any]

CHECKER = Path(work.__file__).parent
SUBJECTS = (
    ("four-wheel", "nearest"),
    ("four-wheel-side", "nearest"),
    ("saddle", "nearest"),
    ("off-center", "nearest"),
    ("ring-5", "nearest"),
    ("four-wheel", "box"),
    ("spiral-30", "box"),
)
ALLOWED_SECONDS = 1.0  # for a certificate of the four-wheel array, interpreter included (about 0.1 s)


@cache
def certificate_of(name: str, rule: str) -> Record:
    """Once in a process; to be copied by what changes it."""
    return build_certificate(checked(name, rule))


@pytest.fixture(scope="session")
def certificates() -> dict[tuple[str, str], Record]:
    return {subject: certificate_of(*subject) for subject in SUBJECTS}


@pytest.fixture
def four_wheel() -> Record:
    return copy.deepcopy(certificate_of("four-wheel", "nearest"))


@pytest.fixture
def four_wheel_box() -> Record:
    return copy.deepcopy(certificate_of("four-wheel", "box"))


# ---- stand-alone -------------------------------------------------------------------------


def test_the_checker_is_one_folder_that_needs_the_standard_library_only() -> None:
    modules = set[str]()
    for file in CHECKER.glob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                modules |= {alias.name.split(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.level != 1:  # not one of the folder's own modules
                assert node.module is not None
                modules.add(node.module.split(".")[0])
    assert modules <= set(sys.stdlib_module_names)


def run_alone(path: Path) -> subprocess.CompletedProcess[str]:
    """The folder copied elsewhere would do as well: ``-I -S`` finds neither the workbench nor any other package."""
    command = [sys.executable, "-I", "-S", str(CHECKER), str(path)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_a_valid_certificate_within_a_second_with_nothing_installed(four_wheel: Record, tmp_path: Path) -> None:
    path = tmp_path / "four-wheel.json"
    path.write_text(certificate_text(four_wheel), encoding="utf-8")
    seconds = []
    for _ in range(2):
        start = sum(os.times()[2:4])  # processor time of finished child processes
        result = run_alone(path)
        seconds.append(sum(os.times()[2:4]) - start)
        assert (result.returncode, result.stderr) == (0, "")
        assert result.stdout.startswith("valid")
    print(f"four-wheel: {path.stat().st_size} bytes, {min(seconds):.3f} s with the interpreter")
    assert min(seconds) < ALLOWED_SECONDS


def test_a_forged_certificate_is_rejected_in_one_line(four_wheel: Record, tmp_path: Path) -> None:
    evidence(four_wheel)["cells"][2]["twists"][0][0] = "1"
    path = tmp_path / "forged.json"
    path.write_text(certificate_text(four_wheel), encoding="utf-8")
    result = run_alone(path)
    assert (result.returncode, result.stderr) == (1, "")
    assert result.stdout == "rejected: required cell 2: a twist for each choice of rows, which it obeys\n"


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"{",
        b"\xff\xfe\xfa",
        b'{"schema": 1, "schema": 2}',
        b"[" * 1_000_000,
        b'{"a":' * 200_000,
        b"9" * 1_000_000,
    ],
    ids=["empty", "cut off", "no text", "a key twice", "nested lists", "nested objects", "a huge integer"],
)
def test_what_is_no_json_document_is_unreadable(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "file.json"
    path.write_bytes(content)
    start = time.process_time()
    status, line = check_file(str(path))
    assert time.process_time() - start < 10 * ALLOWED_SECONDS
    assert status == 2
    assert line.startswith("unreadable: ")
    assert "\n" not in line
    assert len(line) < 300


def test_absent_files_folders_and_large_files_are_unreadable(tmp_path: Path) -> None:
    large = tmp_path / "large.json"
    with large.open("wb") as file:
        file.truncate(MAX_BYTES + 1)
    for path in (tmp_path / "absent.json", tmp_path, large):
        assert check_file(str(path))[0] == 2
    assert run_alone(tmp_path / "absent.json").returncode == 2


def test_no_file_or_two_files_is_a_usage_error() -> None:
    for arguments in ([], ["a", "b"]):
        result = subprocess.run(
            [sys.executable, "-I", "-S", str(CHECKER), *arguments], capture_output=True, text=True, check=False
        )
        assert (result.returncode, result.stdout) == (2, "usage: python -I -S checker FILE\n")


@pytest.mark.parametrize("data", [None, [], {}, "valid", 1, True, {"schema": "nonsmooth-certificate/2"}], ids=repr)
def test_json_that_is_no_certificate_is_rejected(data: object, tmp_path: Path) -> None:
    path = tmp_path / "file.json"
    path.write_text(json.dumps(data), encoding="utf-8")
    keys = "version statement evidence notes"
    assert check_file(str(path)) == (1, f"rejected: required an object with the keys {keys}")


def test_version_1_is_refused_with_the_line_that_writes_it_anew(tmp_path: Path) -> None:
    path = tmp_path / "file.json"
    path.write_text(json.dumps({"schema": "nonsmooth-certificate/1"}), encoding="utf-8")
    status, line = check_file(str(path))
    assert status == 2
    assert line == (
        f"of an earlier version: nonsmooth check ARRAY --certificate {path} writes it anew, as nonsmooth-certificate/2"
    )


# ---- numbers -----------------------------------------------------------------------------


NOT_A_NUMBER = "rational numbers as texts such as '-3/4'"
NOT_A_LIST = "a list of some items"
NOT_A_GENERATOR = "a whole number from 0 to 0"
MALFORMED_NUMBERS: list[tuple[object, str]] = [
    *((value, NOT_A_LIST) for value in (1, 1.0, True, None, {"1": 1}, ["1"])),
    *((text, NOT_A_NUMBER) for text in ("1.0", "1e0", "NaN", "Infinity", " 1", "1\n", "+1", "1_0", "\u0661", "")),
    *((value, NOT_A_NUMBER) for value in ([[1]], [[True]])),
    ("9" * 4001, "numbers of at most 4000 digits"),
    *((value, NOT_A_GENERATOR) for value in ([["1", 7]], [["1", -1]], [["1", "0"]], [["1", True]])),
    ([["1", 0, 0]], "powers below the degree"),
    ("1/0", "well-formed data, not a ZeroDivisionError"),
    ([[]], "a product, not an empty list"),
    ([], "a number, not an empty list"),
]


@pytest.mark.parametrize(("forged", "claim"), MALFORMED_NUMBERS, ids=[repr(value) for value, _ in MALFORMED_NUMBERS])
def test_numbers_have_one_form(four_wheel: Record, forged: object, claim: str) -> None:
    """Also where the value is the same: ``[["1", 0, 0]]`` is 2, written with a power that should have been reduced."""
    subject(four_wheel)["wheels"][0]["speed"] = forged
    assert check_certificate(four_wheel) == claim


def test_an_empty_list_is_not_zero(four_wheel: Record) -> None:
    """``"0"`` and ``[["0"]]`` are: here where the value 0 is true, so that nothing else can reject it."""
    for zero, claim in (("0", ""), ([["0"]], ""), ([], "a number, not an empty list")):
        subject(four_wheel)["at"][0] = zero
        assert check_certificate(four_wheel) == claim


def test_json_constants_are_no_numbers(four_wheel: Record, tmp_path: Path) -> None:
    path = tmp_path / "file.json"
    for constant in ("NaN", "Infinity", "1.0", "1e999"):
        text = certificate_text(four_wheel).replace('"speed": "1"', f'"speed": {constant}', 1)
        assert constant in text
        path.write_text(text, encoding="utf-8")
        assert check_file(str(path)) == (1, f"rejected: required {NOT_A_NUMBER}")


def scaled_field(radicand: int) -> Record:
    return {"polynomial": [str(-radicand), "0", "1"], "above": "0"}


def test_a_zero_in_disguise_is_not_taken_for_a_positive_number(four_wheel: Record) -> None:
    """With sqrt(2) and sqrt(8) in one field, ``sqrt(8) - 2 sqrt(2)`` has terms but no sign: that rejects."""
    zero = [["1", 1], ["-2", 0]]
    subject(four_wheel)["field"].append(scaled_field(8))
    assert check_certificate(four_wheel) == ""
    subject(four_wheel)["wheels"][0]["friction"][1] = zero
    assert "a sign" in check_certificate(four_wheel)
    subject(four_wheel)["wheels"][0]["friction"][1] = "1/2"
    evidence(four_wheel)["points"][0] = [zero, "0", "1"]
    assert "a sign" in check_certificate(four_wheel)


NO_SINGLE_ROOT = "field: polynomials with one root"
OF_DEGREE_ONE = "field: polynomials of degree two at least"
GENERATORS: dict[str, tuple[list[Any], str, str]] = {
    "no real root": (["2", "0", "1"], "0", NO_SINGLE_ROOT),
    "negative leading coefficient": (["-2", "0", "-1"], "0", NO_SINGLE_ROOT),
    "not monic": (["-2", "0", "2"], "0", NO_SINGLE_ROOT),
    "root zero": (["0", "0", "1"], "0", NO_SINGLE_ROOT),
    "linear": (["-2", "1"], "0", OF_DEGREE_ONE),
    "constant": (["-2"], "0", OF_DEGREE_ONE),
    "empty": ([], "0", OF_DEGREE_ONE),
    "fraction": (["-1/2", "0", "1"], "0", NO_SINGLE_ROOT),
    "negative bound": (["-2", "0", "1"], "-1", NO_SINGLE_ROOT),
    "root below the bound": (["-2", "0", "1"], "3/2", NO_SINGLE_ROOT),
    "three roots": (["-6", "11", "-6", "1"], "0", NO_SINGLE_ROOT),
    "in itself": ([[["-2", 0]], "0", "1"], "0", "a whole number from 0 to -1"),
}


@pytest.mark.parametrize("name", GENERATORS)
def test_generators_are_single_roots(four_wheel: Record, name: str) -> None:
    polynomial, above, claim = GENERATORS[name]
    subject(four_wheel)["field"][0] = {"polynomial": polynomial, "above": above}
    assert check_certificate(four_wheel) == claim


def test_another_bound_below_the_same_root_is_still_true(four_wheel: Record) -> None:
    subject(four_wheel)["field"][0]["above"] = "7/5"
    assert check_certificate(four_wheel) == ""


def test_work_is_bounded(four_wheel: Record, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(work, "BASE_WORK", 2_000)
    assert refusal(four_wheel, size=0) == TOO_MUCH


TOO_MUCH = "a certificate that is checked within the limits of work"


def many_generators(count: int) -> list[Record]:
    return [scaled_field(radicand) for radicand in range(2, 2 + count)]


def wheels_far_away(c: Record, count: int) -> list[Record]:
    return [{**subject(c)["wheels"][0], "position": [str(5 + k), "4"]} for k in range(count)]


LONG_DIGITS = "9" * 4000


def use_generator(c: Record, polynomial: list[str]) -> None:
    """A friction that is the root of the polynomial, so that its sign is asked for."""
    subject(c)["field"].append({"polynomial": polynomial, "above": "0"})
    subject(c)["wheels"][0]["friction"][0] = [["1", len(subject(c)["field"]) - 1]]


ATTACKS: dict[str, tuple[str, Callable[[Record], object]]] = {
    "field entries": ("a list of at most 400 items", lambda c: subject(c)["field"].extend([scaled_field(2)] * 100_000)),
    "factors": ("a list of at most 64 items", lambda c: subject(c)["wheels"][0].update(speed=[["1", *[0] * 100_000]])),
    "wheels": ("a list of at most 20000 items", lambda c: subject(c)["wheels"].extend(wheels_far_away(c, 200_000))),
    "long coefficients of a high degree": (
        TOO_MUCH,
        lambda c: use_generator(c, ["-" + LONG_DIGITS, *[LONG_DIGITS] * 199, "1"]),
    ),
    "a high degree": (
        TOO_MUCH,
        lambda c: use_generator(c, ["-2", *["1"] * 399]),
    ),
}


@few(2)
@pytest.mark.parametrize("name", ATTACKS)
def test_no_data_keep_the_checker_busy(four_wheel: Record, name: str) -> None:
    """These took from 83 s to minutes; now what is counted is refused before it is used, and all work is charged."""
    claim, attack = ATTACKS[name]
    attack(four_wheel)
    start = time.process_time()
    assert claim in check_certificate(four_wheel)
    assert time.process_time() - start < 10 * ALLOWED_SECONDS


def test_spare_generators_cost_the_wheels_nothing(four_wheel: Record) -> None:
    subject(four_wheel)["wheels"].extend(wheels_far_away(four_wheel, 200))
    seconds = []
    for spare in (0, 390):
        subject(four_wheel)["field"].extend(many_generators(spare))
        start = time.process_time()
        assert check_certificate(four_wheel) == ""
        seconds.append(time.process_time() - start)
    assert seconds[1] < 3 * seconds[0] + 2 * ALLOWED_SECONDS


def test_large_fields_are_refused_at_once(four_wheel: Record) -> None:
    start = time.process_time()
    subject(four_wheel)["field"] = [scaled_field(2)] * (tower.MAX_GENERATORS + 1)
    assert check_certificate(four_wheel) == f"a list of at most {tower.MAX_GENERATORS} items"
    subject(four_wheel)["field"] = [{"polynomial": ["-1", *["0"] * 50_000, "1"], "above": "0"}]
    assert check_certificate(four_wheel) == f"a list of at most {tower.MAX_DEGREE} items"
    assert time.process_time() - start < ALLOWED_SECONDS


# ---- cells -------------------------------------------------------------------------------


Forge: TypeAlias = Callable[[Record], object]


def _split_point(c: Record) -> None:
    """Another name for a corner, used by one cell only."""
    corner = evidence(c)["cells"][0]["polygon"][0]
    evidence(c)["points"].append(evidence(c)["points"][corner])
    evidence(c)["cells"][0]["polygon"][0] = len(evidence(c)["points"]) - 1


# Claims as the checker names them, where several forgeries violate one.
COVER = "cells that cover the square once, with each point as a corner"
CONVEX = "cell 1: a convex polygon, counterclockwise"
WEIGHTS = "points with positive weights"
TWISTS = "a twist for each choice of rows, which it obeys"
LOADS = "the wheels that carry load"
NOT_COLLINEAR = "loaded wheels that are not collinear"
DRIFT = "weights and multipliers of the lowest rate at rest"
RULE = "a rule, nearest or box, and loads under box"
LEFT_OVER = "proofs of claims that are asked"
SIGNS = "a sign, 1 or -1, of each motion at the point"
INWARD = "signs of translations that all lead inward"
RATE = "a rate at which the distance falls in the square"
DISC = "a disc in the square where V* shows one"
WHEEL = "wheel 2: a unit direction, and friction that is not negative"
RADIUS = "a positive radius"


def nearer(cell: int) -> str:
    return f"cell {cell}: wheels by their distance, at every corner"


# More of the same conditions are in the corpus, which each of them refuses alone.
CELL_FORGERIES: dict[str, tuple[str, Forge]] = {
    "a cell is missing": (COVER, lambda c: evidence(c)["cells"].pop(3)),
    "a cell is there twice": (COVER, lambda c: evidence(c)["cells"].append(copy.deepcopy(evidence(c)["cells"][0]))),
    "no cells": (COVER, lambda c: evidence(c)["cells"].clear()),
    "clockwise": (CONVEX, lambda c: evidence(c)["cells"][1]["polygon"].reverse()),
    "a corner is there twice": (
        CONVEX,
        lambda c: evidence(c)["cells"][1]["polygon"].append(evidence(c)["cells"][1]["polygon"][-1]),
    ),
    "one point": (CONVEX, lambda c: evidence(c)["cells"][1].update(polygon=[0])),
    "no corner": ("well-formed data, not a IndexError", lambda c: evidence(c)["cells"][1].update(polygon=[])),
    "another name for a corner": (COVER, _split_point),
    "an unused point": (COVER, lambda c: evidence(c)["points"].append(["0", "1/4", "1"])),
    "denominator zero": (WEIGHTS, lambda c: evidence(c)["points"][1].__setitem__(2, "0")),
    "cells beyond the square": (COVER, lambda c: subject(c).update(radius="1/4")),
    "cells within the square": (COVER, lambda c: subject(c).update(radius="1")),
    "a square of size zero": (RADIUS, lambda c: subject(c).update(radius="0")),
    "a negative index": (
        "a whole number from 0 to 8",
        lambda c: evidence(c)["cells"][1]["polygon"].__setitem__(0, evidence(c)["cells"][1]["polygon"][0] - 9),
    ),
    "an index as text": (
        "a whole number from 0 to 8",
        lambda c: evidence(c)["cells"][1]["polygon"].__setitem__(0, str(evidence(c)["cells"][1]["polygon"][0])),
    ),
    "an index as a truth value": (
        "a whole number from 0 to 8",
        lambda c: evidence(c)["cells"][0]["polygon"].__setitem__(1, True),
    ),
    "no twists": (f"cell 1: {TWISTS}", lambda c: evidence(c)["cells"][1].update(twists=[])),
    "a twist twice": (f"cell 1: {TWISTS}", lambda c: evidence(c)["cells"][1].update(twists=_first(c) * 2)),
    "one wheel": ("cell 1: wheels that leave no motion free", lambda c: evidence(c)["cells"][1]["wheels"].pop()),
    "a wheel twice": (
        "cell 1: wheels that the rule takes",
        lambda c: evidence(c)["cells"][1].update(wheels=[1, 1]),
    ),
    "four wheels": ("a list of at most 3 items", lambda c: evidence(c)["cells"][1].update(wheels=[1, 4, 3, 2])),
    "no wheels": ("a list of some items", lambda c: evidence(c)["cells"][1].update(wheels=None)),
    "an unknown wheel": ("a whole number from 0 to 4", lambda c: evidence(c)["cells"][1].update(wheels=[1, 9])),
    "wheel zero": ("cell 1: wheels that the rule takes", lambda c: evidence(c)["cells"][1].update(wheels=[0, 1])),
    "more friction across the rim": (
        f"cell 0: {TWISTS}",
        lambda c: [w.update(friction=["1/2", "1"]) for w in subject(c)["wheels"]],
    ),
    "equal friction": (f"cell 0: {TWISTS}", lambda c: subject(c)["wheels"][1].update(friction=["1", "1"])),
    "negative friction": (WHEEL, lambda c: subject(c)["wheels"][1].update(friction=["1", "-1"])),
    "a rim of another length": (WHEEL, lambda c: subject(c)["wheels"][1].update(direction=["1", "1"])),
    "wheels at one place": (
        nearer(0),
        lambda c: subject(c)["wheels"].append(copy.deepcopy(subject(c)["wheels"][0])),
    ),
    "a nearer wheel with one row": (
        nearer(0),
        lambda c: subject(c)["wheels"].append(
            {**subject(c)["wheels"][0], "position": ["0", "1/4"], "friction": ["1", "0"]}
        ),
    ),
    "fewer wheels": ("a whole number from 0 to 3", lambda c: subject(c)["wheels"].pop()),
    "rule box": (NOT_COLLINEAR, lambda c: subject(c).update(rule="box", loads="elastic")),
    "an unknown rule": (RULE, lambda c: subject(c).update(rule="Nearest")),
    "an unknown key": (
        "an object with the keys polygon wheels twists",
        lambda c: evidence(c)["cells"][1].update(area="1/8"),
    ),
}


def _first(c: Record) -> list[Any]:
    return list(evidence(c)["cells"][1]["twists"])


@pytest.mark.parametrize("name", CELL_FORGERIES)
def test_forged_cells_are_rejected(four_wheel: Record, name: str) -> None:
    claim, forge = CELL_FORGERIES[name]
    forge(four_wheel)
    assert check_certificate(four_wheel) == claim


def test_wheels_that_do_not_matter_change_nothing(four_wheel: Record) -> None:
    """One is far away; the other one is near, but has no friction."""
    first = subject(four_wheel)["wheels"][0]
    subject(four_wheel)["wheels"].append({**first, "position": ["5", "4"]})
    subject(four_wheel)["wheels"].append({**first, "position": ["0", "1/4"], "friction": ["0", "0"]})
    assert check_certificate(four_wheel) == ""


def without_origin(certificate: Record) -> Record:
    """The same cells, which no longer name the checked point as a corner."""
    c = copy.deepcopy(certificate)
    points = evidence(c)["points"]
    origin = points.index(["0", "0", "1"])
    del points[origin]
    for cell in evidence(c)["cells"]:
        cell["polygon"] = [k - (k > origin) for k in cell["polygon"] if k != origin]
    return c


def test_the_checked_point_on_a_side_must_be_a_vertex(arrays: Arrays) -> None:
    """Two facing wheels: both cells are halves of the square, and the origin lies amid the side that they share."""
    c = build_certificate(check_cells(arrays.scene(arrays.inward([(1, 0), (-1, 0)]))))
    assert [len(cell["polygon"]) for cell in evidence(c)["cells"]] == [5, 5]
    assert check_certificate(c) == ""
    assert check_certificate(without_origin(c)) == "cell 0: the checked point as a corner"


MINIMIZERS = "cell 0: all twists that minimize D"
RANK_THREE = "cell 0: twists that satisfy rows of rank three"


def carry(wheels: Any) -> Forge:
    return lambda c: evidence(c)["cells"][0].update(wheels=wheels)


BOX_FORGERIES: dict[str, tuple[str, Forge]] = {
    "a wheel carries no load": (LOADS, carry([1, 2, 3])),
    "two wheels carry load": (NOT_COLLINEAR, carry([1, 3])),
    "no wheel carries load": (NOT_COLLINEAR, carry([])),
    "a wheel as text": ("a whole number from 0 to 4", carry([1, 2, 3, "4"])),
    "a wheel as a truth value": ("a whole number from 0 to 4", carry([True, 2, 3, 4])),
    "an unknown wheel": ("a whole number from 0 to 4", carry([1, 2, 3, 4, 5])),
    "wheel zero": ("well-formed data, not a KeyError", carry([0, 1, 2, 3, 4])),
    "no loads": ("a list of some items", carry(None)),
    "no load model": ("a list of 4 items", lambda c: subject(c).update(loads=None)),
    "a load table of three rows": ("a list of 4 items", lambda c: subject(c).update(loads=[["1/4", "0", "0"]] * 3)),
    "a load table of negative loads": (LOADS, lambda c: subject(c).update(loads=[["-1/4", "0", "0"]] * 4)),
    "a twist is missing": ("cell 0: a twist", lambda c: evidence(c)["cells"][0].update(twists=[])),
    "a twist with fewer rows": (RANK_THREE, lambda c: evidence(c)["cells"][0].update(twists=[["0", "0", "1/7"]])),
    "the rest cell is moved": (
        "cell 3: all twists that minimize D",
        lambda c: [p.__setitem__(0, "1/3") for p in evidence(c)["points"] if p[0] == "1/2" and p[1] == "0"],
    ),
    "less friction across the rim": (
        MINIMIZERS,
        lambda c: [w.update(friction=["1", "1/3"]) for w in subject(c)["wheels"]],
    ),
    "speed zero": (
        "cell 1: twists that satisfy rows of rank three",
        lambda c: [w.update(speed="0") for w in subject(c)["wheels"]],
    ),
}


@pytest.mark.parametrize("name", BOX_FORGERIES)
def test_forged_loads_and_minimizers_are_rejected(four_wheel_box: Record, name: str) -> None:
    claim, forge = BOX_FORGERIES[name]
    forge(four_wheel_box)
    assert check_certificate(four_wheel_box) == claim


def test_a_wheel_listed_twice_does_not_count_twice(four_wheel_box: Record) -> None:
    """Counted twice it would be a spring of twice the stiffness, and the cells would be others."""
    for cell in evidence(four_wheel_box)["cells"]:
        cell["wheels"] = [1, *cell["wheels"]]
    assert check_certificate(four_wheel_box) == ""


def test_rows_that_tie_must_all_be_listed(arrays: Arrays) -> None:
    """Equal friction under rule nearest: both third rows belong to the cell."""
    c = build_certificate(check_cells(arrays.four_wheel((1, 1))))
    tied = next(k for k, cell in enumerate(evidence(c)["cells"]) if len(cell["twists"]) == 2)
    del evidence(c)["cells"][tied]["twists"][1]
    assert check_certificate(c) == f"cell {tied}: {TWISTS}"


def test_minimizers_that_tie_must_all_be_listed(arrays: Arrays) -> None:
    """Under equal loads everywhere D is flat between two twists of this array."""
    scene = arrays.cocircular(23)
    share, zero = scene.field(Fraction(1, len(scene.wheels))), scene.field.zero
    loads = LoadTable(((share, zero, zero),) * len(scene.wheels))
    c = build_certificate(check_cells(replace(scene, contact=Contact("box", loads))))
    assert len(evidence(c)["cells"][0]["twists"]) == 2
    for k in (0, 1):
        forged = copy.deepcopy(c)
        del evidence(forged)["cells"][0]["twists"][k]
        assert check_certificate(forged) == MINIMIZERS


# ---- clauses -----------------------------------------------------------------------------

WORDS: dict[str, tuple[Any, ...]] = {
    "equilibrium": (True, False),
    "translation": ("asymptotically stable", "stable", "unstable", "undecided"),
    "rotation": ("unstable", "stable, not attractive", "undecided"),
    "feedback": ("stabilizable", "no certificate", "not applicable", "undecided"),
    "theorem 4": ("holds", "fails", "hypotheses not met", "undecided"),
}


def unshown(kind: str, about: Any) -> str:
    return f"evidence of the claim {json.dumps({kind: about})}"


@few(1)
@pytest.mark.parametrize("clause", WORDS)
def test_another_verdict_is_rejected(certificates: dict[tuple[str, str], Record], clause: str) -> None:
    for original in certificates.values():
        for word in WORDS[clause]:
            if word != said(original).get(clause):
                c = copy.deepcopy(original)
                say(c, **{clause: word})
                assert check_certificate(c) == unshown(clause, word)


def test_a_clause_that_is_left_out_claims_less(four_wheel: Record) -> None:
    """What was shown of it stands: so does the conclusion."""
    say(four_wheel, rotation=None)
    assert check_certificate(four_wheel) == ""
    say(four_wheel, rotation="stable, not attractive")
    assert check_certificate(four_wheel) == unshown("rotation", "stable, not attractive")


def test_a_theorem_fails_only_at_an_equilibrium(certificates: dict[tuple[str, str], Record]) -> None:
    """Accepted before: a refuted clause at a point that is not shown to be an equilibrium refutes nothing."""
    c = copy.deepcopy(certificates["off-center", "nearest"])
    say(c, equilibrium=None, theorem4="fails")
    assert check_certificate(c) == unshown("theorem 4", "fails")
    say(c, theorem4=None)
    assert check_certificate(c) == ""


def test_rotation_is_not_bounded_by_the_square(arrays: Arrays) -> None:
    """Accepted before: no cell of the square turns the body, but it leaves the square."""
    wheels = [WheelData((1, 0), (1, 0), 1), WheelData((-1, 0), (-1, 0), 1), WheelData((3, 1), (0, 1), 5)]
    c = build_certificate(check_cells(arrays.scene(wheels, radius=Fraction(1, 4))))
    assert "rotation" not in said(c)
    say(c, rotation="stable, not attractive")
    assert check_certificate(c) == unshown("rotation", "stable, not attractive")


@pytest.mark.parametrize("wheels", [LEAVES_LIKE_A_ROOT, LEAVES_FROM_1E_9], ids=["root", "1e-9"])
def test_an_array_that_throws_the_body_out_is_not_certified(arrays: Arrays, wheels: list[OracleWheel]) -> None:
    """Accepted before: a velocity along a ray that omega bends out of its cone."""
    c = build_certificate(check_cells(scene_of(arrays, wheels)))
    assert said(c)["translation"] == "unstable"
    for word in ("asymptotically stable", "stable"):
        say(c, translation=word)
        assert check_certificate(c) == unshown("translation", word)


def test_a_certificate_without_any_claim_is_rejected(four_wheel: Record) -> None:
    four_wheel["statement"]["claims"] = []
    assert check_certificate(four_wheel) == "a claim"


def forge_law(law: Any) -> Forge:
    return lambda c: proofs(c).update(feedback=law)


CLAUSE_FORGERIES: dict[str, tuple[str, Forge]] = {
    "a disc of size zero": (DISC, lambda c: claim_disc(c, "0")),
    "a disc that is not shown": (
        unshown("disc", {"squared_radius": "1/4", "decreases": "strictly"}),
        lambda c: evidence(c).update(disc=None, rate=None),
    ),
    "a faster arrival": (RATE, lambda c: claim_rate(c, "1000001/1000000")),
    "an arrival that takes for ever": ("a positive rate", lambda c: claim_rate(c, "0")),
    "an arrival that is not shown": (
        unshown("arrival", {"squared_radius": "1/4", "rate": "2"}),
        lambda c: say(c, arrival={"squared_radius": "1/4", "rate": "2"}),
    ),
    "a disc with another sign": (
        unshown("disc", {"squared_radius": "1/4", "decreases": "weakly"}),
        lambda c: say(c, disc={"squared_radius": "1/4", "decreases": "weakly"}),
    ),
    "a needless barrier": (LEFT_OVER, lambda c: proofs(c).update({"barrier 0 0": ["1", "1", "0"]})),
    "negative weights": (
        DRIFT,
        lambda c: proofs(c)["lowest"].update(weights=["-1" if w == "0" else w for w in proofs(c)["lowest"]["weights"]]),
    ),
    "no weights": (DRIFT, lambda c: proofs(c)["lowest"].update(weights=["0"] * 8)),
    "weights of the other end": (
        DRIFT,
        lambda c: proofs(c)["lowest"].update(weights=proofs(c)["highest"]["weights"]),
    ),
    "multipliers of no scale": (DRIFT, lambda c: proofs(c)["lowest"].update(multipliers=["0"] * 4)),
    "a separator as well": (
        "a direction in which all velocities at the point lead",
        lambda c: proofs(c).update(separator=["1", "0"]),
    ),
    "no weights for the equilibrium": ("a proof of lowest", lambda c: proofs(c).pop("lowest")),
    "no weights for one end": ("a proof of highest", lambda c: proofs(c).pop("highest")),
    "too few signs": ("a list of 8 items", lambda c: proofs(c)["feedback"]["signs"].pop()),
    "no signs": (unshown("feedback", "stabilizable"), lambda c: proofs(c).pop("feedback")),
    "another sign": (INWARD, lambda c: proofs(c)["feedback"]["signs"].__setitem__(0, -1)),
    "a sign of nothing": (SIGNS, lambda c: proofs(c)["feedback"]["signs"].__setitem__(0, 0)),
    "signs as text": (SIGNS, forge_law({"signs": ["1"] * 8})),
    "signs as truth values": (SIGNS, forge_law({"signs": [True] * 8})),
    "a law of an unknown kind": ("an object with the keys plane", forge_law({"law": []})),
    "two laws": ("an object with the keys signs", forge_law({"signs": [1] * 8, "plane": ["0", "0", "1"]})),
    "an unknown proof": (LEFT_OVER, lambda c: proofs(c).update(translation={})),
    "no theorem": (unshown("equilibrium", True), lambda c: c["evidence"].clear()),
    "a theorem of systems": (
        "a theorem of theorem 4, tolerances, basin",
        lambda c: c["evidence"][0].update(theorem="escape"),
    ),
    "tolerances that are not stated": (
        "tolerances, under rule nearest",
        lambda c: c["evidence"].append(
            {"theorem": "tolerances", "hypotheses": {"radius": "1/8", "start": "1/4", "rate": "1"}, "proofs": {}}
        ),
    ),
}


@pytest.mark.parametrize("name", CLAUSE_FORGERIES)
def test_forged_evidence_is_rejected(four_wheel: Record, name: str) -> None:
    claim, forge = CLAUSE_FORGERIES[name]
    forge(four_wheel)
    assert check_certificate(four_wheel) == claim


def test_weights_may_be_scaled(four_wheel: Record) -> None:
    end = proofs(four_wheel)["lowest"]
    end["weights"] = [str(3 * Fraction(w)) for w in end["weights"]]
    assert check_certificate(four_wheel) == ""


@pytest.mark.parametrize(
    ("fan", "word"),
    [
        ("asymptotically stable", "stable, not attractive"),
        ("stable", "stable, not attractive"),
        (None, None),
        ("unstable", None),
    ],
)
def test_short_paths_bound_the_rotation(four_wheel: Record, fan: str | None, word: str | None) -> None:
    """No array of this kind was found, so the four-wheel twists at the point are stripped of their rotation."""
    array = read_array(subject(four_wheel))
    weights = proofs(four_wheel)["lowest"]["weights"]
    end = {"weights": weights, "multipliers": ["0", "0", "0", "1"]}
    cells = Cells(array, evidence(four_wheel)["points"], evidence(four_wheel)["cells"])
    clauses = Clauses(cells, Proofs({"lowest": end, "highest": end}))
    clauses.here = [replace(motion, twist=(*motion.twist[:2], cells.zero, cells.one)) for motion in clauses.here]
    clauses.fan = fan
    assert clauses.show_equilibrium(None)
    assert clauses.show_rotation("stable") == "stable, not attractive"  # no motion at the point turns the body
    clauses.here[0] = replace(clauses.here[0], twist=(*clauses.here[0].twist[:2], cells.one, cells.one))
    assert clauses.show_rotation(None) == word


@pytest.mark.parametrize("disc", ["1/9", None])
def test_a_smaller_disc_is_still_true_and_none_claims_nothing(four_wheel: Record, disc: str | None) -> None:
    claim_disc(four_wheel, disc)
    if disc is None:
        say(four_wheel, disc=None)
    assert check_certificate(four_wheel) == ""


def test_no_disc_reaches_beyond_the_support_polygon(arrays: Arrays) -> None:
    """Wheels at (+-1/5, +-1/10): V* decreases on the whole square of half side 1/2, but beyond 1/10 the body tips."""
    corners = [(Fraction(x, 5), Fraction(y, 10)) for x in (1, -1) for y in (1, -1)]
    c = build_certificate(check_cells(arrays.scene(arrays.inward(corners))))
    assert Fraction(evidence(c)["disc"]) == Fraction(1, 100)
    claim_disc(c, "1/99")
    assert check_certificate(c) == "a disc in the support polygon"


def test_there_is_no_disc_where_the_body_tips_at_the_point(arrays: Arrays) -> None:
    """Two wheels carry nothing that is not between them."""
    c = build_certificate(check_cells(arrays.scene(arrays.inward([(1, 0), (-1, 0)]))))
    assert evidence(c)["disc"] is None
    claim_disc(c, "1/1000")
    assert "a disc in the" in check_certificate(c)


def test_notes_are_not_read(four_wheel: Record) -> None:
    four_wheel["notes"] = {"anything": [1.5, None, "at all"]}
    assert check_certificate(four_wheel) == ""


# ---- the oracle of mutants -----------------------------------------------------------------------


@few(4)
@pytest.mark.parametrize("subject", SUBJECTS, ids=" ".join)
def test_the_original_passes_the_same_proof(
    certificates: dict[tuple[str, str], Record], subject: tuple[str, str]
) -> None:
    assert_still_true(certificates[subject])


@few(1)
@pytest.mark.parametrize("seed", range(10))
def test_the_checker_agrees_with_the_workbench_on_random_arrays(arrays: Arrays, seed: int) -> None:
    """It decides every clause by its own code: equal words on arrays of all kinds are a test of both."""
    for scene in (arrays.random(seed, 2 + seed % 5), arrays.cocircular(seed)):
        assert check_certificate(build_certificate(check_cells(scene))) == ""


def test_a_mutant_that_changes_a_claim_is_told_apart(four_wheel: Record) -> None:
    """The proof of truth itself refuses what is false."""
    forged = copy.deepcopy(four_wheel)
    evidence(forged)["cells"][0]["twists"][0][2] = "1"
    with pytest.raises(AssertionError):
        assert_still_true(forged)
    for changes in ({"translation": "unstable"}, {"obstruction": ["0", "0", "1"]}, {"theorem4": "fails"}):
        forged = copy.deepcopy(four_wheel)
        say(forged, **changes)
        with pytest.raises(AssertionError):
            assert_still_true(forged)
    claim_disc(forged := copy.deepcopy(four_wheel), "1/3")
    with pytest.raises(AssertionError):
        assert_still_true(forged)


def test_replaced_wheels_need_new_cells(four_wheel: Record, arrays: Arrays) -> None:
    """A certificate of the same array under other friction is no certificate of this one."""
    side = build_certificate(check_cells(arrays.four_wheel(SIDE)))
    evidence(four_wheel).update(cells=evidence(side)["cells"], points=evidence(side)["points"])
    assert check_certificate(four_wheel) == f"cell 0: {TWISTS}"
