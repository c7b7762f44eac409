"""Forged certificates of arrays that ask for as much work as they can: each is refused within some seconds.

The limits are counted in work, not in time, so what is refused here is refused on every machine; the allowed processor
time is several times what an idle machine takes.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

from nonsmooth.proofs.certificate import build_certificate
from tests.array_certificates import check_certificate, evidence, subject
from tests.built_in import checked
from tests.thorough import but

Record = dict[str, Any]

SECONDS = 60.0  # of processor time; an idle machine takes 20 at most
AT_ONCE = 10.0  # where nothing but the reading is asked for
RANDOM = np.random.default_rng(1)
FIRST = RANDOM.bit_generator.state  # from which every test begins, whichever ran before


def digits(count: int) -> str:
    """A whole number of so many digits, none of them zero."""
    return "".join(map(str, RANDOM.integers(1, 10, count)))


def ratio(count: int) -> str:
    """A rational number; its denominator shares no factor with others, as good as always."""
    return f"{digits(count)}/{digits(count)}"


def root(radicand: str, degree: int = 2) -> Record:
    return {"polynomial": [f"-{radicand}", *["0"] * (degree - 1), "1"], "above": "0"}


def dense_reduction(c: Record) -> None:
    """Products of powers of three roots of dense polynomials, which are long sums when they are reduced."""
    first = len(subject(c)["field"])
    for _ in range(3):
        dense = [f"-{digits(3)}", *(digits(3) for _ in range(59)), "1"]
        subject(c)["field"].append({"polynomial": dense, "above": "0"})
    subject(c)["at"] = [[["1", *[first] * 21, *[first + 1] * 21], ["1", *[first + 2] * 31]]] * 2


def nested_roots(c: Record) -> None:
    for k in range(12):
        subject(c)["field"].append(
            {"polynomial": [[["-2"], ["-1", len(subject(c)["field"]) - 1]] if k else "-2", "0", "1"], "above": "0"}
        )
    subject(c)["at"] = [[["1", *range(1, len(subject(c)["field"]))], ["1"]]] * 2


def equal_monomials(c: Record) -> None:
    subject(c)["at"] = [[[f"1/{digits(3999)}"] for _ in range(80)], "0"]


def long_bottoms(c: Record) -> None:
    first = len(subject(c)["field"])
    subject(c)["field"] += [root(str(k)) for k in range(2, 52)]
    subject(c)["at"] = [[[f"1/{digits(3999)}", first + k] for k in range(50)], "0"]


def long_root(c: Record) -> None:
    subject(c)["field"].append(root(digits(3999)))
    subject(c)["wheels"][0]["friction"][0] = [["1", len(subject(c)["field"]) - 1]]


def long_points(c: Record) -> None:
    evidence(c)["points"] = [[ratio(3999), ratio(3999), "1"] for _ in range(60)]


LIMITS = "a certificate that is checked within the limits of work"
ARRAYS: dict[str, tuple[Callable[[Record], object], str]] = {
    "dense reduction": (dense_reduction, "cell 0: a twist for each choice of rows, which it obeys"),
    "nested roots": (nested_roots, "a sign that 1536 bits show"),
    "equal monomials": (equal_monomials, LIMITS),
    "long denominators": (long_bottoms, LIMITS),
    "a long root": (long_root, LIMITS),
    "long points": (long_points, "cell 0: wheels by their distance, at every corner"),
}


@cache
def good() -> str:
    return json.dumps(build_certificate(checked("four-wheel", "nearest")))


@pytest.mark.parametrize("name", but(["equal monomials", "nested roots", "long denominators"], ARRAYS))
def test_forged_arrays_end(name: str) -> None:
    RANDOM.bit_generator.state = FIRST
    data = json.loads(good())
    forge, claim = ARRAYS[name]
    forge(data)
    start = time.process_time()
    assert check_certificate(data) == claim
    assert time.process_time() - start < AT_ONCE
