"""Fields, functions and problems for other programs: they say what the scene says, and other provers agree."""

from __future__ import annotations

import ctypes
import json
import random
import runpy
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.reports.exchange.obligations import obligations_of, smtlib_text
from tests.reports.conftest import Invoke
from tests.reports.exchange.exchanged import NAMES, points, system, values
from tests.reports.exchange.provers import Kyx, kyx_problems, random_point, z3_answers
from tests.thorough import but, few, keep

PROVED_AGAIN = ("relay-oscillator-damped", "eq-4", "stick-slip", "moved", "three states")


# ---- programs ------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
def test_the_python_program_has_the_field(name: str, tmp_path: Path) -> None:
    formulas = system(name).formulas()
    file = tmp_path / "field.py"
    file.write_text(formulas.program("python"), encoding="utf-8")
    module = runpy.run_path(str(file))
    for member, own in enumerate(formulas.fields, 1):
        field = module["field" if len(formulas.fields) == 1 else f"field_{member}"]
        for point in points(len(formulas.states)):
            assert field(point) == pytest.approx(values(own, formulas.states, point), rel=1e-12, abs=1e-12)


def test_the_c_program_has_the_field_and_v(tmp_path: Path) -> None:
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("no C compiler (cc) was found")
    result = system("moved").check()
    formulas = result.formulas()
    (tmp_path / "field.c").write_text(formulas.program("c"), encoding="utf-8")
    flags = ["-Wall", "-Wextra", "-Werror", "-std=c99", "-O0", "-shared", "-fPIC"]
    made = [compiler, *flags, "field.c", "-o", "field.so", "-lm"]
    assert subprocess.run(made, cwd=tmp_path, capture_output=True, check=False).stderr == b""
    library = ctypes.CDLL(str(tmp_path / "field.so"))
    library.lyapunov.restype = ctypes.c_double
    for point in points(2):
        x, dx = (ctypes.c_double * 2)(*point), (ctypes.c_double * 2)()
        library.field(x, dx)
        assert list(dx) == pytest.approx(values(formulas.fields[0], formulas.states, point))
        assert library.lyapunov(x) == pytest.approx((point[0] - 1) ** 2 + point[1] ** 2)


@pytest.mark.parametrize(
    "name", ["moved", "relay-oscillator-damped", pytest.param("flower", marks=pytest.mark.thorough)]
)
def test_v_is_positive_and_falls_along_the_exported_field(name: str, tmp_path: Path) -> None:
    """V of pieces on cones too, which is written as one formula; the derivative is a difference quotient."""
    result = system(name).check()
    assert isinstance(result.evidence.scene.name, str)
    (tmp_path / "field.py").write_text(result.formulas().program("python"), encoding="utf-8")
    module = runpy.run_path(str(tmp_path / "field.py"))
    centre = np.array([1.0, 0.0]) if name == "moved" else np.zeros(2)
    assert module["lyapunov"](centre) == 0
    step = 1e-6
    for point in points(2, 40):
        x = centre + 0.1 * np.array(point)
        value = module["lyapunov"](x)
        assert value > 0
        assert module["lyapunov"](x + step * np.array(module["field"](x))) < value


def test_v_goes_to_sympy_and_casadi() -> None:
    sympy_field = system("moved").check().formulas().sympy()
    a, b = sympy_field.states
    assert sympy_field.lyapunov is not None
    assert sympy_field.lyapunov.expand() == ((a - 1) ** 2 + b**2).expand()
    pytest.importorskip("casadi", reason="CasADi is not required: pip install '.[casadi]'")
    assert float(system("moved").check().formulas().casadi().lyapunov([3.0, 2.0])) == 8.0
    with pytest.raises(ValueError, match="a language of python, c, received 'rust'"):
        system("moved").formulas().program("rust")


# ---- other provers -------------------------------------------------------------------------------


@few(2)
@pytest.mark.parametrize("name", but(["eq-4"], PROVED_AGAIN))
def test_z3_proves_the_verdict_again(name: str, tmp_path: Path) -> None:
    result = system(name).check()
    file = result.save(tmp_path / "problem.smt2")
    count = len(obligations_of(result.certificate(), name))
    assert z3_answers(file) == ["unsat"] * count


def test_z3_is_asked_something(tmp_path: Path) -> None:
    """Without the claims the hypotheses have points, and a verdict that is not so has a counterexample."""
    certificate = system("relay-oscillator-damped").check().certificate()
    obligations = obligations_of(certificate, "relays")
    vacuous = [
        type(own)(own.name, own.variables, own.hypotheses, ("not", ("=", own.variables[0], own.variables[0])))
        for own in obligations
    ]
    (tmp_path / "without.smt2").write_text(smtlib_text(vacuous, []), encoding="utf-8")
    without = z3_answers(tmp_path / "without.smt2")
    assert "sat" in without
    for turn in (0, 1):  # every second one is negated: it alone is answered otherwise
        forged = [
            type(own)(own.name, own.variables, own.hypotheses, ("not", own.conclusion)) if number % 2 == turn else own
            for number, own in enumerate(obligations)
        ]
        (tmp_path / "forged.smt2").write_text(smtlib_text(forged, []), encoding="utf-8")
        for number, found in enumerate(z3_answers(tmp_path / "forged.smt2")):
            if number % 2 != turn:
                assert found == "unsat"
            elif without[number] == "sat":
                assert found == "sat"


def test_a_mesh_of_triangles_is_refused() -> None:
    """Its conditions are no inequalities between polynomials: a file without them would say too much."""
    certificate = system("relay-oscillator-damped").check().certificate()
    certificate["evidence"] = [*certificate["evidence"], {"theorem": "basin", "hypotheses": {}, "proofs": {}}]
    with pytest.raises(ns.SceneError, match="without a mesh"):
        obligations_of(certificate, "relays")


@few(1)
@pytest.mark.parametrize("name", keep(2, ["three states", "stick-slip", "relay-oscillator-damped"]))
def test_archives_of_keymaera_x_are_formulas_that_are_true(name: str) -> None:
    result = system(name).check()
    problems = list(kyx_problems(result.content(".kyx").decode()))
    assert len(problems) == len(obligations_of(result.certificate(), name))
    source = random.Random(name)
    held = 0
    for variables, problem in problems:
        hypotheses, _, _ = problem.rpartition("->")
        for _ in range(30):
            at = random_point(variables, source)
            assert Kyx(problem, at).truth()
            held += Kyx(hypotheses, at).truth()
    assert held > 10 * len(problems) // 4


def test_the_reader_of_keymaera_x_reads() -> None:
    at = {name: json.loads("2") for name in ("z0", "z1")}
    assert Kyx("(z0 > 1) & (z1^2 = 4)\n -> ((2*z0 + (-1/2)*z1) = 3)", at).truth()
    assert not Kyx("!(z0 = z1) | (z0 + (-3) >= 0)", at).truth()


# ---- the command ---------------------------------------------------------------------------------


def test_the_command_writes_every_kind_and_refuses_in_one_line(invoke: Invoke) -> None:
    for ending in (".smt2", ".kyx", ".py", ".c"):
        done = invoke("export", "relay-oscillator-damped", "-o", f"relays{ending}")
        assert (done.status, done.out) == (0, f"relays{ending}: relay-oscillator-damped, asymptotically stable\n")
        assert "relay-oscillator-damped" in Path(f"relays{ending}").read_text(encoding="utf-8")
    for arguments, message in {
        ("four-wheel", "-o", "x.smt2"): "required a plain switched system",
        ("escaping-slide", "-o", "x.smt2"): "the theorem departure, which rests on numbers",
        ("relay-oscillator-damped", "--from", "0,0", "-o", "x.smt2"): "required no --from",
        ("relay-oscillator-damped", "-o", "x.txt"): "ends in .xml, .smt2, .kyx, .py or .c",
    }.items():
        refused = invoke("export", *arguments)
        assert refused.status == 2
        assert message in refused.err
        assert refused.err.count("\n") == 1
        assert not Path("x.smt2").exists()


# ---- tables --------------------------------------------------------------------------------------


def test_paths_maps_and_sweeps_are_data_sets() -> None:
    pytest.importorskip("xarray", reason="xarray is not required: pip install '.[tables]'")
    relays = system("relay-oscillator-damped")
    path: Any = relays.simulate((0.3, 0.2), until=1)
    assert path.to_xarray()["x"].dims in (("t",), ("row",))
    assert path.to_xarray()["x"].values.tolist() == [row["x"] for row in path.rows()]
    grid: Any = relays.map(3).to_xarray()
    assert dict(grid.sizes) == {"x": 3, "y": 3}
    assert grid["x_end"].sel(x=0.5, y=0.0).dims == ()
    swept: Any = ns.System(["x"], ["-k*x - b*x**3"], parameters={"k": 1, "b": 1}).sweep(k="1:2:3", b="0:1:2")
    assert dict(swept.to_xarray().sizes) == {"system.parameters.k": 3, "system.parameters.b": 2}
    drawn: Any = ns.System(["x"], ["-k*x"], parameters={"k": 1}).sweep(k="1:2", random=4)
    frame = drawn.to_dataframe()
    assert len(frame) == 4
    assert sum(drawn.to_xarray().sizes.values()) == 4
