"""``python -m tests.evidence.beside_others``: the same questions asked of nosnoc and Drake, where they are installed.

nosnoc (the Python package, with CasADi and IPOPT) follows a relay that slides, beside ``simulate``; both are compared
with the closed form.  Drake proposes a quadratic V with a level for van der Pol's equation in reversed time, by a
semidefinite program in floats; ``check`` is given the decimals that it prints, and says up to which level they serve.
Seconds are of a processor, without imports.  These are two examples, and no benchmark of either.
"""

from __future__ import annotations

import math
import re
import time
from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np

import nonsmooth as ns
from nonsmooth.reports.checks.system_results import system_answers

RELAY = (["x", "v"], ["v", "-x - v - sgn(x + v)"])
START, LAST, STAGES = (1.0, 0.3), 2.0, 25


def by_nosnoc() -> tuple[np.ndarray, float]:
    """Where the relay is after two seconds, and the seconds that it took."""
    casadi, nosnoc = map(import_module, ("casadi", "nosnoc"))
    x = casadi.SX.sym("x", 2)
    fields = [casadi.vertcat(x[1], -x[0] - x[1] - sign) for sign in (1, -1)]
    sides = [np.array([[1], [-1]])]
    model = nosnoc.NosnocModel(
        x=x, F=[casadi.horzcat(*fields)], S=sides, c=[x[0] + x[1]], x0=np.array(START), name="relay"
    )
    options = nosnoc.NosnocOpts()
    options.n_s, options.print_level, options.N_finite_elements, options.N_stages = 2, 0, 2, 1
    options.terminal_time, options.comp_tol, options.sigma_N = LAST / STAGES, 1e-9, 1e-9
    options.step_equilibration = nosnoc.StepEquilibrationMode.HEURISTIC_DELTA
    looper = nosnoc.NosnocSimLooper(nosnoc.NosnocSolver(options, model), model.x0, STAGES)
    begin = time.process_time()
    looper.run()
    return np.asarray(looper.get_results()["X_sim"][-1]), time.process_time() - begin


def by_simulate() -> tuple[np.ndarray, float]:
    """The same by events."""
    system = ns.System(*RELAY)
    system.simulate(START, LAST)  # what is imported once
    begin = time.process_time()
    path = system.simulate(START, LAST)
    return np.asarray(path.state[-1]), time.process_time() - begin


def by_formula() -> np.ndarray:
    """``v = -x`` is met at a time t found by bisection; there ``x' = -x``.

    Before, ``x'' + x' + x + 1 = 0``: with ``z = x + 1`` an oscillator of frequency ``sqrt(3)/2`` that decays as
    ``exp(-t/2)``.
    """
    frequency, (x, v) = math.sqrt(3) / 2, START
    sine = (v + (x + 1) / 2) / frequency

    def state(t: float) -> tuple[float, float]:
        decay, c, s = math.exp(-t / 2), math.cos(frequency * t), math.sin(frequency * t)
        z = decay * ((x + 1) * c + sine * s)
        rate = decay * (frequency * (sine * c - (x + 1) * s)) - z / 2
        return z - 1, rate

    low, high = 0.0, 1.0
    for _ in range(200):
        middle = (low + high) / 2
        low, high = (middle, high) if sum(state(middle)) > 0 else (low, middle)
    place = state(low)[0] * math.exp(low - LAST)
    return np.array([place, -place])


def drake_and_check() -> None:
    """A region of van der Pol's equation in reversed time."""
    symbolic, analysis, primitives = (
        import_module(f"pydrake.{name}") for name in ("symbolic", "systems.analysis", "systems.primitives")
    )
    x, y = symbolic.Variable("x"), symbolic.Variable("y")
    system = primitives.SymbolicVectorSystem(state=np.array([x, y]), dynamics=[-y, x + (x**2 - 1) * y])
    begin = time.process_time()
    function = analysis.RegionOfAttraction(system, system.CreateDefaultContext())
    seconds = time.process_time() - begin
    text = str(function.Expand()).replace("x(0)", "x").replace("x(1)", "y")  # states, as Drake writes them
    text = re.sub(r"pow\((\w), 2\)", r"\1**2", text)
    print(f"Drake: V = {text}, V < 1, {seconds:.3f} s")
    checked = ns.System(["x", "y"], ["-y", "x + (x**2 - 1)*y"], radius=2, lyapunov=text)
    begin = time.process_time()
    result = checked.check()
    print(f"check: {result.verdict}, {time.process_time() - begin:.1f} s")
    for answer in system_answers(result.evidence):
        print(f"  {answer.question}: {answer.answer}: {answer.sentence}")


def main() -> None:
    """Print what both say."""
    truth = by_formula()
    followers: list[tuple[str, Callable[[], Any]]] = [("simulate", by_simulate)]
    if find_spec("nosnoc"):
        followers.append(("nosnoc", by_nosnoc))
    for name, follow in followers:
        end, seconds = follow()
        print(f"{name}: {end.tolist()}, off by {np.abs(end - truth).max():.2g}, {seconds:.3f} s")
    if find_spec("pydrake"):
        drake_and_check()


if __name__ == "__main__":
    main()
