"""A plain switched system: its right-hand sides in a line, its stability in another."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Self

from nonsmooth.reports.exchange.reading import Reading, tidy_formula
from nonsmooth.reports.interface.scene import PythonScene
from nonsmooth.reports.output.entries import entry, table
from nonsmooth.reports.simulations.simulate_options import PATH, UNTIL, SimulateOptions
from nonsmooth.reports.studies.study import takes
from nonsmooth.symbolic.messages.scene_error import SceneError

if TYPE_CHECKING:
    from nonsmooth.proofs.larger_region import LargerRegion
    from nonsmooth.reports.checks.equilibria import EquilibriaResult
    from nonsmooth.reports.checks.phase_portrait import PhasePortrait
    from nonsmooth.reports.checks.system_results import SystemCheckResult
    from nonsmooth.reports.exchange.formulas import FieldFormulas
    from nonsmooth.reports.simulations.maps import MapResult
    from nonsmooth.reports.simulations.orbits import OrbitResult
    from nonsmooth.reports.simulations.paths import PathResult
    from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

MAP_UNTIL = 10.0
ORBIT_UNTIL = 100.0


@dataclass(frozen=True, init=False, repr=False)
class System(PythonScene):
    """``x' = f(x)`` with ``sign`` and ``Abs`` on the right; Filippov solutions.

    Immutable: :meth:`with_` returns another one.

    Args:
        states: names, such as ``["x", "v"]``.
        rhs: one formula for each state, such as ``["v", "-sign(x) - v/2"]``; or several such lists, between which the
            field may switch at any time.
        at: the equilibrium; the origin unless given.
        radius: half-width of the square about it that is checked.
        lyapunov: a Lyapunov function to try, as a formula.
        name: what it is called in results.
        parameters: numbers that stand in the formulas by name, such as ``{"k": 2}``.

    Raises:
        SceneError: for whatever cannot be used, naming key, requirement and what was received.
    """

    document: Mapping[str, Any]

    _nameless = "system"

    def __init__(
        self,
        states: Sequence[str],
        rhs: Sequence[Any],
        *,
        at: Sequence[Any] | None = None,
        radius: Any = None,
        lyapunov: Any = None,
        name: str | None = None,
        parameters: Mapping[str, Any] | None = None,
    ) -> None:
        names = list(states) if isinstance(states, str) else states  # "xy" are the states x and y
        document: dict[str, Any] = {"system": {"states": entry(names), "rhs": entry(rhs)}}
        given = {"at": at, "radius": radius, "lyapunov": lyapunov, "name": name, "parameters": parameters}
        self._set(_changed(document, **given))

    @classmethod
    def of_document(cls, document: Mapping[str, Any]) -> Self:
        """The system of a scene file's tables.

        Raises:
            SceneError: for whatever cannot be used.
        """
        system = cls.__new__(cls)
        system._set(document)
        return system

    # ---- from other libraries (reports/exchange) -------------------------------------------------

    @classmethod
    def from_sympy(
        cls,
        states: Sequence[Any],
        rhs: Any,
        *,
        parameters: Mapping[Any, Any] | None = None,
        decimals: bool = False,
        lyapunov: Any = None,
        **more: Any,
    ) -> Self:
        """The system ``x' = f(x)`` of SymPy's expressions, with Piecewise, sign, Abs, Max, Min and Heaviside.

        What a Piecewise says on a border itself is ignored; numbers stay exact.

        Args:
            states: symbols, functions of time such as ``x(t)``, or names.
            rhs: one expression for each state, or a matrix of them; or several lists (arbitrary switching).
            parameters: numbers by symbol or name; an interval such as ``[1, 2]``.
            decimals: a float means its shortest decimal; otherwise it is the binary number that it is.
            lyapunov: V as an expression or a text.
            **more: at, radius and name, as for a :class:`System`.

        Raises:
            SceneError: for an expression that is no formula of the states.
        """
        from nonsmooth.reports.exchange.from_sympy import formulas_of_sympy

        named, reading = dict(parameters or {}), Reading("System.from_sympy", decimals)
        with reading.misfits_refused("lists of states and of expressions"):
            walker = formulas_of_sympy(states, rhs, list(named), reading)
        return cls._of_formulas(
            [walker.names[state] for state in states],
            walker.written,
            lyapunov=None if lyapunov is None else walker.formula(lyapunov, "lyapunov"),
            parameters={walker.names[symbol]: value for symbol, value in named.items()} or None,
            **more,
        )

    @classmethod
    def from_matrices(
        cls,
        matrices: Sequence[Any],
        cones: Sequence[Any] | None = None,
        *,
        offsets: Sequence[Any] | None = None,
        states: Sequence[str] | None = None,
        decimals: bool = False,
        lyapunov: Any = None,
        **more: Any,
    ) -> Self:
        """``x' = A_i x + b_i``: under arbitrary switching, or the first whose rows ``C_i x`` are all positive.

        Args:
            matrices: the A_i, arrays of NumPy or rows of numbers, each n x n.
            cones: for each of them C_i of n columns, or n + 1 with a constant; None for the last, which holds
                everywhere else. Without cones the field may be any of them at any time.
            offsets: the b_i, n numbers each; zero unless given.
            states: n names; x1, x2, ... unless given.
            decimals: a float means its shortest decimal; otherwise it is the binary number that it is.
            lyapunov: P of ``V = x' P x``, n x n, or V as a text.
            **more: at, radius and name, as for a :class:`System`.

        Raises:
            SceneError: for matrices of other shapes, and for what is no number.
        """
        from nonsmooth.reports.exchange import from_matrices

        reading = Reading("System.from_matrices", decimals)
        with reading.misfits_refused("lists of matrices, of cones and of offsets"):
            count = len(from_matrices.matrix(matrices[0], "matrices[1]", reading)) if len(matrices) else 0
            names = from_matrices.state_names(count) if states is None else list(states)
            modes = from_matrices.modes_of_matrices(matrices, offsets, names, reading)
            rhs: Any = modes if len(modes) > 1 else modes[0] if modes else []
            if cones is not None:
                rhs = from_matrices.on_cones(modes, cones, names, reading)
            form = from_matrices.quadratic_form(lyapunov, names, reading)
        return cls._of_formulas(names, rhs, lyapunov=form, **more)

    @classmethod
    def from_casadi(
        cls,
        function: Any,
        states: Any = None,
        *,
        inputs: Mapping[str, Any] | None = None,
        decimals: bool = False,
        lyapunov: Any = None,
        **more: Any,
    ) -> Self:
        """The system of a ``casadi.Function`` or expression, by its instructions (extra ``nonsmooth[casadi]``).

        Its constants are doubles: 1/3 there is the binary number next to a third.

        Args:
            function: a Function whose first input is the vector of states, or an expression.
            states: of a Function names, x1, x2, ... unless given; of an expression its symbols.
            inputs: numbers for each further input of a Function, by its name.
            decimals: a float means its shortest decimal; otherwise it is the binary number that it is.
            lyapunov: V as an expression in the same symbols, or a text.
            **more: at, radius and name, as for a :class:`System`.

        Raises:
            SceneError: without CasADi, and for instructions that formulas do not have.
        """
        from nonsmooth.reports.exchange.from_matrices import formulas_of_casadi

        reading = Reading("System.from_casadi", decimals)
        names, rhs = formulas_of_casadi(function, states, inputs or {}, reading)
        if lyapunov is not None and not isinstance(lyapunov, str):
            lyapunov = formulas_of_casadi(lyapunov, states, {}, reading)[1][0]
        return cls._of_formulas(names, rhs, lyapunov=lyapunov, **more)

    @classmethod
    def from_control(
        cls,
        plant: Any,
        nonlinearity: Any = None,
        *,
        limit: Any = 1,
        sign: int = -1,
        decimals: bool = False,
        **more: Any,
    ) -> Self:
        """The Lur'e system of python-control's state space with a nonlinearity in its loop (``nonsmooth[control]``).

        ``x' = A x + B u``, ``y = C x``, ``u_i = sign phi_i(y_i)``.

        Args:
            plant: a StateSpace in continuous time without feedthrough.
            nonlinearity: "saturation", "relay" or "deadzone"; python-control's own saturation, or relay without
                hysteresis; a list for several outputs. Without one the loop is open.
            limit: of a saturation or relay its largest value, of a dead zone its half-width; or a list.
            sign: of the feedback.
            decimals: a float means its shortest decimal; otherwise it is the binary number that it is.
            **more: at, radius, lyapunov and name, as for a :class:`System`.

        Raises:
            SceneError: without python-control, and for what is no such loop.
        """
        from nonsmooth.reports.exchange.from_matrices import formulas_of_control

        reading = Reading("System.from_control", decimals)
        return cls._of_formulas(*formulas_of_control(plant, nonlinearity, limit, sign, reading), **more)

    @classmethod
    def from_nosnoc(
        cls,
        states: Any,
        c: Any,
        S: Any,
        F: Any,
        *,
        decimals: bool = False,
        **more: Any,
    ) -> Self:
        """Nosnoc's ``x' = F(x) theta``: column i of F holds where ``S_ij c_j(x) > 0`` for all j.

        Args:
            states: names, symbols of SymPy, or a vector of CasADi's symbols; c and F are formulas in them.
            c: m switching functions; or a list of such lists, for independent parts whose fields are added.
            S: p rows of m entries -1, 0 or 1, one row for each mode; or a list of such matrices.
            F: n rows of p formulas, one row for each state; or a list of such matrices.
            decimals: a float means its shortest decimal; otherwise it is the binary number that it is.
            **more: at, radius, lyapunov and name, as for a :class:`System`.

        Raises:
            SceneError: for shapes that do not fit, and where not exactly one row of S holds for a pattern of signs.
        """
        from nonsmooth.reports.exchange.from_sympy import formulas_of_nosnoc

        reading = Reading("System.from_nosnoc", decimals)
        with reading.misfits_refused("states, a list c and matrices S and F, or lists of these"):
            read = formulas_of_nosnoc(states, c, S, F, reading)
        return cls._of_formulas(*read, **more)

    @classmethod
    def _of_formulas(cls, states: Sequence[str], rhs: Sequence[Any], **more: Any) -> Self:
        """The system of formulas that a door has written, with fewer parentheses."""
        plain = [tidy_formula(side) if isinstance(side, str) else list(map(tidy_formula, side)) for side in rhs]
        return cls(states, plain, **more)

    def _set(self, document: Mapping[str, Any]) -> None:
        object.__setattr__(self, "document", document)
        _ = self.system  # refuse what cannot be used at once

    def with_(self, **changes: Any) -> Self:
        """Another system in which at, radius, lyapunov, name or some parameters are changed.

        Raises:
            SceneError: for whatever cannot be used.
            TypeError: for another keyword.
        """
        return self.of_document(_changed(self.document, **changes))

    @cached_property
    def system(self) -> SwitchedSystem:
        """The exact system; errors name it as the document does."""
        from nonsmooth.symbolic.files.documents import deep_nesting_refused
        from nonsmooth.symbolic.files.system_builder import build_system

        label, file = self.origin
        with deep_nesting_refused(label):
            return build_system(dict(self.document), label, file)

    def __repr__(self) -> str:
        states, rhs = self.document["system"]["states"], self.document["system"]["rhs"]
        sides = rhs if all(isinstance(side, list) for side in rhs) else [rhs]
        shown = ["; ".join(f"{s}' = {formula}" for s, formula in zip(states, side, strict=True)) for side in sides]
        return f"System: {' or '.join(shown)}"[:400]

    def formulas(self) -> FieldFormulas:
        """The stated field for SymPy, CasADi, Python and C; that of a check holds the V that was found, too.

        ``formulas().sympy()``, ``.casadi()``, ``.program("python")`` and ``.program("c")``.
        """
        from nonsmooth.reports.exchange.formulas import formulas_of

        return formulas_of(self.system)

    def check(self, **changes: Any) -> SystemCheckResult:
        """Stability of the equilibrium.

        The region is a level set of the V that decides; ``check().with_region("fast")`` certifies a larger one,
        as the command does by default: triangles in two states, a level set of another V in more, and tetrahedra in
        three where nothing switches.

        Args:
            **changes: as for :meth:`with_`.
        """
        from nonsmooth.reports.checks.check import check_system

        return check_system((self.with_(**changes) if changes else self).system)

    @takes(SimulateOptions, PATH)
    def simulate(self, start: Sequence[float], until: float = UNTIL, **options: Any) -> PathResult:
        """A Filippov solution from a start.

        Args:
            start: one number for each state.
            until: last time.
            **options: keywords as below.

        Raises:
            ValueError: for options that cannot be used, and a switching function without a gradient where it vanishes.
            TrajectoryError: where the integrator gives up.
        """
        return self._simulated(start=start, until=until, **options)

    def orbit(self, start: Sequence[float], until: float = ORBIT_UNTIL) -> OrbitResult:
        """The periodic orbit that a start is near, or else the one that its path approaches.

        Of two states the orbit and its stability are proved where balls allow; else they are computed only.

        Args:
            start: one number for each state.
            until: for how long the path is followed; twice the time of approach and two periods at least.

        Raises:
            OrbitError: (a ValueError) where no periodic orbit is found, with the reason.
            SceneError: for arbitrary switching.
        """
        return self._simulated(start=start, until=until, orbit=True)

    def larger_region(self, degree: int = 4) -> LargerRegion | None:
        """A polynomial V whose certified sublevel set fills much of the region of attraction within the checked square.

        Floats propose V along the outline of the region, exact arithmetic proves it and its level. It takes seconds to
        a minute.

        Args:
            degree: of V, from two to twelve.

        Returns:
            V (``formula.text``) and ``region`` (``level``, and a point that refutes the next one), with ``check``; None
            where nothing is certified.

        Raises:
            SceneError: for another number of states than two, and for formulas that cannot be used.
            ValueError: for another degree.
        """
        from nonsmooth.proofs.larger_region import find_larger_region

        return find_larger_region(self.system, degree)

    def map(self, grid: int = 21, *, until: float = MAP_UNTIL) -> MapResult:
        """Where a grid of starts over the checked square has come to, sampled.

        Args:
            grid: starts in a row and in a column.
            until: last time.

        Raises:
            ValueError: for a grid or a time that cannot be used.
            SceneError: for another number of states than two, and for arbitrary switching.
        """
        return self._simulated(grid=grid, until=until)

    def equilibria(self) -> EquilibriaResult:
        """All places of rest in the checked square, on switching surfaces too, and the stability of each.

        Raises:
            SceneError: for arbitrary switching, roots of states, norms, and for too many states or surfaces.
        """
        from nonsmooth.reports.checks.equilibria import EQUILIBRIA

        return self._studied(EQUILIBRIA)

    def reduced(self) -> Self:
        """The smaller system without shifts that change no velocity, and without sums that are conserved.

        Its ``description`` in the document says what its states are. A V that the scene names is left out.

        Raises:
            SceneError: where there are neither.
        """
        from nonsmooth.symbolic.systems.reduction import reduce_system

        system = self.system
        return self.of_document(reduce_system(system).document(f"{system.name}-reduced", system.check.radius))

    def portrait(self) -> PhasePortrait:
        """The phase portrait of two states: cells with their fields, what solutions do on borders, level sets of V.

        Raises:
            SceneError: for another number of states, for arbitrary switching, and beside roots of states.
        """
        from nonsmooth.reports.checks.phase_portrait import PhasePortrait

        return PhasePortrait(self.system)

    @property
    def exact(self) -> SwitchedSystem:
        """See ``system``."""
        return self.system


def _changed(document: Mapping[str, Any], **changes: Any) -> dict[str, Any]:
    """The document with the keywords at their places; None leaves it as it is."""
    unknown = set(changes) - {"at", "radius", "lyapunov", "name", "parameters"}
    if unknown:
        raise TypeError(f"required a keyword among at, radius, lyapunov, name, parameters, received {min(unknown)!r}")
    changed = dict(document)
    if (parameters := changes.get("parameters")) is not None:
        if not isinstance(parameters, Mapping):
            raise SceneError(str(changes.get("name") or System._nameless), "parameters", "numbers by name", parameters)
        system = document["system"]
        changed["system"] = {**system, "parameters": {**system.get("parameters", {}), **table(parameters)}}
    if changes.get("name") is not None:
        changed["name"] = changes["name"]
    given = table(
        {"equilibrium": changes.get("at"), "radius": changes.get("radius"), "lyapunov": changes.get("lyapunov")}
    )
    if given:
        changed["check"] = {**changed.get("check", {}), **given}
    return changed
