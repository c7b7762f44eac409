"""Certificates of plain systems in three states and more, for the stand-alone checker of many states.

The checker (:mod:`nonsmooth.proofs.many_state_checker`) derives from the formulas what must be shown, so a certificate
holds the system, V, what is claimed, and by the name of each condition its sum of squares.  Verdicts by a Lyapunov
function, by a function that shows instability, and of points that are no equilibrium have one.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from flint import fmpq
from numpy.typing import NDArray

from nonsmooth.proofs.many_state_checker import SCHEMA, check_certificate, pattern
from nonsmooth.proofs.many_states.affine_faces import AffineFace, build_face, unit
from nonsmooth.proofs.many_states.conclusion import ManyStateMethod
from nonsmooth.proofs.many_states.conditions import ConditionSense, ScaledInequality, bending_surfaces, scaled
from nonsmooth.proofs.many_states.decay import falling, rate_conditions
from nonsmooth.proofs.many_states.decision import ManyStateResult, first_cells
from nonsmooth.proofs.many_states.empty_patterns import empty_patterns
from nonsmooth.proofs.many_states.examination import Inequality, potential_pieces, with_values
from nonsmooth.proofs.many_states.facts import rate_words, region_words
from nonsmooth.proofs.many_states.instability import find_growth
from nonsmooth.proofs.many_states.sign_cells import Pattern, RationalTerms, SignCells, adjoining, rational_terms
from nonsmooth.proofs.many_states.sublevel import named_border
from nonsmooth.proofs.sums_of_squares.ansatz import Condition, build_guards
from nonsmooth.proofs.sums_of_squares.prove import Proved, normalized
from nonsmooth.proofs.systems.derivatives import Decrease
from nonsmooth.proofs.systems.system_certificate import (
    NoCertificateError,
    about,
    accepted_claims,
    exact_text,
    notes,
    with_left_out,
)
from nonsmooth.proofs.verdicts import Translation
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.piecewise import PiecewiseExpression, parse_piecewise
from nonsmooth.symbolic.switched_system import SwitchedSystem

Record = dict[str, Any]
FINE = 1 << 20  # denominator of a direction


def build_many_certificate(result: ManyStateResult) -> Record:
    """The certificate of a verdict in three states and more, accepted by the stand-alone checker.

    Args:
        result: of a check.

    Raises:
        NoCertificateError: for a verdict that something else decides, for numbers with roots, and where the checker
            does not show all of it within its limits.
    """

    def write(claims: Collection[str]) -> Record:
        region, rate = "level" in claims and result.region, "rate" in claims and result.rate
        return _written(replace(result, region=region or None, rate=rate or None))

    shown, refused = accepted_claims(write, check_certificate)
    return with_left_out(shown, _left_out(result, shown, refused))


def _left_out(result: ManyStateResult, certificate: Record, refused: Mapping[str, str]) -> Iterator[str]:
    """What a check says that its certificate does not hold, each with the reason."""
    if "level" in refused and result.region is not None:
        yield f"{region_words(result.region, result.scene.states)}: {refused['level']}"
    if "rate" in refused:
        yield f"{rate_words(result)}: {refused['rate']}"
    if result.everywhere and not certificate["everywhere"]:
        yield "all starts in the space reach the equilibrium: V is certified on a cube"


def _written(result: ManyStateResult) -> Record:
    """What is stated and its evidence."""
    if result.method is ManyStateMethod.EQUILIBRIUM:
        return _without_equilibrium(result)
    if result.verdict is Translation.UNSTABLE:
        return _of_growth(result)
    proving = result.proving
    falls = proving is not None and proving.examination.verdict is Decrease.STRICT
    if proving is None or not (falls or result.verdict is Translation.STABLE):
        raise NoCertificateError(
            f"a certificate needs a verdict by a Lyapunov function, received one by {result.method}"
        )
    function = CertifiedFunction(result.scene, proving.formula, proving.radius, proving.examination.cells)
    own = function.record(result, proving.examination.inequalities, direction=None)
    own["everywhere"] = falls and proving.examination.is_homogeneous
    if result.verdict is not Translation.STABLE:
        if result.rate is not None:
            own["rate"] = {"kind": result.rate.decay.name.lower(), "kappa": exact_text(result.rate.kappa)}
        if result.region is not None:
            own["level"] = exact_text(result.region.level)
        own["proofs"].update(function.reach_proofs(result))
    return own


def _of_growth(result: ManyStateResult) -> Record:
    """Instability by a V that falls and is negative somewhere at every distance; where something else decided, by one
    that is searched now.
    """
    growth = result.evidence.growth or find_growth(result.scene)
    if growth is None:
        raise NoCertificateError(
            f"a certificate needs a function that shows instability, received a verdict by {result.method}"
        )
    function = CertifiedFunction(result.scene, growth.formula, growth.radius, growth.cells)
    return function.record(result, growth.inequalities, direction=[str(x) for x in growth.direction])


def _without_equilibrium(result: ManyStateResult) -> Record:
    """A direction in which all velocities at the point lead; floats propose it, the checker decides."""
    system, cells = result.scene, first_cells(result.scene)
    zero = (0,) * len(cells.states)
    velocities = [[float(p.get(zero, fmpq(0))) for p in field] for c in adjoining(cells) for field in c.velocities]
    direction = _leading_direction(np.array(velocities))
    record = CertifiedFunction(system, parse_piecewise("0", cells.states), system.field(cells.radius), cells).record(
        result, (), direction=direction
    )
    return {**record, "lyapunov": None}


def _leading_direction(velocities: NDArray[np.float64]) -> list[str]:
    """The shortest n, by the sum of absolute values, with ``n . v >= 1`` for all velocities, rounded."""
    from scipy.optimize import linprog

    count = velocities.shape[1]
    found = linprog(np.ones(2 * count), A_ub=-np.hstack([velocities, -velocities]), b_ub=-np.ones(len(velocities)))
    if not found.success:
        raise NoCertificateError("a certificate needs a direction in which all velocities lead, found none in floats")
    entries = found.x[:count] - found.x[count:]
    scale = float(np.abs(entries).max())
    return [str(fmpq(round(float(x) / scale * FINE), FINE)) for x in entries]


@dataclass(frozen=True)
class CertifiedFunction:
    """A V on its cells, and how the checker names what is shown of it."""

    system: SwitchedSystem
    formula: PiecewiseExpression
    radius: Number
    cells: SignCells

    def record(self, result: ManyStateResult, shown: Sequence[Inequality], *, direction: list[str] | None) -> Record:
        """The certificate with the conditions on V."""
        return {
            "schema": SCHEMA,
            **about(self.system),
            "radius": exact_text(self.radius),
            "verdict": str(result.verdict),
            "everywhere": False,
            "lyapunov": self.formula.text,
            "direction": direction,
            "level": None,
            "rate": None,
            "surfaces": [str(surface) for surface in self.cells.surfaces],
            "empty": list(empty_patterns(self.cells)),
            "faces": self._faces(shown),
            "proofs": {self._name(i.question): self._blocks(i.question, _stated(i), i.proved) for i in shown},
            "notes": notes(self.system),
        }

    @cached_property
    def bending(self) -> tuple[int, ...]:
        """The surfaces on which V bends."""
        return bending_surfaces(self.cells, potential_pieces(self.system, self.cells, self.formula))

    @cached_property
    def surfaces(self) -> list[RationalTerms]:
        """All surfaces, in the displacement divided by the half-width of the cube."""
        return [scaled(rational_terms(surface), self.cells.radius) for surface in self.cells.surfaces]

    def reach_proofs(self, result: ManyStateResult) -> Iterator[tuple[str, list[Record]]]:
        """Proofs of the rate and of the region."""
        if result.proving is None:
            return
        examination = result.proving.examination
        if result.rate is not None:
            asked = rate_conditions(examination, result.rate.decay, result.rate.kappa)
            for inequality, condition, proved in zip(falling(examination), asked, result.rate.evidence, strict=True):
                question = inequality.question
                yield f"rate {self._name(question)}", self._blocks(question, condition, proved)
        if result.region is not None:
            asked_there = named_border(examination, result.region.level)
            for (inequality, k, side, condition), proved in zip(asked_there, result.region.evidence, strict=True):
                place = f"border {self._piece_name(inequality.question)} {'-0+'[side + 1]}{k}"
                zero = (0,) * len(self.cells.states)
                border = build_face([{unit(len(zero), k): fmpq(1), zero: fmpq(-side)}], len(zero))
                yield place, _written_squares(condition, proved, self._guard_names(border, inequality.question.signs))

    def _blocks(self, question: ScaledInequality, condition: Condition, proved: Proved | None) -> list[Record]:
        if proved is None:
            raise NoCertificateError("a certificate needs a proof of every condition")
        face = build_face([self.surfaces[j] for j in question.zero], len(self.cells.states))
        return _written_squares(condition, proved, self._guard_names(face, question.signs))

    def _guard_names(self, face: AffineFace | None, signs: Pattern) -> list[tuple[RationalTerms, str]]:
        """Every guard that the checker knows on a face, with its name there."""
        if face is None:
            raise NoCertificateError("a certificate needs faces that are not empty")
        found: list[tuple[RationalTerms, str]] = []
        for j, (sign, surface) in enumerate(zip(signs, self.surfaces, strict=True)):
            found.append((face.restricted({e: c * sign for e, c in surface.items()}), f"s{j}"))
        for k, form in enumerate(face.coordinates):
            bounds = Condition({}, {}, (), (form,), face.dimension)
            found += [(dict(g), f"{letter}{k}") for g, letter in zip(build_guards(bounds), "bud", strict=True)]
        return found

    def _piece_name(self, question: ScaledInequality) -> str:
        return pattern(s if j in self.bending else None for j, s in enumerate(question.signs))

    def _face_name(self, question: ScaledInequality) -> str:
        own = enumerate(question.signs)
        return pattern(0 if j in question.zero else s if j in self.bending else None for j, s in own)

    def _name(self, question: ScaledInequality) -> str:
        """As the checker names the condition."""
        if question.sense is ConditionSense.POSITIVE:
            return f"V {self._piece_name(question)}"
        cell = f"cell {pattern(question.signs)} field {question.member}"
        return cell if not question.zero else f"face {self._face_name(question)} {cell}"

    def _faces(self, shown: Sequence[Inequality]) -> dict[str, Record]:
        """For each face the cell whose V is taken there, and mu."""
        found: dict[str, Record] = {}
        bending = self.bending
        for inequality in shown:
            question = inequality.question
            if not question.zero:
                continue
            others = [(j, question.signs[j]) for j in bending if j not in question.zero]
            first = next(c for c in self.cells.cells if all(c.signs[j] == s for j, s in others))
            mu: dict[str, list[list[Any]]] = {}
            for number, j, shape in question.multipliers:
                if inequality.mu.get(number):
                    mu.setdefault(str(j), []).append([str(inequality.mu[number]), list(shape)])
            name = self._face_name(question)
            known = found.setdefault(name, {"cell": pattern(first.signs), "mu": mu})
            for j_text, terms in mu.items():
                known["mu"].setdefault(j_text, terms)
        return found


def _stated(inequality: Inequality) -> Condition:
    return with_values(inequality.question.condition, inequality.mu)


def _written_squares(condition: Condition, proved: Proved, names: Sequence[tuple[RationalTerms, str]]) -> list[Record]:
    """A sum of squares about a condition; the evidence is about its multiple by powers of two."""
    divided = normalized(condition)
    whole = _ratio(condition.constant, divided.constant)
    guards = list(zip(build_guards(condition), build_guards(divided), strict=True))
    found = []
    for term in proved.evidence.terms:
        factor, own = whole, []
        for number in term.factors:
            stated, small = guards[number]
            factor /= _ratio(stated, small)
            own.append(next(name for guard, name in names if guard == dict(stated)))
        rows = [[str(value * factor) for value in row[: i + 1]] for i, row in enumerate(term.gram)]
        if any(any(row) for row in term.gram):
            found.append({"guards": own, "monomials": [list(m) for m in term.monomials], "gram": rows})
    return found


def _ratio(stated: Mapping[Any, fmpq], divided: Mapping[Any, fmpq]) -> fmpq:
    """By how much a polynomial was divided."""
    return next((c / divided[e] for e, c in stated.items() if c), fmpq(1))
