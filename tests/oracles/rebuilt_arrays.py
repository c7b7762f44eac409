"""The array that a certificate speaks of, built from the certificate's own data and decided afresh by the workbench.

The workbench shares no code with the checker: numbers are elements of its own field, and cells, verdicts and bounds are
found anew.  It shares the theorems; :mod:`.nearest_paths` follows bodies instead.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Any, TypeAlias

from nonsmooth.analysis.cells.box import build_box_partition
from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.proofs.clauses.equilibrium.clause import decide_equilibrium
from nonsmooth.proofs.clauses.feedback.by_friction import decide_driven_feedback
from nonsmooth.proofs.clauses.feedback.by_rows import decide_feedback
from nonsmooth.proofs.clauses.rotation.clause import decide_rotation
from nonsmooth.proofs.clauses.translation.on_cells import TranslationResult, decide_translation
from nonsmooth.symbolic.mechanics.contact_states import Twist
from nonsmooth.symbolic.mechanics.scene import CheckedSquare, Contact, Friction, LoadTable, Scene, Wheel
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_field import NumberField
from tests.array_certificates import evidence, said, subject
from tests.oracles.array_bounds import assert_bounds_hold

Record: TypeAlias = dict[str, Any]

OBEYED = set[str]()  # subjects and claims of which the numbers were found to be true


class Decoder:
    """Numbers of a certificate in the workbench's own field."""

    def __init__(self, certificate: Record) -> None:
        entries = subject(certificate)["field"]
        largest = max((len(entry["polynomial"]) for entry in entries), default=0)
        self.field = NumberField(order_of(entries[0]["polynomial"]) if largest > 3 else 1)
        self.generators: list[Number] = []
        for entry in entries:
            coefficients = [self.number(c) for c in entry["polynomial"]]
            if len(coefficients) > 3:
                self.generators.append(self.field.two_cos(1))
            else:
                c, b, _ = coefficients
                self.generators.append(((b * b - 4 * c).sqrt() - b) / 2)

    def number(self, data: Any) -> Number:
        """The number of a rational text or of a list of products."""
        if isinstance(data, str):
            return self.field.rational(Fraction(data))
        total = self.field.zero
        for text, *factors in data:
            term = self.field.rational(Fraction(text))
            for k in factors:
                term = term * self.generators[k]
            total = total + term
        return total


def order_of(polynomial: list[str]) -> int:
    """N of the minimal polynomial of ``2 cos(2 pi/N)``."""
    for order in range(5, 400):
        modulus = NumberField(order).modulus
        if modulus is not None and [str(c) for c in modulus.coeffs()] == [str(Fraction(c)) for c in polynomial]:
            return order
    raise ValueError("required a cyclotomic polynomial")


def rebuilt(certificate: Record, decode: Decoder) -> Scene:
    """The scene that a certificate speaks of."""

    def pair(data: list[Any]) -> tuple[Number, Number]:
        return decode.number(data[0]), decode.number(data[1])

    def wheel(number: int, data: Record) -> Wheel:
        friction, speed = Friction(*pair(data["friction"])), decode.number(data["speed"])
        axis = None if data.get("axis") is None else pair(data["axis"])
        return Wheel(number, pair(data["position"]), pair(data["direction"]), speed, friction, axis=axis)

    wheels = tuple(wheel(number, data) for number, data in enumerate(subject(certificate)["wheels"], 1))
    loads = None
    if subject(certificate)["loads"] not in (None, "elastic"):
        loads = LoadTable(tuple((decode.number(a), *pair([b, c])) for a, b, c in subject(certificate)["loads"]))
    check = CheckedSquare(pair(subject(certificate)["at"]), decode.number(subject(certificate)["radius"]))
    return Scene("rebuilt", decode.field, wheels, Contact(subject(certificate)["rule"], loads), check)


@dataclass(frozen=True)
class Decided:
    """An array and what the workbench decides of it.

    Attributes:
        decode: its numbers.
        partition: its cells.
        words: verdict of each clause.
        translation: of which the disc and the rate are.
        refuted: whether feedback is obstructed.
    """

    decode: Decoder
    partition: Partition
    words: dict[str, Any]
    translation: TranslationResult
    refuted: bool

    @property
    def conclusion(self) -> str:
        """What the clauses make of Theorem 4."""
        words = self.words
        if not words["equilibrium"]:
            return "hypotheses not met"
        if words["translation"] == "unstable" or words["rotation"] == "stable, not attractive" or self.refuted:
            return "fails"
        return "undecided" if {"undecided", "no certificate"} & set(words.values()) else "holds"


@lru_cache(maxsize=40)
def decided(about: str) -> Decided:
    """An array, which is built from the JSON of a subject; most mutants are about the array of their original."""
    certificate = {"statement": {"subject": json.loads(about)}}
    decode = Decoder(certificate)
    centred = rebuilt(certificate, decode).recentred()
    box = centred.contact.rule == "box"
    partition = build_box_partition(centred) if box else build_nearest_partition(centred)
    translation = decide_translation(partition)
    feedback = decide_driven_feedback(centred) if box else decide_feedback(partition)
    words = {
        "equilibrium": decide_equilibrium(partition).verdict == "holds",
        "translation": str(translation.verdict),
        "rotation": str(decide_rotation(partition, translation).verdict),
        "feedback": str(feedback.verdict),
    }
    return Decided(decode, partition, words, translation, feedback.obstruction is not None)


def assert_still_true(certificate: Record) -> None:
    """Every claim of a certificate, its cells and its rate are those of the array that is built from it."""
    found, own = decided(json.dumps(subject(certificate))), said(certificate)
    number = found.decode.number
    for clause, word in found.words.items():
        nothing = clause == "feedback" and own.get(clause) == "no certificate" and "obstruction" not in own
        assert nothing or own.get(clause, word) == word, f"{clause}: {own.get(clause)}, and not {word}"
    assert found.refuted or "obstruction" not in own
    assert own.get("theorem 4", found.conclusion) == found.conclusion
    if "disc" in own:
        radius = found.translation.region_radius
        assert radius is not None
        assert number(own["disc"]["squared_radius"]) <= radius * radius
    if "rate" in evidence(certificate):
        worst = float(found.translation.worst_rate)
        assert 2 * float(number(evidence(certificate)["rate"])) <= -worst * (1 + 1e-9)
    looked_at = json.dumps([subject(certificate), certificate["statement"]["claims"]])
    if looked_at not in OBEYED:  # most mutants state the same of the same array
        assert_bounds_hold(certificate["statement"]["claims"], found.partition, number)
        OBEYED.add(looked_at)
    assert_same_cells(certificate, found)


def assert_same_cells(certificate: Record, found: Decided) -> None:
    """In the middle of each cell the workbench finds the cell's twists."""
    decode = found.decode
    points = [tuple(decode.number(x) for x in point) for point in evidence(certificate)["points"]]
    for cell in evidence(certificate)["cells"]:
        corners = [(points[k][0] / points[k][2], points[k][1] / points[k][2]) for k in cell["polygon"]]
        x, y = (sum((c[axis] for c in corners), decode.field.zero) / len(corners) for axis in (0, 1))
        twists = {Twist(*(decode.number(x) for x in twist)) for twist in cell["twists"]}
        assert any(set(own.twists) == twists for own in found.partition.cells_at((x, y)))
