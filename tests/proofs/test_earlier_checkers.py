"""The checkers of version 1, which share no code with the new one, accept what it accepts, where they have words."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import pytest

import nonsmooth as ns
from nonsmooth.proofs.kernel.subject import NoCertificateError
from nonsmooth.proofs.system_certificates import certificate_of
from nonsmooth.proofs.system_decision import StabilityResult, decide_system
from tests.certificates.corpus import good_arrays, good_certificates
from tests.oracles import earlier
from tests.oracles.earlier import NoWordError
from tests.oracles.earlier_arrays import earlier_array, refusal_of_version_1
from tests.proofs.system_families import families
from tests.proofs.test_known_systems import KNOWN, build
from tests.proofs.test_known_systems import system_of as planar
from tests.proofs.test_second_checker import ONE_STATE
from tests.thorough import few, keep

# What the checkers of version 1 do not show of a certificate, word for word, and why that is no contradiction.
NOT_SHOWN: Mapping[str, str] = {
    # The formulas switch on curves; version 1 takes lines in two states.
    "parabola far away": "switching expressions that are products of lines",
    "parabola": "switching expressions that are products of lines",
    "circle": "switching expressions that are products of lines",
    "bang-bang, curved line 1": "switching expressions that are products of lines",
    "bent": "a proof within the limits of this checker",
    "tanh": "calls of sign, Abs, Max, Min, relu or sat",  # it knows no enclosed functions
    # The rates are not shown by halves of cells within its limits of work; without them version 1 accepts these.
    "two relays on skew lines": "V' below its bound on every cell",
    "buck converter": "V' below its bound on every cell",
    "two genes that repress themselves": "V' below its bound on every cell",
}
# Theorems and hypotheses that version 1 has no words for; each is refused with these words alone.
NO_WORDS = {
    "theorem approach",
    "theorem basin",
    "theorem circles",
    "theorem escape",
    "theorem outside",
    "theorem homogeneous",
    "departure in two states",
    "instability by two functions",
    "claims below a level alone",
    "instability by a V of both signs in two states",
    "instability asked where V is not positive alone",
    "further functions in three states and more",
    "V by pieces in three states and more",
    "the whole space as the domain",
    "empty patterns by other evidence than mixtures",
    "roots in one state",
    "irrational numbers",
    "sines and cosines",
    "theorem choice",
    "theorem cascade",
    "theorem sliding",
    "theorem reversible",
    "theorem integral",
    "a V with a denominator",
    "functions of roots of states",
    "algebraic rates",
    "surfaces and pieces without a common point",
}
PLANAR = {known.name: known for known in families()}
FIRST = [
    *("relay, viscous 1", "crossed relays, contracting", "twisting 2, 1", "Coulomb friction", "parabola far away"),
    *("weak focus, cubic growth", "flower"),
]


def why_not(certificate: Any) -> str:
    """What the checker of version 1 says of a certificate of version 2; empty where it accepts it."""
    try:
        return earlier.refusal(earlier.translated(certificate))
    except NoWordError as error:
        assert earlier.earlier(certificate) is None
        return f"no words: {error}"


def require_as_known(name: str, certificate: Any) -> None:
    """Version 1 accepts a certificate, unless it has no words for it or is known not to show it."""
    reason = why_not(certificate)
    if name in NOT_SHOWN:
        assert reason == NOT_SHOWN[name]
    else:
        assert reason == "" or reason.removeprefix("no words: ") in NO_WORDS


def require_agreement(name: str, result: StabilityResult) -> None:
    """Version 1 accepts a certificate, if there is one, unless it has no words for it or is known not to show it."""
    try:
        certificate = certificate_of(result)
    except NoCertificateError:
        return  # which verdicts have a certificate other tests say
    require_as_known(name, json.loads(json.dumps(certificate)))


@few(1)
@pytest.mark.parametrize("name", keep(3, [*FIRST, *(name for name in PLANAR if name not in FIRST)]))
def test_planar_systems(name: str) -> None:
    require_agreement(name, decide_system(planar(PLANAR[name])))


@few(2)
@pytest.mark.parametrize(
    "number", keep(4, [2, 3, 8, 0, 7, *(k for k in range(len(KNOWN)) if k not in (0, 2, 3, 7, 8))])
)
def test_systems_in_three_to_six_states(number: int) -> None:
    require_agreement(str(number), decide_system(build(KNOWN[number])))


@pytest.mark.parametrize("rhs", ONE_STATE)
def test_systems_in_one_state(rhs: str) -> None:
    require_agreement(rhs, decide_system(ns.System(["x"], [rhs]).system))


@pytest.mark.parametrize("start", keep(1, range(12)))
def test_the_corpus(start: int) -> None:
    """Certificates of all theorems, in one to eight states."""
    for name in list(good_certificates())[start::12]:
        require_as_known(name, good_certificates()[name])


# ---- arrays --------------------------------------------------------------------------------------

WITHOUT_WORDS = {"array-omni-3-nearest", "array-mecanum-4-nearest"}  # rows without friction


@pytest.mark.parametrize("every", keep(1, [4, 1]))
def test_which_arrays_version_1_has_words_for(every: int) -> None:
    names = {*list(good_arrays())[::every], *WITHOUT_WORDS}
    assert {name for name in names if earlier_array(good_arrays()[name]) is None} == WITHOUT_WORDS


@pytest.mark.parametrize("start", keep(1, range(48)))
def test_arrays_of_the_corpus(start: int) -> None:
    words = {name: record for name, record in good_arrays().items() if name not in WITHOUT_WORDS}
    assert not [name for name in list(words)[start::48] if refusal_of_version_1(words[name])]
