"""Mutants of certificates: what a forger changes, and the harness that puts to the test whatever the checker accepts.

A mutant is a certificate in which something was changed at random.  The checker rejects it in one line, or what it
claims is true, as far as an oracle sees that does not share the checker's theory.  There are three forgers:

- :func:`at_random` changes any part, claims and keys included;
- :func:`claiming` changes the subject and the evidence, and claims all that the checker's theorems then show;
- :func:`searching` changes the subject and the hypotheses, and lets the program's own search find proofs for them.

What is attacked by theorem, and with which oracle: :mod:`tests.proofs.attacks`.
"""

from __future__ import annotations

import copy
import json
import random
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any, TypeAlias

from nonsmooth.proofs.checker.roots import read_subject
from nonsmooth.proofs.checker.statements import refusal, show_evidence
from nonsmooth.proofs.checker.work import MALFORMED, RATIONAL, RejectedError
from nonsmooth.proofs.kernel.search import NotShownError, Search

Record: TypeAlias = dict[str, Any]
Place: TypeAlias = tuple[Any, Any]  # a container of JSON, and a key or an index
Forger: TypeAlias = Callable[[Record, random.Random], Record | None]  # None where the forger gives up
Oracle: TypeAlias = Callable[[Record, random.Random], None]  # AssertionError where a claim is seen to be false

WORK = 2_000  # coefficients that the search for a mutant's evidence may look at
LETTERS = "0123456789+-*/.()xyz "
DIGITS, OPERATORS = "0123456789", "+-*"
VALUES: tuple[Any, ...] = (
    *(None, True, False, 0, 1, -1, 10**30, 1.5, "", "0", "1", "-1", "1/2", "1/0", "x"),
    *([], {}, ["0", "0"], ["0", "0", "0"]),
)
WORDS = (
    *("asymptotically stable", "stable", "unstable", "stable, not attractive", "undecided", "no certificate"),
    *("holds", "fails", "hypotheses not met", "stabilizable", "not applicable", "strictly", "weakly"),
    *("theorem 4", "tolerances", "signs", "twists", "plane", "nearest", "box", "ellipse", "elastic", "everywhere"),
    *("exponential", "finite", "lyapunov", "instability", "departure", "escape"),
)


# ---- what is changed -----------------------------------------------------------------------------


def places(data: Any) -> list[Place]:
    """All containers of a document, each with its keys; not the notes of a certificate, which nobody reads."""
    found: list[Place] = []
    waiting = [data]
    while waiting:
        own = waiting.pop()
        keys = own.keys() if isinstance(own, dict) else range(len(own)) if isinstance(own, list) else ()
        for key in keys:
            if key != "notes":
                found.append((own, key))
                waiting.append(own[key])
    return found


def leaves(data: Any) -> list[Place]:
    """The places of texts, numbers and constants."""
    return [(own, key) for own, key in places(data) if not isinstance(own[key], dict | list)]


def with_other_letter(own: str, source: random.Random) -> str:
    """A text with one letter replaced, left out or added."""
    k = source.randrange(len(own) + 1)
    return own[:k] + source.choice(["", source.choice(LETTERS)]) + own[k + source.randrange(2) :]


def other_numbers(text: str, source: random.Random) -> list[str]:
    """Rational numbers near another one and far from it, and the number by a few other factors."""
    q = Fraction(text)
    factors = (Fraction(source.randrange(1, 40), 20), Fraction(source.randrange(90, 111), 100))
    others = [q + 1, q - 1, -q, 2 * q, q / 2, q + Fraction(1, 7), q + Fraction(1, 10**12), Fraction(0)]
    return [str(other) for other in (*others, *(factor * q for factor in factors for _ in range(4)))]


def other_forms(text: str) -> list[Any]:
    """What is no rational number, or is one in another form."""
    return ["NaN", "1e3", text + "0", "-" + text, text + "/0", "9" * 4400, 3, None]


class Hand:
    """Changes documents in place, at random.

    Args:
        source: of what is chosen.
        states: the letters that stand for states; one takes another's place.
    """

    def __init__(self, source: random.Random, states: str) -> None:
        self.source = source
        self.kinds = (DIGITS, OPERATORS, states)
        gentle = (self.another_letter, self.another_letter, self.another_number, self.another_number, self.swap)
        rough = (self.another_value, self.another_form, self.replace, self.leave_out, self.add, self.copy)
        self.gentle = gentle
        self.any = (*gentle, *rough, self.reorder, self.rename)

    def change(self, data: Any, changes: Sequence[Callable[[Any], None]]) -> None:
        """One change of some kinds; none where a document has no place for it."""
        with suppress(IndexError):
            self.source.choice(changes)(data)

    def another_letter(self, data: Any) -> None:
        """A digit, an operator or a state becomes another one of its kind, in a text or a whole number."""
        found = []
        for own, key in leaves(data):
            text = own[key] if isinstance(own[key], str) else json.dumps(own[key])
            if any(letter in kind for kind in self.kinds for letter in text):
                found.append((own, key, text))
        own, key, text = self.source.choice(found)
        k = self.source.choice([k for k, letter in enumerate(text) if any(letter in kind for kind in self.kinds)])
        kind = next(kind for kind in self.kinds if text[k] in kind)
        other = text[:k] + self.source.choice([letter for letter in kind if letter != text[k]]) + text[k + 1 :]
        with suppress(ValueError):  # a word such as true has no other letter
            own[key] = other if isinstance(own[key], str) else json.loads(other)

    def another_number(self, data: Any) -> None:
        """Another rational number, or another whole one."""
        numbers = [(own, key) for own, key in leaves(data) if is_number(own[key])]
        own, key = self.source.choice(numbers)
        if isinstance(own[key], str):
            own[key] = self.source.choice(other_numbers(own[key], self.source))
        else:
            own[key] += self.source.choice([1, -1])

    def another_value(self, data: Any) -> None:
        """Another text, word or constant."""
        own, key = self.source.choice(leaves(data))
        old = own[key]
        if isinstance(old, str):
            options = [with_other_letter(old, self.source), self.source.choice(WORDS), old.upper(), old[:-1], None]
            own[key] = self.source.choice([*options, *options[:2]])
        elif isinstance(old, bool | int):
            own[key] = self.source.choice([old + 1, old - 1, -old, -old - 1, 10**30, not old, None, str(old), 1.5])
        else:
            own[key] = copy.deepcopy(self.source.choice(VALUES))

    def another_form(self, data: Any) -> None:
        """What is no number in the place of one."""
        own, key = self.source.choice([(own, key) for own, key in leaves(data) if is_number(own[key])])
        own[key] = self.source.choice(other_forms(str(own[key])))

    def replace(self, data: Any) -> None:
        """Any part becomes another thing."""
        own, key = self.source.choice(places(data))
        own[key] = copy.deepcopy(self.source.choice(VALUES))

    def leave_out(self, data: Any) -> None:
        """A key or an item less."""
        own, key = self.source.choice(places(data))
        del own[key]

    def add(self, data: Any) -> None:
        """A key or an item more, which stands elsewhere in its container already."""
        own, key = self.source.choice(places(data))
        if isinstance(own, dict):
            own["extra"] = copy.deepcopy(self.source.choice([1, own[key]]))
        else:
            own.insert(self.source.randrange(len(own) + 1), copy.deepcopy(own[key]))

    def copy(self, data: Any) -> None:
        """A part of the document stands in the place of another one, or once more in its list."""
        found = places(data)
        (own, key), (other, name) = self.source.choice(found), self.source.choice(found)
        part = copy.deepcopy(own[key])
        if isinstance(other, list) and self.source.random() < 0.3:
            other.insert(name, part)
        else:
            other[name] = part

    def swap(self, data: Any) -> None:
        """Two values of one container change places."""
        own, key = self.source.choice([place for place in places(data) if len(place[0]) > 1])
        other = self.source.choice([k for k in (own if isinstance(own, dict) else range(len(own))) if k != key])
        own[key], own[other] = own[other], own[key]

    def reorder(self, data: Any) -> None:
        """A list backwards, turned round, or empty."""
        lists = [own[key] for own, key in places(data) if isinstance(own[key], list)]
        own = self.source.choice(lists)
        own[:] = self.source.choice([own[::-1], own[1:] + own[:1], []])

    def rename(self, data: Any) -> None:
        """A key with another letter."""
        own, key = self.source.choice([place for place in places(data) if isinstance(place[0], dict)])
        own[with_other_letter(key, self.source)] = own.pop(key)


def is_number(value: Any) -> bool:
    """Whether a part is a rational number as certificates write it, or a whole one."""
    if isinstance(value, str):
        return len(value) < 4000 and bool(RATIONAL.fullmatch(value)) and not value.endswith("/0")
    return isinstance(value, int) and not isinstance(value, bool)


# ---- forgers -------------------------------------------------------------------------------------


def hand_for(certificate: Record, source: random.Random) -> Hand:
    """A hand that knows the states of a system."""
    names = certificate["statement"]["subject"].get("states", "")
    return Hand(source, "".join(name for name in names if len(name) == 1))


def at_random(original: Record, source: random.Random) -> Record:
    """One or two changes in the statement, the evidence, the hypotheses or proofs of a theorem, or anywhere."""
    found, hand = copy.deepcopy(original), hand_for(original, source)
    entry = source.choice(found["evidence"])
    where = source.choice([found, found["statement"], found["evidence"], entry["hypotheses"], entry["proofs"]])
    for _ in range(source.choice([1, 1, 2])):
        hand.change(where, hand.any)
    return found


def claiming(original: Record, source: random.Random, proof: str = "") -> Record | None:
    """One or two changes of the subject or of one theorem's evidence, and all claims that are shown then.

    Args:
        original: a valid certificate.
        source: of all choices.
        proof: the name of the only proof that is changed.
    """
    found, hand = copy.deepcopy(original), hand_for(original, source)
    entry = source.choice(found["evidence"])
    where = source.choice([found["statement"]["subject"], entry["hypotheses"], entry["hypotheses"], entry["proofs"]])
    if proof:
        where = found["evidence"][0]["proofs"][proof]
    for _ in range(source.choice([1, 1, 2])):
        hand.change(where, hand.gentle if source.random() < 0.8 else hand.any)
    found, size = as_read(found)
    try:
        _, found["statement"]["claims"] = show_evidence(found, size)
    except (RejectedError, *MALFORMED):
        return None
    return found


def searching(original: Record, source: random.Random) -> Record | None:
    """One to three changes of the subject and the hypotheses, and new evidence for these."""
    first = original["evidence"][0]
    parts = copy.deepcopy({"subject": original["statement"]["subject"], "hypotheses": first["hypotheses"]})
    hand = hand_for(original, source)
    for _ in range(source.choice([1, 2, 3])):
        hand.change(source.choice([parts["subject"], parts["hypotheses"]]), hand.gentle)
    try:
        entry, shown = Search(WORK).entry(read_subject(parts["subject"]), first["theorem"], parts["hypotheses"])
    except (NotShownError, *MALFORMED):
        return None
    return {**original, "statement": {"subject": parts["subject"], "claims": shown}, "evidence": [entry]}


def as_read(record: Record) -> tuple[Record, int]:
    """A certificate after it was written and read, as the checker's files are, and its size."""
    text = json.dumps(record)
    return json.loads(text, parse_float=str, parse_constant=str), len(text)


def is_one_line(refused: str) -> bool:
    """Whether something is refused, in one line."""
    return bool(refused) and "\n" not in refused


# ---- the harness ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class Attack:
    """What is attacked, and how accepted mutants are put to the test.

    Attributes:
        originals: valid certificates.
        oracle: fails where a claim of a certificate is seen to be false.
        forgers: which ones are at work.
        sees_evidence: whether the oracle looks at the evidence too.  What it looks at is put to the test once.
    """

    originals: Callable[[], Sequence[Record]]
    oracle: Oracle
    forgers: tuple[Forger, ...] = (at_random, claiming)
    sees_evidence: bool = False

    def seen(self, certificate: Record) -> str:
        """What the oracle looks at."""
        part = [certificate["statement"], certificate["evidence"] if self.sees_evidence else None]
        return json.dumps(part, sort_keys=True)


@dataclass
class Outcome:
    """What became of mutants: how many were rejected and accepted, how many claims were put to the test and held."""

    rejected: int = 0
    accepted: int = 0
    tested: int = 0
    false: list[str] = field(default_factory=list)

    def __str__(self) -> str:
        counts = f"{self.rejected} rejected, {self.accepted} accepted"
        return f"{counts}, {self.tested} other claims put to the test, {len(self.false)} of them false"


def run(attack: Attack, number: int, seed: int, most_false: int = 10) -> Outcome:
    """Attack the checker with so many mutants, which differ from their originals.

    Args:
        attack: originals, forgers and oracle.
        number: of mutants.
        seed: of all choices.
        most_false: false ones after which the attack ends.
    """
    source, found, originals = random.Random(seed), Outcome(), attack.originals()
    texts = [json.dumps(own) for own in originals]
    known = {attack.seen(own) for own in originals}
    while found.rejected + found.accepted < number and len(found.false) < most_false:
        k = source.randrange(len(originals))
        forged = source.choice(attack.forgers)(originals[k], source)
        if forged is None:
            found.rejected += 1
        elif json.dumps(forged) != texts[k]:
            _put_to_the_test(attack, forged, source, found, known)
    return found


def _put_to_the_test(attack: Attack, forged: Record, source: random.Random, found: Outcome, known: set[str]) -> None:
    """Ask the checker about a mutant, and the oracle where the checker accepts what was not looked at before."""
    forged, size = as_read(forged)
    refused = refusal(forged, size)
    assert "\n" not in refused, refused
    found.rejected += bool(refused)
    found.accepted += not refused
    if refused or attack.seen(forged) in known:
        return
    known.add(attack.seen(forged))
    found.tested += 1
    try:
        attack.oracle(forged, source)
    except AssertionError as error:
        found.false.append(f"{str(error).splitlines()[:1]}: {json.dumps(forged['statement'])}")
