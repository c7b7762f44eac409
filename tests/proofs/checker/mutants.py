"""Mutants of certificates: a number, a sign, a key, a formula or a part of one is changed, left out, copied or swapped.

The checker rejects a mutant, without a traceback, or what it claims is true as far as floats can see.
"""

from __future__ import annotations

import copy
import json
import random
from collections.abc import Callable, Sequence
from contextlib import suppress
from fractions import Fraction
from typing import Any, TypeAlias

from nonsmooth.proofs.checker.statements import refusal
from nonsmooth.proofs.checker.work import MALFORMED
from nonsmooth.proofs.kernel.search import NotShownError
from tests.certificates.cases import Case
from tests.certificates.inclusion import contradiction

Record: TypeAlias = dict[str, Any]
Place: TypeAlias = tuple[Any, Any]  # a container of JSON, and a key or an index

WORK = 2_000  # coefficients that the search for a mutant's evidence may look at

LETTERS = "0123456789+-*/.()xyz "
LIKE = ("0123456789", "+-*", "xy")
VALUES: tuple[Any, ...] = (None, True, False, 0, 1, -1, "", "0", "1", "-1", "1/2", "1/0", [], {}, "x", "stable", 1.5)


def places(data: Any) -> list[Place]:
    """All containers of a document, each with its keys."""
    found: list[Place] = []
    waiting = [data]
    while waiting:
        own = waiting.pop()
        keys = own.keys() if isinstance(own, dict) else range(len(own)) if isinstance(own, list) else ()
        for key in keys:
            found.append((own, key))
            waiting.append(own[key])
    return found


def with_other_letter(own: str, source: random.Random) -> str:
    """A text with one letter replaced, left out or added."""
    k = source.randrange(len(own) + 1)
    return own[:k] + source.choice(["", source.choice(LETTERS)]) + own[k + source.randrange(2) :]


def change_value(data: Any, source: random.Random) -> None:
    """Another number, sign or formula."""
    own, key = source.choice([place for place in places(data) if not isinstance(place[0][place[1]], dict | list)])
    old = own[key]
    own[key] = with_other_letter(old, source) if isinstance(old, str) else source.choice(VALUES)


def change_letter(data: Any, source: random.Random) -> None:
    """A digit, an operator or a state of a text becomes another one of its kind."""
    texts = [(own, key) for own, key in places(data) if isinstance(own[key], str)]
    own, key = source.choice([(own, key) for own, key in texts if any(set(own[key]) & set(kind) for kind in LIKE)])
    k = source.choice([k for k, letter in enumerate(own[key]) if any(letter in kind for kind in LIKE)])
    kind = next(kind for kind in LIKE if own[key][k] in kind)
    own[key] = own[key][:k] + source.choice(kind) + own[key][k + 1 :]


def replace_part(data: Any, source: random.Random) -> None:
    """Any part becomes another thing."""
    own, key = source.choice(places(data))
    own[key] = copy.deepcopy(source.choice(VALUES))


def leave_out(data: Any, source: random.Random) -> None:
    """A key or an item less."""
    own, key = source.choice(places(data))
    del own[key]


def copy_part(data: Any, source: random.Random) -> None:
    """A part of the document stands in the place of another one, or once more in its list."""
    found = places(data)
    (own, key), (other, name) = source.choice(found), source.choice(found)
    part = copy.deepcopy(own[key])
    if isinstance(other, list) and source.random() < 0.3:
        other.insert(name, part)
    else:
        other[name] = part


def swap_parts(data: Any, source: random.Random) -> None:
    """Two values of one container change places."""
    own, key = source.choice([place for place in places(data) if len(place[0]) > 1])
    other = source.choice([k for k in (own if isinstance(own, dict) else range(len(own))) if k != key])
    own[key], own[other] = own[other], own[key]


def rename_key(data: Any, source: random.Random) -> None:
    """A key with another letter."""
    own, key = source.choice([place for place in places(data) if isinstance(place[0], dict)])
    own[with_other_letter(key, source)] = own.pop(key)


CHANGES: tuple[Callable[[Any, random.Random], None], ...] = (
    change_value,
    change_value,
    change_value,
    replace_part,
    leave_out,
    copy_part,
    swap_parts,
    rename_key,
)


def mutant(original: Record, source: random.Random) -> Record:
    """One or two changes in the evidence, the statement, or anywhere."""
    found = copy.deepcopy(original)
    where = source.choice([found, found["statement"], found["evidence"], found["evidence"][0]["hypotheses"]])
    for _ in range(source.choice([1, 1, 2])):
        with suppress(IndexError):  # a part without such a place is left as it is
            source.choice(CHANGES)(where, source)
    return found


def false_mutants(originals: Sequence[Record], count: int, seed: int) -> tuple[list[str], int]:
    """What accepted mutants claim although floats contradict it; and how many other claims were accepted."""
    source, found, accepted = random.Random(seed), list[str](), 0
    for k in range(count):
        original = originals[k % len(originals)]
        text = json.dumps(mutant(original, source))
        forged = json.loads(text, parse_float=str, parse_constant=str)
        refused = refusal(forged, len(text))
        assert "\n" not in refused
        if refused or forged["statement"] == original["statement"]:
            continue
        accepted += 1
        seen = contradiction(forged["statement"], half_width(forged["evidence"][0]["hypotheses"]))
        if seen:
            found.append(f"{seen}: {json.dumps(forged['statement'])}")
    return found, accepted


def half_width(hypotheses: Record) -> float:
    """Half the side of the cube of a theorem; one where it is all of the space."""
    known = hypotheses.get("local", hypotheses)
    within = known.get("cells", known)["within"]
    return 1.0 if within is None else float(Fraction(within))


def false_theorems(cases: Sequence[Case], count: int, seed: int) -> tuple[list[str], int]:
    """The same where the forger has the search: subject and hypotheses are changed, and evidence is found for them."""
    source, found, accepted = random.Random(seed), list[str](), 0
    for k in range(count):
        case = cases[k % len(cases)]
        parts = {"subject": case.subject, "hypotheses": case.hypotheses}
        forged = copy.deepcopy(parts)
        for _ in range(source.choice([1, 2, 3])):
            with suppress(IndexError):
                source.choice([change_letter, change_letter, change_letter, swap_parts, change_value])(forged, source)
        if forged == parts or set(forged) != set(parts):
            continue
        try:
            certificate = Case(case.name, forged["subject"], case.theorem, forged["hypotheses"]).certificate(WORK)
        except (NotShownError, *MALFORMED):
            continue
        accepted += 1
        assert not refusal(certificate, len(json.dumps(certificate)))
        seen = contradiction(certificate["statement"], half_width(forged["hypotheses"]))
        if seen:
            found.append(f"{seen}: {json.dumps(forged)}")
    return found, accepted
