"""Mutants of certificates: rejected in one line, or true; and each oracle sees what a careless checker would accept."""

from __future__ import annotations

import copy
import json
import random
from dataclasses import replace
from functools import partial

import pytest

from nonsmooth.proofs.checker import statements
from tests.oracles.mutants import Attack, Hand, Record, is_number, leaves, other_numbers, run
from tests.proofs import test_second_function as further
from tests.proofs.attacks import ATTACKS, of_ties
from tests.thorough import thorough

FEW = {
    **{
        "ties": 15,
        "further functions": 5,
        "roots": 4,
        "theorem 4": 15,
        "feedback": 3,
        "one state": 10,
        "tolerances": 5,
    },
    **{"irrational numbers": 10, "basin": 8, "basin, searched": 15, "escape": 8, "lyapunov, searched": 12},
    **{"circles, searched": 5, "triangles": 10},
}
SOME, MANY = 25, 10_000


FEWER = {"ties": partial(of_ties, 1), "further functions": partial(further.originals, 1)}


def attack_of(name: str) -> Attack:
    """An attack, with fewer originals where they take time."""
    return replace(ATTACKS[name], originals=FEWER.get(name, ATTACKS[name].originals))


@pytest.mark.parametrize("name", ATTACKS)
def test_mutants_are_rejected_or_true(name: str) -> None:
    found = run(attack_of(name), FEW.get(name, SOME), seed=1)
    assert not found.false
    assert found.rejected


@thorough  # the test above tries fewer
@pytest.mark.parametrize("name", ATTACKS)
def test_many_mutants_are_rejected_or_true(name: str) -> None:
    """Some are accepted."""
    found = run(ATTACKS[name], MANY, seed=2)
    print(f"{name}: {found}")
    assert not found.false
    assert found.accepted
    assert found.rejected


@pytest.mark.parametrize("name", [name for name in ATTACKS if "searched" not in name and name != "further functions"])
def test_oracles_see_what_is_claimed_falsely(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A checker that believes every claim that is well formed: the oracle contradicts one."""
    monkeypatch.setattr(statements, "not_among", lambda shown, claims: [])
    attack = replace(attack_of(name), forgers=(other_claim,))
    assert run(attack, 300, seed=3, most_false=1).false


def test_the_oracle_of_further_functions_sees_another_system() -> None:
    """Without friction V is not lost; this oracle looks at the system rather than at words."""
    (record,) = further.originals(1)
    further.assert_true(record, random.Random(1))
    (rhs,) = record["statement"]["subject"]["rhs"]
    rhs[1] = rhs[1].replace("y**3", "0")
    with pytest.raises(AssertionError):
        further.assert_true(record, random.Random(1))


def other_claim(original: Record, source: random.Random) -> Record:
    """A certificate of which one word or number of a claim is another one of its kind."""
    found = copy.deepcopy(original)
    claim = source.choice(found["statement"]["claims"])
    ((kind, about),) = claim.items()
    numbers = [(own, key) for own, key in leaves(claim) if isinstance(own[key], str) and is_number(own[key])]
    if isinstance(about, str) and kind in OTHER:
        claim[kind] = source.choice([word for word in OTHER[kind] if word != about])
    elif numbers:
        own, key = source.choice(numbers)
        own[key] = source.choice(other_numbers(own[key], source))
    return found


OTHER = {
    "stability": ("asymptotically stable", "stable", "unstable"),
    "translation": ("asymptotically stable", "stable", "unstable"),
    "rotation": ("unstable", "stable, not attractive"),
    "feedback": ("stabilizable", "no certificate", "not applicable"),
    "theorem 4": ("holds", "fails", "hypotheses not met"),
}


EVERY = {"states": ["x", "y"], "rhs": [["-x + 1/2", "y"]], "at": ["0", "3"], "flags": [True, None, 7, {}]}


def test_a_hand_changes_something_of_every_kind() -> None:
    """Every change happens, keeps what is JSON, and leaves documents without a place for it as they are."""
    for change in {change.__name__ for change in Hand(random.Random(0), "xy").any}:
        texts = set[str]()
        for seed in range(40):
            document, hand = copy.deepcopy(EVERY), Hand(random.Random(seed), "xy")
            hand.change(document, [getattr(hand, change)])
            texts.add(json.dumps(document))
            hand.change([], [getattr(hand, change)])
        assert len(texts - {json.dumps(EVERY)}) > 1, change
