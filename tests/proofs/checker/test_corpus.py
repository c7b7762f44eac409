"""The checker on its corpus of certificates, and its arithmetic on a grid."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections import defaultdict
from collections.abc import Callable, Sequence
from fractions import Fraction
from itertools import product
from operator import add, mul, sub, truediv
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nonsmooth.proofs import checker
from nonsmooth.proofs.checker.descriptions import describe
from nonsmooth.proofs.checker.files import check_file
from nonsmooth.proofs.checker.intervals import GRID, ONE, Interval, Jet, interval, mean_value
from nonsmooth.proofs.checker.plane import Side, clipped, corners
from nonsmooth.proofs.checker.statements import OF_ARRAYS, THEOREMS, refusal
from nonsmooth.proofs.checker.theorem4 import CLAUSES
from nonsmooth.proofs.checker.tolerances import outer_ends
from nonsmooth.proofs.checker.tower import Field
from nonsmooth.proofs.checker.work import RejectedError
from tests.certificates import inclusion
from tests.certificates.array_conditions import array_conditions
from tests.certificates.cases import GROUPS, cases
from tests.certificates.conditions import conditions
from tests.certificates.corpus import (
    GOOD,
    bad_arrays,
    bad_certificates,
    forged,
    forged_text,
    good_arrays,
    good_certificates,
    text_of,
)
from tests.certificates.forgeries import Forgery, certificate_text
from tests.certificates.inclusion import contradiction, half_width
from tests.oracles.rebuilt_arrays import assert_still_true
from tests.thorough import keep, thorough

# ---- The corpus of certificates: good ones are accepted and true as far as floats see, forged ones are rejected.

SECONDS = 10.0  # of processor time, for a forged array; an idle machine takes three at most
PARTS, GOOD_PARTS = 32, 6  # of the corpus, of which `make test` takes the first
STATUS = {0: "valid", 1: "rejected", 2: "unreadable"}


def alone(path: Path) -> tuple[int, str]:
    """Exit status and output of the checker as a command of its own, with nothing but the standard library."""
    line = [sys.executable, "-I", "-S", str(Path(checker.__file__).parent), str(path)]
    process = subprocess.run(line, capture_output=True, text=True, timeout=120, check=False)
    assert not process.stderr
    return process.returncode, process.stdout


@pytest.mark.parametrize("part", keep(1, range(GOOD_PARTS)))
def test_good_ones_are_accepted(part: int) -> None:
    good = list((good_certificates() | good_arrays()).items())[part::GOOD_PARTS]
    refused = {name: refusal(record, len(text_of(record))) for name, record in good}
    assert not {name: why for name, why in refused.items() if why}


def test_there_are_good_ones_of_every_kind() -> None:
    """Of every theorem, kind of evidence and number of states."""
    good = good_certificates()
    entries = [entry for record in good.values() for entry in record["evidence"]]
    kinds = {kind for entry in entries for proof in entry["proofs"].values() for kind in proof}
    assert kinds >= {"squares", "simplices", "pairs", "mixture"}
    assert {entry["theorem"] for entry in entries} == set(THEOREMS)
    assert {len(record["statement"]["subject"]["states"]) for record in good.values()} == set(range(1, 9))
    assert all(path.stat().st_size <= 20_000 for path in GOOD.glob("*.json"))


def share(forgeries: Sequence[Forgery], part: int) -> list[Forgery]:
    """Of each kind of forgery those in every :data:`PARTS`-th place, from the one at place ``part``."""
    of_a_kind: defaultdict[str, list[Forgery]] = defaultdict(list)
    for forgery in forgeries:
        of_a_kind[forgery.kind].append(forgery)
    return [forgery for alike in of_a_kind.values() for forgery in alike[part::PARTS]]


@pytest.mark.parametrize("part", keep(1, range(PARTS)))
@pytest.mark.parametrize(
    ("forgeries", "good", "least"),
    [(bad_certificates, good_certificates, 1_000), (bad_arrays, good_arrays, 150)],
    ids=["systems", "arrays"],
)
def test_forged_ones_are_rejected(
    part: int,
    forgeries: Callable[[], tuple[Forgery, ...]],
    good: Callable[[], dict[str, Any]],
    least: int,
) -> None:
    """Every one, in one line, within some seconds."""
    for forgery in share(forgeries(), part):
        start = time.process_time()
        why = forged(forgery, good())
        assert why, forgery.record
        assert "\n" not in why
        assert time.process_time() - start < SECONDS, forgery.kind
    assert len(forgeries()) > least


def test_every_condition_refuses_alone() -> None:
    """What a checker without it would accept; and the corpus holds these files."""
    with_reasons = [forgery for forgery in (*bad_certificates(), *bad_arrays()) if forgery.because]
    assert with_reasons == [*conditions(), *array_conditions()]
    for forgery in with_reasons:
        assert forged(forgery, good_certificates() | good_arrays()) == forgery.because


def test_there_are_good_arrays_of_every_kind() -> None:
    """Of all theorems, rules and kinds of laws."""
    good = good_arrays()
    assert len(good) >= 30
    entries = [entry for record in good.values() for entry in record["evidence"]]
    assert {entry["theorem"] for entry in entries} == set(OF_ARRAYS)
    laws = {kind for entry in entries for kind in entry["proofs"].get("feedback", {})}
    assert laws == {"signs", "twists", "plane"}
    assert any(name.startswith("barrier") for entry in entries for name in entry["proofs"])
    assert any("separator" in entry["proofs"] for entry in entries)


@pytest.mark.parametrize("part", keep(1, range(PARTS)))
def test_what_good_arrays_claim_is_decided_anew(part: int) -> None:
    """The workbench, which shares no code with the checker, builds each array from its certificate."""
    for record in list(good_arrays().values())[part::PARTS]:
        assert_still_true(record)


@pytest.mark.parametrize("start", keep(1, range(0, 80, 10)))
def test_the_command_says_the_same(start: int, tmp_path: Path) -> None:
    """Some of each, as files."""
    good = good_certificates() | good_arrays()
    for name in list(good)[start::80]:
        status, output = alone(GOOD / f"{name}.json")
        assert (status, output.splitlines()[0].split(":")[0]) == (0, "valid"), name
    for forgery in (*bad_certificates(), *bad_arrays())[start::1600]:
        path = tmp_path / "forged.json"
        path.write_text(forged_text(forgery, good), encoding="utf-8")
        status, output = alone(path)
        assert output.startswith(STATUS[status]), forgery.record
        assert status, forgery.record
        assert output.count("\n") == 1


def test_texts_are_forged_at_one_place(tmp_path: Path) -> None:
    """The text that forgeries change is good as it is."""
    path = tmp_path / "good.json"
    path.write_text(certificate_text("-x"), encoding="utf-8")
    assert check_file(str(path))[0] == 0


# On ``y = x**2`` it leaves as ``x' = x**5`` does, which takes floats too long.
UNSEEN = {"bent-away"}


@pytest.mark.parametrize("part", keep(1, range(PARTS)))
def test_what_good_ones_claim_is_true(part: int) -> None:
    """As far as floats see."""
    for name, record in list(good_certificates().items())[part::PARTS]:
        assert name in UNSEEN or not contradiction(
            record["statement"], half_width(record["evidence"][0]["hypotheses"])
        ), name


def test_floats_see_what_is_false(monkeypatch: pytest.MonkeyPatch) -> None:
    """The oracle contradicts claims about systems that grow, rest elsewhere, or fall more slowly.

    No slide leads outward here: it need not be as patient as where one may.
    """
    monkeypatch.setattr(inclusion, "PATIENT", 2)
    grows = {"states": ["x", "y"], "rhs": [["x", "-sign(y)"]], "at": ["0", "0"]}
    falls = {"states": ["x", "y"], "rhs": [["-x", "-y"]], "at": ["0", "0"]}
    beside = {"states": ["x", "y"], "rhs": [["1/2 - x", "-y"]], "at": ["0", "0"]}
    turns = {"states": ["x", "y"], "rhs": [["y", "-x"]], "at": ["0", "0"]}
    about = {"function": "x**2 + y**2", "within": "1"}
    false = [
        (grows, {"stability": "stable"}),
        (grows, {"attracts": "everywhere"}),
        (falls, {"stability": "unstable"}),
        (falls, {"rate": {**about, "kind": "exponential", "kappa": "3"}}),
        (falls, {"equilibrium": False}),
        (falls, {"arrives": "in finite time"}),
        (beside, {"attracts": {**about, "below": "1/16"}}),
        (turns, {"approaches": "near"}),
        (turns, {"approaches": {**about, "below": "1/2"}}),
    ]
    for subject, claim in false:
        assert contradiction({"subject": subject, "claims": [claim]}), claim
    assert not contradiction({"subject": falls, "claims": [{"rate": {**about, "kind": "exponential", "kappa": "2"}}]})
    assert not contradiction({"subject": beside, "claims": [{"equilibrium": False}]})
    relay = {"states": ["x"], "rhs": [["-sign(x)"]], "at": ["0"]}
    assert not contradiction({"subject": relay, "claims": [{"arrives": "in finite time"}]})
    tiny = {"function": "Abs(x)", "within": "1/1000000000000", "kind": "finite", "kappa": "1"}
    assert contradiction({"subject": relay, "claims": [{"gain": {**tiny, "gamma": "1/2"}}]})
    assert not contradiction({"subject": relay, "claims": [{"gain": {**tiny, "gamma": "1"}}]})


@thorough  # beside the test above
def test_floats_see_where_slow_slides_lead() -> None:
    """On x = 0 the mean of the signs is y, so y' is y**3, or -y**3."""
    for square, leaves in (("y**2", True), ("-y**2", False)):
        slides = {"states": ["x", "y"], "rhs": [["-sign(x) + y", f"sign(x)*({square})"]], "at": ["0", "0"]}
        reason = contradiction({"subject": slides, "claims": [{"stability": "unstable"}]}, half=0.5)
        assert leaves != bool(reason)


@thorough
def test_the_corpus_can_be_written_again() -> None:
    """Evidence may be another one; what is claimed is the same.  The smaller test looks at one case of each group."""
    for case in cases():
        if case.name in good_certificates():
            assert case.certificate()["statement"] == good_certificates()[case.name]["statement"], case.name


def test_a_case_of_each_group_can_be_written_again() -> None:
    """What is claimed of it stays the same."""
    for group in GROUPS:
        case = next(group())
        assert case.certificate()["statement"] == good_certificates()[case.name]["statement"], case.name
        assert json.loads(text_of(case.certificate()))


def test_each_claim_of_an_array_is_said_on_a_line() -> None:
    """The array, five clauses, whether they are decided or not, and a line for every further claim."""
    kinds = set()
    for name, record in good_arrays().items():
        further = [kind for claim in record["statement"]["claims"] for kind in claim if kind not in CLAUSES]
        kinds |= set(further)
        lines = describe(record["statement"])
        assert len(lines) == 6 + len(further), name
        starts = [line.partition(":")[0] for line in lines[6:]]
        assert [start.replace("within the tolerances", "tolerances") for start in starts] == further, name
    assert kinds == {
        *("disc", "drift", "arrival", "swing", "turning", "obstruction", "feedback rate", "tolerances", "attracts")
    }


def test_a_region_of_a_quotient_is_said_with_its_denominator() -> None:
    """Where V is a hundredth of that, ``V < 1/4`` is another set."""
    (line,) = (text for text in describe(good_certificates()["quotient-relay"]["statement"]) if "V < 1/4" in text)
    assert line.endswith("V = (x**2 + y**2)/(1 + x**2)")


# ---- Arithmetic on a grid and clipped polygons of the checker, against fractions, which are not rounded.

ENDS = st.integers(-(1 << 140), 1 << 140) | st.integers(-3, 3) | st.integers(-(1 << 64), 1 << 64)
INTERVALS = st.tuples(ENDS, ENDS).map(lambda ends: Interval(min(ends), max(ends)))


def inside(enclosure: Interval, share: Fraction) -> Fraction:
    """One of the numbers of an interval."""
    return (enclosure.low + share * (enclosure.high - enclosure.low)) / GRID


@given(INTERVALS, INTERVALS, st.fractions(0, 1), st.fractions(0, 1), st.sampled_from([add, sub, mul, truediv]))
def test_operations_hold_what_their_operands_give(
    a: Interval, b: Interval, s: Fraction, t: Fraction, operation: Callable[[Any, Any], Any]
) -> None:
    if operation is truediv and b.low <= 0 <= b.high:
        with pytest.raises(RejectedError, match="a divisor that is not zero"):
            operation(a, b)
        return
    result = operation(a, b)
    assert result.low <= operation(inside(a, s), inside(b, t)) * GRID <= result.high


def test_numbers_of_a_field_are_enclosed_closely() -> None:
    field = Field([{"polynomial": ["-2", "0", "1"], "above": "1"}])
    enclosure = interval(field.parse([["1/3", 0], ["-5/7"]]))
    assert 0 < enclosure.high - enclosure.low < 8
    low, high = (3 * (Fraction(end, GRID) + Fraction(5, 7)) for end in (enclosure.low, enclosure.high))
    assert low**2 < 2 < high**2


def test_slopes_bound_what_a_function_may_change() -> None:
    """``x y/(x + y)`` about (2, 3), x off by 1/2 and y by 1/4: bounds hold it, and are less than twice as wide."""
    sizes = (GRID // 2, GRID // 4)
    zero = Interval(0, 0)
    middle = [Interval(2 * GRID, 2 * GRID), Interval(3 * GRID, 3 * GRID)]
    x, y = (
        Jet(Interval(enclosure.low - size, enclosure.high + size), slopes)
        for enclosure, size, slopes in zip(middle, sizes, ((ONE, zero), (zero, ONE)), strict=True)
    )
    bounds = mean_value(middle[0] * middle[1] / (middle[0] + middle[1]), x * y / (x + y), sizes)
    values = [a * b / (a + b) for a in (1.5, 2.5) for b in (2.75, 3.25)]
    low, high = bounds.low / GRID, bounds.high / GRID
    assert low < min(values) < max(values) < high
    assert high - low < 2 * (max(values) - min(values))


def polygon(rng: np.random.Generator) -> tuple[list[Side], list[Side]]:
    """A square of half side two, and whole half planes, some of which pass through its corners and each other's."""
    square = [(GRID, 0, 2 * GRID), (0, GRID, 2 * GRID), (-GRID, 0, 2 * GRID), (0, -GRID, 2 * GRID)]
    lines = [tuple(int(v) * GRID // 4 for v in rng.integers(-4, 5, 3)) for _ in range(int(rng.integers(1, 6)))]
    return square, lines  # type: ignore[return-value]  # of three each


def test_clipped_polygons_hold_the_points_of_their_half_planes() -> None:
    """Points of a grid lie in the part if they lie strictly in all half planes; its corners lie in them."""
    rng, areas = np.random.default_rng(3), 0
    for _ in range(50):
        square, lines = polygon(rng)
        part = clipped(square, lines)
        areas += bool(part)
        assert set(part) <= {*square, *lines}
        for x, y, w in corners(part) if part else ():
            assert w > 0
            assert all(a * x + b * y <= c * w for a, b, c in (*square, *lines))
        for x, y in product(range(-6, 7), repeat=2):  # thirds
            if all(a * x + b * y < 3 * c for a, b, c in (*square, *lines)):
                assert part
                assert all(a * x + b * y < 3 * c for a, b, c in part)
    assert 10 < areas < 45


def test_rays_to_what_lies_outside_the_disc_lie_between_the_ends() -> None:
    """A function that is convex on rays, ``|c| - 2 m . c``, is positive outside the disc only if it is at an end."""
    rng, count = np.random.default_rng(4), 0
    for _ in range(150):
        square, lines = polygon(rng)
        part = clipped(square, lines)
        ends = [np.array([float(x), float(y)]) for x, y, _ in outer_ends(part)] if part else []
        m = rng.normal(size=2)
        points = rng.uniform(-2, 2, (300, 2))
        sides = np.array(part, dtype=float).reshape(-1, 3)
        within = (points @ sides[:, :2].T <= sides[:, 2]).all(axis=1) & bool(part)
        outer = points[within & (np.hypot(*points.T) > 1)]
        positive = np.hypot(*outer.T) - 2 * outer @ m > 1e-9
        if not ends:
            assert not len(outer)
        elif positive.any():
            assert any(np.hypot(*end) > 2 * end @ m for end in ends)
            count += not all(np.hypot(*end) > 2 * end @ m for end in ends)
    assert count > 10
