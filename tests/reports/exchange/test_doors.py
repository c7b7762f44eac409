"""Systems from other libraries and for other programs: they say what the scene says, and other provers agree."""

from __future__ import annotations

import ctypes
import json
import random
import runpy
import shutil
import subprocess
from collections.abc import Callable
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy as sp

import nonsmooth as ns
from nonsmooth.reports.exchange.obligations import obligations_of, smtlib_text
from tests.reports.exchange.exchanged import NAMES, points, system, values
from tests.reports.exchange.provers import Kyx, kyx_problems, random_point, z3_answers
from tests.thorough import but, few, keep

# ---- Systems of SymPy, matrices, CasADi, python-control and nosnoc: the fields are those that these mean.

x, y = sp.symbols("x y", real=True)
EXACT_TENTH = "3602879701896397/36028797018963968"
NO_LIST: Any = 3


def field_of(made: ns.System, point: list[float], member: int = 0) -> list[float]:
    """The value of a field that was read, by our own walker of trees."""
    formulas = made.formulas()
    return values(formulas.fields[member], formulas.states, point)


# ---- SymPy ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
def test_a_system_goes_to_sympy_and_comes_back(name: str) -> None:
    given = system(name)
    out = given.formulas().sympy()
    rhs: Any = out.fields[0] if len(out.fields) == 1 else out.fields
    back = ns.System.from_sympy(out.states, rhs, at=given.document.get("check", {}).get("equilibrium"))
    for member, expressions in enumerate(out.fields):
        numeric = sp.lambdify(out.states, expressions, "math")
        for point in points(len(out.states)):
            own = field_of(given, point, member)
            assert own == pytest.approx(numeric(*point), rel=1e-12, abs=1e-12)
            assert field_of(back, point, member) == pytest.approx(own, rel=1e-12, abs=1e-12)


def test_numbers_stay_exact_and_a_float_is_the_binary_number_that_it_is() -> None:
    assert "1/3" in repr(ns.System.from_sympy([x], [-x / 3]))
    assert EXACT_TENTH in repr(ns.System.from_sympy([x], [-0.1 * x]))
    assert "1/10" in repr(ns.System.from_sympy([x], [-0.1 * x], decimals=True))
    assert "sqrt(2)" in repr(ns.System.from_sympy([x], [-sp.sqrt(2) * x]))
    precise = ns.System.from_sympy([x], [-sp.Float("0.1", 60) * x], decimals=True)
    assert "1/10" in repr(precise)


def test_texts_are_formulas_beside_expressions() -> None:
    """They were taken for lists of letters."""
    assert repr(ns.System.from_sympy(["x", "y"], ["y", "-x - sign(y)"])) == "System: x' = y; y' = -x - sign(y)"
    assert repr(ns.System.from_sympy([x, y], [y, "-x"])) == "System: x' = y; y' = -x"
    assert " or " in repr(ns.System.from_sympy([x, y], [[y, "-x"], ["-x", -y]]))


def nested(a: float, b: float) -> int:
    return 1 if a * a + b > 1 else 2 if a > 0 and b < 0 else 3


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        (sp.Piecewise((y, x > 0), (-x, True)), lambda a, b: b if a > 0 else -a),
        (sp.Piecewise((1, x**2 + y > 1), (2, sp.And(x > 0, y < 0)), (3, True)), nested),
        (sp.Piecewise((1, sp.Or(x > y, y > 1)), (-1, True)), lambda a, b: 1 if a > b or b > 1 else -1),
        (sp.Piecewise((5, x + y < 0), (6, x + y > 0)), lambda a, b: 5 if a + b < 0 else 6),
        (sp.Heaviside(x - y) - sp.Max(x, y) * sp.sign(y), lambda a, b: (a > b) - max(a, b) * np.sign(b)),
        ((x - y) ** 2 / (1 + x**2) - sp.Abs(x), lambda a, b: (a - b) ** 2 / (1 + a**2) - abs(a)),
    ],
)
def test_what_sympy_means(expression: sp.Expr, expected: Callable[[float, float], float]) -> None:
    made = ns.System.from_sympy([x, y], [expression, -y])
    for a, b in points(2):
        assert field_of(made, [a, b])[0] == pytest.approx(float(expected(a, b)))


def test_a_condition_that_is_zero_on_a_whole_cell_is_read_as_it_is_meant() -> None:
    """``Abs(x) - x <= 0`` holds for all x > 0, where both sides are zero: half of 1 + sgn would be one half there."""
    closed = ns.System.from_sympy([x], [sp.Piecewise((x, sp.Abs(x) - x <= 0), (-x, True), evaluate=False)])
    strict = ns.System.from_sympy([x], [sp.Piecewise((x, sp.Abs(x) - x > 0), (-x, True), evaluate=False)])
    assert field_of(closed, [0.5]) == [0.5]
    assert field_of(strict, [0.5]) == [-0.5]
    assert closed.check().verdict == "unstable"


def test_functions_of_time_are_states_and_symbols_are_parameters() -> None:
    t, k = sp.symbols("t k")
    q, v = sp.Function("q")(t), sp.Function("v")(t)
    made = ns.System.from_sympy([q, v], [v, -q - k * sp.sign(v)], parameters={k: [1, 2]}, lyapunov=q**2 + v**2)
    assert made.document["system"]["states"] == ["q", "v"]
    assert made.check().verdict in ("stable", "asymptotically stable")


@pytest.mark.parametrize(
    ("made", "message"),
    [
        (lambda: ns.System.from_sympy([x], [sp.gamma(x)]), "received gamma"),
        (lambda: ns.System.from_sympy([x], [y]), "symbols out of x, received y"),
        (lambda: ns.System.from_sympy(["x"], [x + sp.Symbol("x")]), "two different ones named x"),
        (lambda: ns.System.from_sympy([x], [sp.Piecewise((1, x > 1), (2, x < 0))]), "last condition is True"),
        (lambda: ns.System.from_sympy([x], [sp.Piecewise((1, sp.Eq(x, 1)), (2, True))]), "conditions of < <= > >="),
        (lambda: ns.System.from_sympy([x], [x ** sp.Rational(1, 3)]), "roots of Abs of a state"),
        (lambda: ns.System.from_sympy([x], [sp.oo]), "Infinity"),
        (lambda: ns.System.from_sympy([x], [object()]), "a finite number"),
        (lambda: ns.System.from_nosnoc(["x"], {"c": 1}, {"S": 1}, {"F": 1}), "matrices S and F"),
        (lambda: ns.System.from_nosnoc(["x"], [["x"], ["x"]], [[[1], [-1]]], [[["-1", "1"]]]), "matrices S and F"),
        (lambda: ns.System.from_nosnoc(3, ["x"], [[1], [-1]], [["-1", "1"]]), "required states"),
        (lambda: ns.System.from_matrices(NO_LIST), "lists of matrices"),
        (lambda: ns.System.from_sympy(NO_LIST, NO_LIST), "lists of states"),
    ],
)
def test_a_refusal_is_one_clear_line(made: Callable[[], Any], message: str) -> None:
    with pytest.raises(ns.SceneError) as refused:
        made()
    assert message in str(refused.value)
    assert "\n" not in str(refused.value)


# ---- matrices ------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(10))
def test_conewise_and_switched_linear_systems_are_what_numpy_says(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n, modes = int(rng.integers(1, 4)), int(rng.integers(2, 4))
    a, b = rng.normal(size=(modes, n, n)), rng.normal(size=(modes, n))
    c = rng.normal(size=(modes - 1, 2, n + 1))
    cones = [*c, None]
    switched = ns.System.from_matrices(list(a), offsets=list(b))
    conewise = ns.System.from_matrices(list(a), cones, offsets=list(b))
    for point in points(n):
        z = np.array(point)
        held = next(i for i in range(modes) if i == modes - 1 or (c[i] @ np.append(z, 1) > 0).all())
        assert field_of(conewise, point) == pytest.approx(a[held] @ z + b[held], rel=1e-9, abs=1e-9)
        for i in range(modes):
            assert field_of(switched, point, i) == pytest.approx(a[i] @ z + b[i], rel=1e-9, abs=1e-9)


def test_entries_are_read_exactly_of_every_kind() -> None:
    rows = [[Fraction(1, 3), Decimal("0.1")], ["sqrt(2)", np.float32(0.1)]]
    text = repr(ns.System.from_matrices([rows]))
    for written in ("1/3", "1/10", "sqrt(2)", "13421773/134217728"):
        assert written in text
    assert "sqrt(2)" in repr(ns.System.from_matrices([sp.Matrix([[-sp.sqrt(2)]])]))


def test_a_conewise_linear_system_is_decided() -> None:
    first, second = [[-1, 2], [-1, -1]], [[-1, 0], [1, -1]]
    made = ns.System.from_matrices([first, second], [[[1, 0]], None], lyapunov=[[1, 0], [0, 1]])
    assert made.check().verdict == "asymptotically stable"
    assert ns.System.from_matrices([[[0, 1], [1, 0]]]).check().verdict == "unstable"


# ---- nosnoc --------------------------------------------------------------------------------------


def test_nosnoc_is_read_in_texts_sympy_and_several_parts() -> None:
    signs = np.array([[1, 1], [1, -1], [-1, 0]])
    rows = [["y", "-x", "-1"], ["-y", "x*y", "1"]]
    texts = ns.System.from_nosnoc(["x", "y"], ["x", "y - x**2"], signs, rows)
    symbols = ns.System.from_nosnoc([x, y], [x, y - x**2], signs, [[y, -x, -1], [-y, x * y, 1]])
    parts = ns.System.from_nosnoc(
        [x, y], [[x], [y]], [[[1], [-1]], [[1], [-1]]], [[[-1, 1], [0, 0]], [[0, 0], [-1, 1]]]
    )
    for a, b in points(2):
        mode = 0 if a > 0 and b - a * a > 0 else 1 if a > 0 else 2
        expected = [[b, -b], [-a, a * b], [-1.0, 1.0]][mode]
        assert field_of(texts, [a, b]) == pytest.approx(expected)
        assert field_of(symbols, [a, b]) == pytest.approx(expected)
        assert field_of(parts, [a, b]) == [-np.sign(a), -np.sign(b)]
    assert parts.check().verdict == "asymptotically stable"


# ---- CasADi and python-control -------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
def test_a_system_goes_to_casadi_and_comes_back(name: str) -> None:
    pytest.importorskip("casadi", reason="CasADi is not required: pip install '.[casadi]'")
    given = system(name)
    out = given.formulas().casadi()
    states = list(given.formulas().states)
    for member, function in enumerate(out.fields):
        back = ns.System.from_casadi(function, states, at=given.document.get("check", {}).get("equilibrium"))
        for point in points(len(states)):
            own = field_of(given, point, member)
            assert own == pytest.approx(np.array(function(point)).ravel(), rel=1e-12, abs=1e-12)
            assert field_of(back, point) == pytest.approx(own, rel=1e-9, abs=1e-9)


def test_casadi_by_functions_of_mx_and_by_expressions() -> None:
    ca = pytest.importorskip("casadi", reason="CasADi is not required: pip install '.[casadi]'")
    q, p, z = ca.MX.sym("q", 2), ca.MX.sym("p"), ca.SX.sym("z", 2)
    rhs = ca.vertcat(ca.if_else(ca.logic_and(q[0] > 0, q[1] <= 0), q[1] ** 3, -q[0]), -p * ca.fmax(q[1], q[0] / 4))
    function = ca.Function("f", [q, p], [rhs], ["q", "p"], ["dq"])
    made = ns.System.from_casadi(function, ["q", "v"], inputs={"p": 0.5})
    for point in points(2):
        assert field_of(made, point) == pytest.approx(np.array(function(point, 0.5)).ravel())
    relays = ns.System.from_casadi(-ca.sign(z) + ca.vertcat(z[1], -z[0]), z, lyapunov=ca.sumsqr(z))
    assert relays.check().verdict == "asymptotically stable"
    assert EXACT_TENTH in repr(ns.System.from_casadi(-0.1 * z, z))
    nosnoc = ns.System.from_nosnoc(z, z[0], [[1], [-1]], ca.horzcat(ca.vertcat(-1, -z[1]), ca.vertcat(1, -z[1])))
    assert nosnoc.check().verdict == "asymptotically stable"
    refused: dict[str, Callable[[], Any]] = {
        "received LOG": lambda: ns.System.from_casadi(ca.log(z), z),
        "one in z_0, z_1": lambda: ns.System.from_casadi(z * ca.SX.sym("k"), z),
        "each further input (p)": lambda: ns.System.from_casadi(function, ["q", "v"]),
        "the symbols": lambda: ns.System.from_casadi(z, ["a", "b"]),
    }
    for message, make in refused.items():
        with pytest.raises(ns.SceneError) as error:
            make()
        assert message in str(error.value)


@pytest.mark.parametrize("seed", range(20))
def test_loops_of_control_are_what_numpy_says(seed: int) -> None:
    ct = pytest.importorskip("control", reason="python-control is not required: pip install '.[control]'")
    rng = np.random.default_rng(seed)
    n, m = int(rng.integers(1, 4)), int(rng.integers(1, 3))
    a, b, c = rng.normal(size=(n, n)), rng.normal(size=(n, m)), rng.normal(size=(m, n))
    kind, sign, limit = ("saturation", "relay", "deadzone")[seed % 3], int(rng.choice([1, -1])), 0.75
    made = ns.System.from_control(ct.ss(a, b, c, np.zeros((m, m))), kind, limit=limit, sign=sign)
    for point in points(n):
        out = c @ np.array(point)
        cut = np.clip(out, -limit, limit)
        phi = {"saturation": cut, "relay": limit * np.sign(out), "deadzone": out - cut}[kind]
        assert field_of(made, point) == pytest.approx(a @ np.array(point) + sign * b @ phi, rel=1e-9, abs=1e-9)


def test_controls_own_nonlinearities_and_what_is_refused() -> None:
    ct = pytest.importorskip("control", reason="python-control is not required: pip install '.[control]'")
    plant = ct.ss([[0, 1], [-1, -1]], [[0], [1]], [[1, 0]], [[0]])
    own = ns.System.from_control(plant, ct.saturation_nonlinearity(0.5))
    assert repr(own) == repr(ns.System.from_control(plant, "saturation", limit=0.5))
    relay = ns.System.from_control(plant, ct.relay_hysteresis_nonlinearity(1, 0))
    assert relay.check().verdict == "asymptotically stable"
    assert field_of(ns.System.from_control(plant), [1.0, 2.0]) == [2.0, -3.0]
    refused: dict[str, Callable[[], Any]] = {
        "a StateSpace": lambda: ns.System.from_control(ct.tf([1], [1, 1])),
        "continuous time": lambda: ns.System.from_control(ct.ss(1, 1, 1, 0, 0.1)),
        "without hysteresis": lambda: ns.System.from_control(plant, ct.relay_hysteresis_nonlinearity(1, 0.5)),
        "no feedthrough": lambda: ns.System.from_control(ct.ss(-1, 1, 1, 1), "relay"),
        '"deadzone"': lambda: ns.System.from_control(plant, "cubic"),
        "a positive number": lambda: ns.System.from_control(plant, "relay", limit=0),
        "1 or -1": lambda: ns.System.from_control(plant, "relay", sign=2),
    }
    for message, make in refused.items():
        with pytest.raises(ns.SceneError) as error:
            make()
        assert message in str(error.value)


# ---- tables of wheels ----------------------------------------------------------------------------


def test_wheels_of_columns_are_those_of_the_file(tmp_path: Path) -> None:
    columns: dict[str, list[Any]] = {
        "name": ["A", "B", "C", "D"],
        "x": [0.2, -0.2, -0.2, 0.2],
        "y": [0.1, 0.1, -0.1, -0.1],
        "heading": ["inward", (1, -0.5), None, "inward"],
        "speed": [0.3, 0.3, Decimal("0.3"), 0.3],
        "mu_side": [None, float("nan"), 0.25, None],
    }
    lines = ["name,x,y,heading,speed,mu_side", "A,0.2,0.1,inward,0.3,", 'B,-0.2,0.1,"[1, -0.5]",0.3,']
    lines += ["C,-0.2,-0.1,,0.3,0.25", "D,0.2,-0.1,inward,0.3,"]
    (tmp_path / "wheels.csv").write_text("\n".join(lines), encoding="utf-8")
    more: dict[str, Any] = {"mu_roll": 0.8, "mu_side": 0.4, "radius": 0.05}
    made, read = ns.Array.from_table(columns, **more), ns.Array.from_csv(tmp_path / "wheels.csv", **more)
    assert repr(made.scene.wheels) == repr(read.scene.wheels)
    assert [str(wheel.index) for wheel in made.scene.wheels] == ["A", "B", "C", "D"]


def test_wheels_of_a_data_frame() -> None:
    pandas = pytest.importorskip("pandas", reason="pandas is not required: pip install '.[tables]'")
    frame = pandas.DataFrame({"x": [1, -1, -1, 1], "y": [1, 1, -1, -1], "heading": ["inward"] * 4, "speed": [1.5] * 4})
    made = ns.Array.from_table(frame, mu_roll=1, mu_side="1/2", radius="1/10")
    assert made.check().position.verdict == "comes home"


# ---- Fields, functions and problems for other programs: they say what the scene says, and other provers agree.

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


def test_a_c_program_says_sgn_where_it_uses_it() -> None:
    """One that is not used is a warning of compilers, and an error with ``-Werror``."""
    assert "sgn" not in ns.System(["x", "y"], ["y", "-x - y**3"]).formulas().program("c")
    assert "static double sgn" in ns.System(["x", "y"], ["y", "-x - sign(y)"]).formulas().program("c")


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


@pytest.mark.parametrize("language", ["python", "c"])
def test_a_number_beyond_floats_has_no_program(language: str) -> None:
    formulas = ns.System(["x"], ["-x*1e400"]).formulas()
    for beyond in (formulas, replace(formulas, fields=(("-x",),), lyapunov="1e400*x**2")):
        with pytest.raises(ns.SceneError, match="numbers within the range of floats"):
            beyond.program(language)
    assert formulas.sympy().fields[0][0] == -(10**400) * formulas.sympy().states[0]


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
