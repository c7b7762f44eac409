"""Forged certificates that ask for as much work as they can: each is refused, or decided, within some seconds.

The limits are counted in work, not in time, so what is refused here is refused on every machine; the allowed processor
time is several times what an idle machine takes.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from nonsmooth.proofs import checker, many_state_checker, system_checker
from nonsmooth.proofs.certificate import build_certificate
from nonsmooth.proofs.many_state_checker import SCHEMA as MANY
from nonsmooth.proofs.system_checker import FAN_SCHEMA, SCALAR_SCHEMA
from nonsmooth.proofs.system_checker import SCHEMA as PLANAR
from nonsmooth.proofs.theorem4 import check_cells
from nonsmooth.symbolic.files.scene_file import load_scene
from tests.thorough import thorough

Record = dict[str, Any]
Bomb = Callable[[], Record]

SECONDS = 60.0  # of processor time; an idle machine takes 20 at most
AT_ONCE = 10.0  # where nothing but the reading is asked for
RANDOM = np.random.default_rng(1)
LIMITS = "a proof within the limits of this checker"


def digits(count: int) -> str:
    """A whole number of so many digits, none of them zero."""
    return "".join(map(str, RANDOM.integers(1, 10, count)))


def ratio(count: int) -> str:
    """A rational number; its denominator shares no factor with others, as good as always."""
    return f"{digits(count)}/{digits(count)}"


def scalar(rhs: str, starts: list[str] | None = None) -> Record:
    return {
        **{"schema": SCALAR_SCHEMA, "states": ["x"], "rhs": [[rhs]], "at": ["0"]},
        **{"verdict": "asymptotically stable", "starts": starts or ["-1", "1"], "notes": {}},
    }


def planar(f: str, g: str, lyapunov: Any, radius: str = "1") -> Record:
    return {
        **{"schema": PLANAR, "states": ["x", "y"], "rhs": [[f, g]], "at": ["0", "0"], "radius": radius},
        **{"lyapunov": lyapunov, "verdict": "asymptotically stable", "level": None, "rate": None, "notes": {}},
    }


def fan(f: str, g: str) -> Record:
    return {
        **{"schema": FAN_SCHEMA, "states": ["x", "y"], "rhs": [[f, g]], "at": ["0", "0"]},
        **{"verdict": "asymptotically stable", "motions": [], "gain": None, "notes": {}},
    }


def many(rhs: list[str], lyapunov: str, **more: Any) -> Record:
    return {
        **{"schema": MANY, "states": [f"x{k}" for k in range(len(rhs))], "rhs": [rhs], "at": ["0"] * len(rhs)},
        **{"radius": "1", "verdict": "asymptotically stable", "everywhere": False, "lyapunov": lyapunov},
        **{"direction": None, "level": None, "rate": None, "surfaces": [], "empty": [], "faces": {}, "proofs": {}},
        **{"notes": {}, **more},
    }


SINK = ["-x0", "-x1", "-x2"]
BOWL = "x0**2 + x1**2 + x2**2"


def matrix(size: int, entry: Callable[[int, int], str]) -> Record:
    """The Lyapunov function of a sink, shown by one dense matrix."""
    gram = [[entry(i, j) for j in range(i + 1)] for i in range(size)]
    square = {"guards": [], "monomials": [[1, 0, 0]] * size, "gram": gram}
    return many(SINK, BOWL, proofs={"V ": [square]})


def tree(leaves: int) -> str:
    """A balanced sum."""
    return "x" if leaves == 1 else f"({tree(leaves // 2)} + {tree(leaves - leaves // 2)})"


def lines(count: int, length: int) -> str:
    """Switching lines with long slopes, none through the point."""
    return "-".join(f"sign(x - {ratio(length)}*y + 1/{k + 2})" for k in range(count))


SYSTEMS: dict[str, tuple[str, Bomb]] = {
    "a power of ten": ("powers of ten", lambda: scalar("-x*(1e900*x + 1e-900)**15*sign(x)")),
    "powers of long numbers": (LIMITS, lambda: scalar("-x*(1e399*x + 1e-399)**14")),
    "roots close together": (LIMITS, lambda: scalar("-x*(1 + Abs((x**8 - 1e-300)*(x**7 + x - 1e-200)))")),
    "a long interval": ("", lambda: scalar("-x**15*1e390 - x*1e-390", [f"-{ratio(400)}", ratio(400)])),
    "long coefficients": (
        LIMITS,
        lambda: planar(f"-x*{digits(390)}", f"-y/{digits(390)}", f"({digits(390)}*x/{digits(390)} + y)**16 + x**2"),
    ),
    "a large square": ("", lambda: planar("-x", "-y", "x**2 + y**2 - 1.999*x**2*y**2 + x**4 + y**4", ratio(400))),
    "long lines": (
        "V' below its bound on every cell",
        lambda: planar("-x - " + lines(5, 300), "-y", "x**2 + y**2", ratio(399)),
    ),
    "large formulas": (
        "V' below its bound on every cell",
        lambda: planar(f"-x - sign(x - y/3) - sign(x - y/5) + 0*{tree(600)}", f"-y + 0*{tree(600)}", "x**2 + y**2"),
    ),
    "many numbers": (
        "fields that lead back on both sides",
        lambda: scalar(f"Max({','.join(f'x - {k}/1000' for k in range(200))}) - x"),
    ),
    "a long fan": (
        "all radial velocities and no others",
        lambda: fan("+".join(f"sign(x - {ratio(200)}*y)" for _ in range(8)), "-sign(y)"),
    ),
    "many minus signs": ("well-formed data, not a RecursionError", lambda: planar("-" * 3900 + "x", "-y", "x**2")),
    "brackets": ("well-formed data, not a SyntaxError", lambda: planar("(" * 1900 + "x" + ")" * 1900, "-y", "x**2")),
    "a long text": ("formulas as texts", lambda: planar("x" * 1_000_000, "-y", "x**2")),
    "a long fraction": (LIMITS, lambda: matrix(60, lambda i, j: ratio(400))),
    "equal monomials": (LIMITS, lambda: matrix(120, lambda i, j: f"1/{digits(60)}")),
    "a high power": (
        "polynomials of at most",
        lambda: many([f"-x{k}" for k in range(8)], f"({'+'.join(f'x{k}' for k in range(8))} + 1)**9"),
    ),
    "a long direction": (
        "a proof of cell",
        lambda: many(
            ["x0", "x1", "x2"],
            "-(x0 + x1 + x2)**16 - x0**2",
            surfaces=["2*x0 + x1 + (x0 + x1 + x2)**15"],
            verdict="unstable",
            direction=[ratio(400) for _ in range(3)],
        ),
    ),
    "very many surfaces": (
        "at most 400 cells",
        lambda: many(
            [f"-x{k}" for k in range(8)], "x0**2", surfaces=[f"x{k % 8} + {k + 2}*x{(k + 1) % 8}" for k in range(24)]
        ),
    ),
}
LARGE: dict[str, tuple[str, Bomb]] = {
    "a curve of zeros": (
        LIMITS,
        lambda: planar("-x*(x - 1/3)**2*(y - 1/7)**2", "-y*(x - 1/3)**2*(y - 1/7)**2", "x**2 + y**2"),
    ),
    "a large matrix": (LIMITS, lambda: matrix(200, lambda i, j: digits(400) if i == j else "1")),
    "divisions": (
        LIMITS,
        lambda: many(
            ["-x0 + sign((x0 + x1 + x2 + 1)**16)", "-x1", "-x2"],
            BOWL,
            surfaces=[f"{k}*x0 + x1 + x2*x1 + {k}" for k in range(2, 30)],
        ),
    ),
}


def checked_in(data: Record, seconds: float) -> str:
    """What the checker of a plain system says; it must not take longer."""
    check = many_state_checker.check_certificate if data["schema"] == MANY else system_checker.check_certificate
    start = time.process_time()
    claim = check(data)
    assert time.process_time() - start < seconds
    assert "\n" not in claim
    return claim


@pytest.mark.parametrize("name", SYSTEMS)
def test_forged_systems_end(name: str) -> None:
    claim, bomb = SYSTEMS[name]
    found = checked_in(bomb(), SECONDS)
    assert found.startswith(claim)
    assert bool(found) == bool(claim)


@thorough
@pytest.mark.parametrize("name", LARGE)
def test_large_forged_systems_end(name: str) -> None:  # small ones: test_forged_systems_end
    claim, bomb = LARGE[name]
    assert checked_in(bomb(), 2 * SECONDS) == claim


def test_work_grows_with_the_length_of_numbers() -> None:
    """The same proof, of a V with longer coefficients."""
    spent = []
    for length in (1, 100, 390):
        number = f"{digits(length)}/{digits(length)}"
        system_checker.check_certificate(planar("-x", "-y", f"x**2 + y**2 + ({number}*y)**4"))
        spent.append(system_checker.MAX_WORK - system_checker.BUDGET.left)
    assert spent[0] < spent[1] < spent[2]


# ---- arrays --------------------------------------------------------------------------------------


def root(radicand: str, degree: int = 2) -> Record:
    return {"polynomial": [f"-{radicand}", *["0"] * (degree - 1), "1"], "above": "0"}


def dense_reduction(c: Record) -> None:
    """Products of powers of three roots of dense polynomials, which are long sums when they are reduced."""
    first = len(c["field"])
    for _ in range(3):
        c["field"].append({"polynomial": [f"-{digits(3)}", *(digits(3) for _ in range(59)), "1"], "above": "0"})
    c["at"] = [[["1", *[first] * 21, *[first + 1] * 21], ["1", *[first + 2] * 31]]] * 2


def nested_roots(c: Record) -> None:
    for k in range(12):
        c["field"].append(
            {"polynomial": [[["-2"], ["-1", len(c["field"]) - 1]] if k else "-2", "0", "1"], "above": "0"}
        )
    c["at"] = [[["1", *range(1, len(c["field"]))], ["1"]]] * 2


def equal_monomials(c: Record) -> None:
    c["at"] = [[[f"1/{digits(3999)}"] for _ in range(300)], "0"]


def long_bottoms(c: Record) -> None:
    first = len(c["field"])
    c["field"] += [root(str(k)) for k in range(2, 202)]
    c["at"] = [[[f"1/{digits(3999)}", first + k] for k in range(200)], "0"]


def long_root(c: Record) -> None:
    c["field"].append(root(digits(3999)))
    c["wheels"][0]["friction"][0] = [["1", len(c["field"]) - 1]]


def long_points(c: Record) -> None:
    c["points"] = [[ratio(3999), ratio(3999), "1"] for _ in range(60)]


ARRAYS: dict[str, Callable[[Record], object]] = {
    "dense reduction": dense_reduction,
    "nested roots": nested_roots,
    "equal monomials": equal_monomials,
    "long denominators": long_bottoms,
    "a long root": long_root,
    "long points": long_points,
}


@pytest.mark.parametrize("name", ARRAYS)
def test_forged_arrays_end(name: str) -> None:
    data = build_certificate(check_cells(load_scene("four-wheel")))
    ARRAYS[name](data)
    start = time.process_time()
    assert checker.check_certificate(data) == "less work: the limit is reached"
    assert time.process_time() - start < AT_ONCE


# ---- files ---------------------------------------------------------------------------------------

FILES = {
    "no UTF-8": b'{"schema": "\xff\xfe\x80"}',
    "deep": b"[" * 1_000_000,
    "deep keys": b'{"a":' * 200_000,
    "a long number": b"9" * 1_000_000,
    "empty": b"",
    "a number": b"NaN",
    "two keys": b'{"schema": 1, "schema": 2}',
    "cut off": json.dumps(scalar("-x")).encode()[:-4],
}


@pytest.mark.parametrize("module", [checker, system_checker, many_state_checker], ids=lambda own: own.__name__)
@pytest.mark.parametrize("name", FILES)
def test_files_that_are_no_certificates_end_in_one_line(tmp_path: Path, name: str, module: Any) -> None:
    file = tmp_path / "certificate.json"
    file.write_bytes(FILES[name])
    start = time.process_time()
    status, line = module.check_file(str(file))
    assert time.process_time() - start < AT_ONCE
    assert status == (1 if name == "a number" else 2)
    assert "\n" not in line
    assert len(line) < 300
