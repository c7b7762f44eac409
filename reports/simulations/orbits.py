"""A periodic orbit of a plain switched system: its period, its Floquet multipliers and what is proved of it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.analysis.fields.system_field import system_field
from nonsmooth.analysis.orbits.orbit import Orbit, OrbitError, OrbitErrors, SlideSense
from nonsmooth.analysis.orbits.search import find_orbit
from nonsmooth.proofs.findings import Record
from nonsmooth.proofs.orbits.orbit_proof import OrbitProof, prove_orbit
from nonsmooth.reports.output.document import Block, findings, sentences
from nonsmooth.reports.output.facts import floats
from nonsmooth.reports.output.refusals import OptionError
from nonsmooth.reports.simulations.simulate_options import SimulateOptions
from nonsmooth.reports.studies.result import DataTable, Result, short_lines
from nonsmooth.symbolic.messages.scene_error import one_line
from nonsmooth.symbolic.messages.under_way import tell
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem, require_stated

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from nonsmooth.reports.figures.path import PathPicture

SCHEMA = "nonsmooth-orbit/1"
UNTIL = 100.0  # for how long a path is followed in search of an orbit
DIGITS = 15  # of enclosures
PERIOD_DIGITS, MULTIPLIER_DIGITS = 12, 10  # at most, of computed numbers
NOTHING = 1e-9  # a multiplier below, which is what rounding leaves of zero, is shown as zero


@dataclass(frozen=True, repr=False)
class OrbitResult(Result):
    """A periodic orbit with its period, its Floquet multipliers and what is proved of it.

    Attributes:
        system: the system.
        orbit: found by floats.
        proof: what balls have shown of it.
    """

    system: SwitchedSystem
    orbit: Orbit
    proof: OrbitProof

    @property
    def period(self) -> float:
        """Time of one turn."""
        return self.orbit.period

    @property
    def period_error(self) -> float:
        """How far the period may err; infinite where that is not known."""
        return self.errors.period

    @property
    def multiplier_errors(self) -> list[float]:
        """How far each multiplier may err; infinite where that is not known."""
        return list(self.errors.multipliers)

    @property
    def proved(self) -> bool:
        """Whether the orbit and its stability are proved; else both are computed only."""
        return self.proof.is_proved

    @property
    def t(self) -> Floats:
        """Sample times of one turn, shape (m,)."""
        return self.orbit.path.t

    @property
    def state(self) -> Floats:
        """States at these times, shape (m, n)."""
        return self.orbit.path.array

    @property
    def stability(self) -> str:
        """``attracting``, ``repelling``, ``saddle`` or ``undecided``: proved, or by the multipliers as computed."""
        if self.proof.is_proved:
            return "attracting" if self.proof.attracts else "repelling"
        return self.orbit.stability

    @property
    def multipliers(self) -> list[complex]:
        """The Floquet multipliers beside the one along the orbit, what rounding leaves of zero as zero."""
        return [complex(value) if abs(value) > NOTHING else 0j for value in self.orbit.multipliers]

    @property
    def reason(self) -> str:
        """Why it is so, and why that is not proved, in one sentence."""
        if self.proof.is_proved:
            return self.proof.reason
        if self.stability == "undecided":
            return self._doubt()
        return f"{self._by_slide()}; {self.proof.reason}" if self.orbit.is_one_slide else self.proof.reason

    def _doubt(self) -> str:
        """Why the multipliers leave it undecided."""
        orbit = self.orbit
        if orbit.slide_sense is not SlideSense.ATTRACTS:
            return "a part of its slide pushes neighbours away"
        sizes, errors = np.abs(orbit.multipliers), orbit.errors.multipliers
        nearest = min(range(len(errors)), key=lambda k: abs(sizes[k] - 1) - errors[k])
        value, error = self.multipliers[nearest], errors[nearest]
        if not math.isfinite(error):
            return "how far its multipliers err could not be measured"
        doubt = (
            f"a multiplier is {_complex_text(value, error)} and may err by {error:.1g}: it is not told apart from one"
        )
        if len(sizes) > 1:
            return doubt
        return f"{doubt}, as of closed orbits around a centre; nonsmooth check may prove that the checked point is one"

    def _by_slide(self) -> str:
        """What an orbit that slides all the time does to its neighbours."""
        if self.orbit.slide_sense is SlideSense.ATTRACTS:
            return "both sides push onto the surface all along the turn, so that neighbours reach it in finite time"
        return "both sides push away from the surface all along the turn, so that solutions may leave it at any moment"

    def facts(self) -> Record:
        """JSON with stable keys."""
        path, proof = self.orbit.path.record(), self.proof
        entry = {
            "schema": SCHEMA,
            "scene": self.system.name,
            "states": list(self.system.states),
            "period": self.orbit.period,
            "period_error": floats(self.errors.period),
            "multipliers": [[value.real, value.imag] if np.isfinite(value) else None for value in self.multipliers],
            "multiplier_errors": floats(self.errors.multipliers),
            "stability": self.stability,
            "proved": proof.is_proved,
            "reason": self.reason,
            "segment": self._segment(),
            "slides": self.orbit.slides,
            "gap": self.orbit.gap,
            "unique": path["unique"],
            **{key: path[key] for key in ("t", "state", "events", "pieces")},
        }
        if proof.is_proved:
            entry["exact"] = {"period": _ball(proof.period), "multipliers": [_ball(proof.multiplier)]}
        return entry

    def _segment(self) -> Record | None:
        """The segment of a return map that was enclosed."""
        found = self.proof.segment
        if found is None:
            return None
        return {
            "point": [float(x) for x in found.point],
            "direction": [float(x) for x in found.direction],
            "half_width": float(found.reach.mid()),
            "into_itself": found.into_itself,
        }

    def table(self) -> DataTable:
        """Time and states of every sample of one turn."""
        lines = [(t, *state) for t, state in zip(self.t.tolist(), self.state.tolist(), strict=True)]
        return DataTable(("t", *self.system.states), lines)

    def draw(self, ax: Axes) -> None:
        """One turn in the plane of the first two states."""
        from nonsmooth.reports.figures.path import draw_plane

        draw_plane(ax, self._picture())

    def figure(self) -> Figure:
        """One turn: the states over time, and of two states the orbit over the switching surfaces."""
        from nonsmooth.reports.figures.path import path_figure

        return path_figure(self._picture())

    def _picture(self) -> PathPicture:
        from nonsmooth.reports.figures.path import system_picture

        title = f"{one_line(self.system.name)}: {self.summary()}"
        return system_picture(self.system, self.orbit.field, self.orbit.path, title)

    def _multiplier_text(self, value: complex, error: float) -> str:
        """A multiplier; one that rounding hides is exactly zero only where the orbit slides."""
        if not np.isfinite(value):
            return "infinite"
        if not value and not self.orbit.slides:
            return f"below {NOTHING:g}"
        return _complex_text(value, error)

    @property
    def errors(self) -> OrbitErrors:
        """How far period and multipliers may err: from the proof, where there is one."""
        proof, orbit = self.proof, self.orbit
        if not proof.is_proved:
            return orbit.errors
        return OrbitErrors(_error(orbit.period, proof.period), (_error(self.multipliers[0].real, proof.multiplier),))

    @property
    def _period_text(self) -> str:
        """The digits of the period that are right."""
        return measured_text(self.orbit.period, self.errors.period, PERIOD_DIGITS)

    def summary(self) -> str:
        """Period and stability."""
        said = "proved" if self.proof.is_proved else "computed, not proved"
        return f"periodic orbit, period {self._period_text}, {self.stability} ({said})"

    def blocks(self) -> Sequence[Block]:
        """What is said, by name."""
        head = f"{one_line(self.system.name)}: periodic orbit of {', '.join(self.system.states)}"
        return [*sentences(head), findings(self.words())]

    def __repr__(self) -> str:
        return short_lines(f"{self.system.name}: {self.summary()}", self.words())

    def words(self) -> list[tuple[str, str]]:
        """What is said, by name."""
        orbit, proof = self.orbit, self.proof
        point = ", ".join(f"{s} = {x:.10g}" for s, x in zip(self.system.states, orbit.point, strict=True))
        pieces = [f"{p.place or 'everywhere'} for {float(p.end - p.start):.6g}" for p in orbit.path.pieces]
        multipliers = ", ".join(map(self._multiplier_text, self.multipliers, self.errors.multipliers))
        enclosed = proof.is_proved
        said = "" if self.stability == "undecided" else ", proved" if enclosed else ", computed, not proved"
        rows = [
            ("period", self._period_text + (f", proved {_ball(proof.period)}" if enclosed else "")),
            ("multipliers", multipliers + (f", proved {_ball(proof.multiplier)}" if enclosed else "")),
            ("stability", f"{self.stability}{said}: {self.reason}"),
            ("through", point),
            ("turn", "; ".join(pieces)),
        ]
        if orbit.path.unique is not True:
            rows.append(("not unique", "other solutions may branch off along the turn"))
        return rows


def find_system_orbit(system: SwitchedSystem, options: SimulateOptions) -> OrbitResult:
    """Find a periodic orbit near a start, or that its path approaches, and try to prove it.

    Raises:
        OptionError: for a start that is no place, and where no orbit is found; the cause is an OrbitError.
        ValueError: for a switching function without a gradient where it vanishes.
        SceneError: for arbitrary switching, for formulas that are no polynomials where the solution goes, and for
            square roots of states.
    """
    require_stated(system)
    start = options.place(system.stated_states)
    try:
        orbit = find_orbit(system_field(system, start), start, options.until or UNTIL)
    except OrbitError as error:
        required = "--from: required a start from which a periodic orbit is found"
        raise OptionError(f"{required}, received {options.start}: {error}") from error
    tell("enclosing its return map")
    return OrbitResult(system, orbit, prove_orbit(system, orbit))


def _ball(ball: Any) -> str:
    return str(ball.str(DIGITS))


def _error(value: float, enclosed: Any) -> float:
    """Largest distance of a float from the numbers of a ball."""
    return float(abs(enclosed - value).upper())


def _complex_text(value: complex, error: float) -> str:
    real = measured_text(value.real, error, MULTIPLIER_DIGITS)
    if not value.imag:
        return real
    return f"{real} {'+' if value.imag > 0 else '-'} {measured_text(abs(value.imag), error, MULTIPLIER_DIGITS)}i"


def measured_text(value: float, error: float, most: int) -> str:
    """The digits of a computed number that are right: the last one is at least twice the error; one digit at least."""
    if not value or not math.isfinite(error):
        return f"{value:.1g}"
    size = math.floor(math.log10(abs(value)))
    last = math.ceil(math.log10(2 * error)) if error else size - most
    return f"{value:.{min(most, max(1, size - last + 1))}g}"
