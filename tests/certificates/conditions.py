"""Forged certificates that one condition of the checker refuses, and no other one: each says with which words.

A checker that lacks the condition accepts them.  Of what they state most is false; some are true and not shown, or
have a form that the specification does not allow.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from itertools import product
from typing import Any

from tests.certificates.forgeries import Forgery, Record

PLAIN: Record = {"mixture": [{}]}  # evidence of what holds with no guard
ON_PARTS: Record = {"simplices": [{}, {}]}  # the same in one state, on both halves of the cube, or of the line
FALLS: Record = {"V ": ON_PARTS, "cell  field 0": ON_PARTS}
STABLE: Record = {"stability": "stable"}
ATTRACTS: Record = {"stability": "asymptotically stable"}
UNSTABLE: Record = {"stability": "unstable"}
EVERYWHERE: Record = {"attracts": "everywhere"}
NO_FUNCTIONS: Record = {"functions": [], "zeros": {}}


def cube(within: str | None) -> Record:
    """Cells without surfaces."""
    return {"within": within, "surfaces": [], "empty": []}


def of_one_state(
    because: str, rhs: str, claims: list[Record], proofs: Record, hypotheses: Record, theorem: str = "lyapunov"
) -> Forgery:
    """A forged certificate about ``x' = rhs``; of theorem ``lyapunov`` with V = x**2 if nothing else is said."""
    own: Record = {"cells": cube("1"), "function": "x**2", "second": None}
    if theorem == "lyapunov":
        own |= {"verdict": "asymptotically stable", "everywhere": False, "level": None, "below": False, "rate": None}
    data = {
        "version": "nonsmooth-certificate/2",
        "statement": {"subject": {"states": ["x"], "rhs": [[rhs]], "at": ["0"]}, "claims": claims},
        "evidence": [{"theorem": theorem, "hypotheses": {**own, **hypotheses}, "proofs": proofs}],
    }
    return Forgery("one condition", text=((json.dumps(data, separators=(",", ":")), 1),), because=because)


def of_lyapunov() -> Iterator[Forgery]:
    """Verdicts, starts that attract and rates that theorem ``lyapunov`` does not show."""
    yield of_one_state("a verdict", "-x", [UNSTABLE], FALLS, {"verdict": "unstable"})
    for key in ("everywhere", "below"):
        yield of_one_state("everywhere and below as true or false", "-x", [ATTRACTS], FALLS, {key: 0})
    words = "further functions where the point attracts"
    yield of_one_state(words, "-x", [STABLE], FALLS, {"verdict": "stable", "second": NO_FUNCTIONS})

    rests = {"V ": ON_PARTS, "cell  field 0": PLAIN}
    borders = {"border  +0": PLAIN, "border  -0": PLAIN}
    stable = {"verdict": "stable"}
    words = "an attracting point"
    yield of_one_state(words, "0", [STABLE, EVERYWHERE], rests, {**stable, "everywhere": True})
    words = "a positive level around a point that attracts"
    about = {"function": "x**2", "within": "1"}
    level = {"attracts": {**about, "below": "1"}}
    yield of_one_state(words, "0", [STABLE, level], {**rests, **borders}, {**stable, "level": "1"})
    in_space = {"attracts": {**about, "within": None, "below": "1"}}
    yield of_one_state(words, "-x", [ATTRACTS, in_space], {**FALLS, **borders}, {"cells": cube(None), "level": "1"})
    nothing = {"attracts": {**about, "below": "-1"}}
    yield of_one_state(words, "-x", [ATTRACTS, nothing], {**FALLS, **borders}, {"level": "-1"})
    words = "cones and forms, for the whole space"
    yield of_one_state(words, "x**3 - x", [ATTRACTS, EVERYWHERE], FALLS, {"cells": cube("1/2"), "everywhere": True})

    rated = {**FALLS, "rate cell  field 0": ON_PARTS}
    for rate in ({"kind": "exponential", "kappa": "-1"}, {"kind": "hyperbolic", "kappa": "1"}):
        claims: list[Record] = [ATTRACTS, {"rate": {**about, **rate}}]
        yield of_one_state("a positive rate, finite or exponential", "-x", claims, rated, {"rate": rate})
    rate = {"kind": "exponential", "kappa": "1"}
    claims = [ATTRACTS, {"rate": {**about, **rate}}, {"gain": {**about, **rate, "gamma": "-3"}}]
    yield of_one_state("a positive gain", "-x", claims, {**rated, "gradient ": ON_PARTS}, {"rate": rate, "gain": "-3"})


def of_gain() -> Iterator[Forgery]:
    """A gain where V bends on several surfaces at once: ``|x| + |y| + |z|`` for speeds 1, 2 and 3."""
    rate = {"kind": "finite", "kappa": "1"}
    hypotheses = {"rate": rate, "gain": "2"}
    proofs: Record = {}
    for signs in product("+-0", repeat=3):
        name, zeros = "".join(signs), signs.count("0")
        left = sum(k for k, sign in enumerate(signs, 1) if sign != "0") - 1
        still = [0] * (3 - zeros)
        square = {"guards": [], "monomials": [still], "gram": [[str(left)]]}
        shown = {"squares": [[square]] * 2**zeros, "mu": [[["-1", still]]] * zeros}
        if zeros in (1, 2):
            proofs[f"rate face {name}"] = shown
        elif not zeros:
            proofs |= {f"rate cell {name} field 0": shown, f"gradient {name}": PLAIN}
    claim = {"function": "Abs(x) + Abs(y) + Abs(z)", "within": "1", **rate}
    changes: list[Any] = [(["evidence", 0, "hypotheses", key], own) for key, own in hypotheses.items()]
    changes += [(["evidence", 0, "proofs", name], own) for name, own in proofs.items()]
    changes += [
        (["statement", "claims", 1], {"rate": claim}),
        (["statement", "claims", 2], {"gain": {**claim, "gamma": "2"}}),
    ]
    words = "surfaces on which V bends that meet at the point alone"
    yield Forgery("one condition", "relays-3", tuple(changes), because=words)


def of_quotients() -> Iterator[Forgery]:
    """Denominators for which V is not zero at the point, or claims of V that are claims of P."""
    proofs = {"denominator": ON_PARTS, **FALLS}
    rate = {"kind": "exponential", "kappa": "200"}  # times 100
    claims: list[Record] = [ATTRACTS, {"rate": {"function": "x**2", "within": "1", "denominator": "100", **rate}}]
    words = "a quotient without further functions and rates"
    rated = {**proofs, "rate cell  field 0": PLAIN}
    yield of_one_state(words, "-x", claims, rated, {"denominator": "100", "rate": rate})
    yield of_one_state(words, "-x", [ATTRACTS], proofs, {"denominator": "100", "second": NO_FUNCTIONS})

    words = "a V that is zero at the point"
    rests = {**proofs, "cell  field 0": PLAIN}
    yield of_one_state(words, "x", [STABLE], rests, {"verdict": "stable", "denominator": "x**2"})
    words = "a denominator that is a form, or positive at the point"
    yield of_one_state(words, "-x", [ATTRACTS], proofs, {"function": "x**6", "denominator": "x**2 + x**4"})


def of_proper() -> Iterator[Forgery]:
    """Functions V that do not grow, said to show that all starts tend to the point."""
    yield of_one_state("a proper V for all starts", "-x", [ATTRACTS], FALLS, {"proper": "1"})
    claims = [ATTRACTS, EVERYWHERE]
    bounded = {"cells": cube(None), "denominator": "1 + x**2", "everywhere": True}
    one = {"squares": [[{"guards": [], "monomials": [[0], [1]], "gram": [["1"], ["0", "1"]]}]]}
    proofs = {**FALLS, "denominator": one}
    yield of_one_state("a proof of proper ", "-x", claims, proofs, {"proper": "1", **bounded})
    words = "the whole space, and a positive factor"
    yield of_one_state(words, "-x", claims, {**proofs, "proper ": ON_PARTS}, {"proper": "-1", **bounded})
    within = {"cells": cube("1/2"), "everywhere": True, "proper": "1"}
    yield of_one_state(words, "x**3 - x", claims, {**FALLS, "proper ": ON_PARTS}, within)


def of_instability() -> Iterator[Forgery]:
    """Functions V from which no solution need flee."""

    def unstable(because: str, rhs: str, proof: Record, **hypotheses: Any) -> Forgery:
        proofs = {"cell  field 0": proof} if proof else {}
        return of_one_state(because, rhs, [UNSTABLE], proofs, {"direction": ["1"], **hypotheses}, "instability")

    yield unstable("a V that is zero at the point", "-x", ON_PARTS, function="x**2 - 2")
    yield unstable("a cube", "x", ON_PARTS, function="-(x**2)", cells=cube(None))
    words = "a positive speed, and no further functions"
    yield unstable(words, "-x**3/2", PLAIN, function="-(x**2)", speed="-1")
    yield unstable(words, "x**3/2", PLAIN, function="-(x**2)", speed="1", second=NO_FUNCTIONS)
    yield unstable("a proof of cell  field 0", "-x**3", {}, function="-(x**2)", speed="1")


def of_roots() -> Iterator[Forgery]:
    """A rate in another time than that of the states."""
    rate = {"kind": "exponential", "kappa": "2"}
    claim = {"rate": {"function": "root_x**2", "within": "1", "in": ["root_x"], **rate}}
    changes: list[Any] = [
        (["statement", "claims", 1], claim),
        (["evidence", 0, "hypotheses", "cells", "within"], "1"),
        (["evidence", 0, "hypotheses", "rate"], rate),
        *((["evidence", 0, "proofs", f"rate cell {sign} field 0"], PLAIN) for sign in "+-"),
    ]
    yield Forgery("one condition", "root-plain", tuple(changes), because="rates in the time of the states")


def conditions() -> Iterator[Forgery]:
    """All of them."""
    for kind in (of_lyapunov, of_gain, of_quotients, of_proper, of_instability, of_roots):
        yield from kind()
