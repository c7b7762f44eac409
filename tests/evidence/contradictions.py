"""Does the comparison of what is printed ever fire on a right verdict?  Arrays in exact numbers, under every rule.

Exact numbers leave nothing to rounding, so a contradiction is a wrong verdict, a wrong sample or a comparison that is
wrong itself.  Four families: opposite wheels alike on a circle (the point is an equilibrium), rings with rims turned by
one angle or pointing outward, arrays tied at the point on purpose (:mod:`tests.oracles.tied_arrays`), and arrays at
random, checked at a point that is seldom an equilibrium.

    .venv/bin/python -m tests.evidence.contradictions [FIRST [LAST]]
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction

import numpy as np

from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.proofs.answers.answers import full_answers
from nonsmooth.proofs.answers.contradictions import reconciled
from nonsmooth.proofs.findings import Contradiction
from nonsmooth.proofs.theorem4 import check_theorem4
from nonsmooth.symbolic.mechanics.rule import CONTACT_RULES
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.scene_error import SceneError
from tests.conftest import Arrays, Pair, WheelData
from tests.oracles.tied_arrays import scene_of, tied_array

ARRAYS = Arrays()
TURNS = (Fraction(0), Fraction(1, 7), Fraction(-1, 3), Fraction(1), Fraction(3), Fraction(1, 50))


def cocircular(seed: int) -> Scene:
    """Opposite wheels alike."""
    return ARRAYS.cocircular(seed)


def turned_ring(seed: int) -> Scene:
    """A square or two of wheels, rims turned by one rational angle from inward to outward, some driven backwards."""
    rng = np.random.default_rng(seed)
    turn = ARRAYS.circle_point(TURNS[rng.integers(len(TURNS))])
    far = Fraction(3, 2)
    corners: list[Pair] = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
    more: list[Pair] = [(far, 0), (0, far), (-far, 0), (0, -far)]
    positions = corners + (more if rng.random() < 0.3 else [])
    wheels = ARRAYS.inward(positions, turn, int(rng.choice([1, -1])))
    if rng.random() < 0.4:  # a saddle
        wheels = [WheelData(w.position, (w.direction[0], -w.direction[1]), w.speed) for w in wheels]
    friction = ((1, Fraction(1, 2)), (Fraction(1, 2), 1), (1, 1), (1, Fraction(1, 20)))[rng.integers(4)]
    return ARRAYS.scene(wheels, friction)


def tied(seed: int) -> Scene:
    """Coincidences at the point."""
    return scene_of(ARRAYS, tied_array(seed)[0])


def anywhere(seed: int) -> Scene:
    """Checked at a point that is seldom an equilibrium."""
    return ARRAYS.random(seed, 3 + seed % 4)


FAMILIES: dict[str, Callable[[int], Scene]] = {
    family.__name__: family for family in (cocircular, turned_ring, tied, anywhere)
}


def compared(scene: Scene) -> tuple[str, tuple[Contradiction, ...]] | None:
    """The position's answer, and the contradictions in all that a check prints; None where it is refused."""
    try:
        check = check_theorem4(scene)
        answered = full_answers(check)
    except (RefusalError, SceneError):
        return None
    return str(answered.answers[0].verdict), reconciled(check, answered)[0].contradictions


def study(name: str, seeds: range, rules: tuple[str, ...] = tuple(CONTACT_RULES)) -> Iterator[tuple[int, str, str]]:
    """Each array of a family under each rule: seed, rule, and answer or contradiction."""
    for seed in seeds:
        for rule in rules:
            scene = FAMILIES[name](seed)
            found = compared(replace(scene, contact=replace(scene.contact, rule=rule)))
            if found is None:
                yield seed, rule, "refused"
            else:
                yield seed, rule, "; ".join(one.text for one in found[1]) or found[0]


def main(first: int = 0, last: int = 25) -> None:
    """Count the answers of every family; print each contradiction."""
    for name in FAMILIES:
        counted: Counter[tuple[str, str]] = Counter()
        for seed, rule, said in study(name, range(first, last)):
            if "contradict" in said:
                print(f"{name} {seed} {rule}: {said}", flush=True)
            counted[rule, "contradiction" if "contradict" in said else said] += 1
        for (rule, said), count in sorted(counted.items()):
            print(f"{name:12} {rule:8} {said:14} {count:5}", flush=True)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
