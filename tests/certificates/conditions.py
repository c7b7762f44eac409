"""Forged certificates that one condition of the checker refuses, and no other one: each says with which words.

A checker that lacks the condition accepts them.  Of what they state most is false; some are true and not shown, or
have a form that the specification does not allow.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from itertools import permutations, product
from typing import Any

from nonsmooth.proofs.checker.roots import read_subject
from nonsmooth.proofs.kernel.search import NotShownError, Search
from tests.certificates.corpus import good_certificates
from tests.certificates.forgeries import GONE, Forgery, Path, Record

PLAIN: Record = {"mixture": [{}]}  # evidence of what holds with no guard
ON_PARTS: Record = {"simplices": [{}, {}]}  # the same in one state, on both halves of the cube, or of the line
FALLS: Record = {"V ": ON_PARTS, "cell  field 0": ON_PARTS}
STABLE: Record = {"stability": "stable"}
ATTRACTS: Record = {"stability": "asymptotically stable"}
UNSTABLE: Record = {"stability": "unstable"}
NOWHERE: Record = {"V ": PLAIN, "cell  field 0": PLAIN}
EVERYWHERE: Record = {"attracts": "everywhere"}
NO_FUNCTIONS: Record = {"functions": [], "zeros": {}}


def cube(within: str | None) -> Record:
    """Cells without surfaces."""
    return {"within": within, "surfaces": [], "empty": []}


def of_subject(
    because: str, subject: Record, claims: list[Record], theorem: str, hypotheses: Record, proofs: Any
) -> Forgery:
    """A forged certificate of one theorem."""
    data = {
        "version": "nonsmooth-certificate/2",
        "statement": {"subject": subject, "claims": claims},
        "evidence": [{"theorem": theorem, "hypotheses": hypotheses, "proofs": proofs}],
    }
    return Forgery("one condition", text=((json.dumps(data, separators=(",", ":")), 1),), because=because)


def of_one_state(
    because: str,
    rhs: str,
    claims: list[Record],
    proofs: Any,
    hypotheses: Record,
    theorem: str = "lyapunov",
    subject: Record | None = None,
) -> Forgery:
    """A forged certificate about ``x' = rhs``; of theorem ``lyapunov`` with V = x**2 if nothing else is said."""
    own: Record = {"cells": cube("1")}
    if theorem != "departure":
        own |= {"function": "x**2", "second": None}
    if theorem == "lyapunov":
        own |= {"verdict": "asymptotically stable", "everywhere": False, "level": None, "below": False, "rate": None}
    about = subject or {"states": ["x"], "rhs": [[rhs]], "at": ["0"]}
    return of_subject(because, about, claims, theorem, {**own, **hypotheses}, proofs)


def of_lyapunov() -> Iterator[Forgery]:
    """Verdicts, starts that attract and rates that theorem ``lyapunov`` does not show."""
    yield of_one_state("a verdict", "-x", [UNSTABLE], FALLS, {"verdict": "unstable"})
    for key in ("everywhere", "below"):
        yield of_one_state("everywhere and below as true or false", "-x", [ATTRACTS], FALLS, {key: 0})
    yield of_one_state("rational numbers as texts such as '-3/4'", "-x", [ATTRACTS], FALLS, {"below": True})
    words = "further functions where the point attracts"
    yield of_one_state(words, "-x", [STABLE], FALLS, {"verdict": "stable", "second": NO_FUNCTIONS})

    # x' = x in coordinates whose velocities have the other sign; and more than a verdict, which is of no cube of x
    turned: Record = {"cells": {**cube("1"), "frame": [[["1"]], [["-1"]]]}}
    yield of_one_state("a frame of two matrices whose product is one", "x", [ATTRACTS], FALLS, turned)
    # maps of which one does not undo the other; that leave the point; and two descriptions of coordinates
    bent = {"cells": {**cube("1"), "coordinates": [["x"], ["-x"]]}}
    yield of_one_state("two maps of which one undoes the other", "x", [ATTRACTS], FALLS, bent)
    moved: Record = {"cells": {**cube("1/2"), "coordinates": [["x + 1"], ["x - 1"]]}}
    yield of_one_state("coordinates that are zero at the point", "x - x**2", [ATTRACTS], FALLS, moved)
    both: Record = {"cells": {**cube("1"), "frame": [[["1"]], [["1"]]], "coordinates": [["x"], ["x"]]}}
    yield of_one_state("a frame, or other coordinates", "-x", [ATTRACTS], FALLS, both)
    wide: Record = {"cells": {**cube("1"), "frame": [[["1/2"]], [["2"]]]}, "level": "1/4"}
    region = {"attracts": {"function": "x**2", "within": "1", "below": "1/4"}}
    more = {**FALLS, "border  +0": PLAIN, "border  -0": PLAIN}
    yield of_one_state("a verdict alone in a frame", "-x + 2*x**3", [ATTRACTS, region], more, wide)

    rests = {"V ": ON_PARTS, "cell  field 0": PLAIN}
    borders = {"border  +0": PLAIN, "border  -0": PLAIN}
    stable = {"verdict": "stable"}
    yield of_one_state("a mixture that is not negative, for V ", "x", [STABLE], NOWHERE, {**stable, "function": "0"})
    words = "an attracting point"
    yield of_one_state(words, "0", [STABLE, EVERYWHERE], rests, {**stable, "everywhere": True})
    words = "a positive level around a point that attracts"
    about = {"function": "x**2", "within": "1"}
    level = {"attracts": {**about, "below": "1"}}
    yield of_one_state(words, "0", [STABLE, level], {**rests, **borders}, {**stable, "level": "1"})
    in_space = {"attracts": {**about, "within": None, "below": "1"}}
    yield of_one_state(words, "-x", [ATTRACTS, in_space], {**FALLS, **borders}, {"cells": cube(None), "level": "1"})
    nothing = {"attracts": {**about, "below": "0"}}
    yield of_one_state(words, "-x", [ATTRACTS, nothing], {**FALLS, **borders}, {"level": "0"})
    words = "cones and forms, for the whole space"
    yield of_one_state(words, "x**3 - x", [ATTRACTS, EVERYWHERE], FALLS, {"cells": cube("1/2"), "everywhere": True})

    halves: Record = {"V .": ON_PARTS, "cell + field 0": {"simplices": [{}, {"on": ["s0"]}]}}
    halves["cell - field 0"] = {"simplices": [{"on": ["s0"]}, {}]}
    half: Record = {"cells": {**cube("1/2"), "surfaces": ["x"]}, "everywhere": True}
    yield of_one_state(words, "-x + x**3*(1 + sign(x))/2", [ATTRACTS, EVERYWHERE], halves, half)

    rated = {**FALLS, "rate cell  field 0": ON_PARTS}
    for rate in ({"kind": "exponential", "kappa": "0"}, {"kind": "hyperbolic", "kappa": "1"}):
        claims: list[Record] = [ATTRACTS, {"rate": {**about, **rate}}]
        yield of_one_state("a positive rate, finite, exponential or algebraic", "-x", claims, rated, {"rate": rate})
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
    zero = {**proofs, "denominator": PLAIN, "cell  field 0": PLAIN}
    own = {"verdict": "stable", "denominator": "0"}
    yield of_one_state("a mixture that is not negative, for denominator", "x", [STABLE], zero, own)
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
    yield of_one_state("a proper V for all starts", "-x", [ATTRACTS], FALLS, {"growth": "1"})
    yield of_one_state("a proof of proper  +0", "-x", claims, proofs, {"growth": "1", **bounded})
    # V = x**2 + ln(1 - x), which is negative; and one with a rate, of which nothing is known
    words = "a mixture that is not negative, for logarithm"
    yield of_one_state(words, "-x", [ATTRACTS], {**FALLS, "logarithm": PLAIN}, {"logarithm": "-x"})
    level: Record = {"logarithm": "x**2", "level": "3/2"}  # of V, which is x**2 + ln(1 + x**2), on the border
    region = {"attracts": {"function": "x**2", "within": "1", "below": "3/2"}}
    proofs = {**FALLS, "border  +0": PLAIN, "border  -0": PLAIN, "logarithm": ON_PARTS, "beside ": ON_PARTS}
    yield of_one_state("a logarithm with a verdict alone", "-x", [ATTRACTS, region], proofs, level)


def of_instability() -> Iterator[Forgery]:
    """Functions V from which no solution need flee."""

    def unstable(because: str, rhs: str, proof: Record, **hypotheses: Any) -> Forgery:
        names = ["cell + field 0", "cell - field 0"] if "cells" in hypotheses else ["cell  field 0"]
        proofs = dict.fromkeys(names, proof) if proof else {}
        return of_one_state(because, rhs, [UNSTABLE], proofs, {"direction": ["1"], **hypotheses}, "instability")

    yield unstable("a V that is zero at the point", "-x", ON_PARTS, function="x**2 - 2")
    words = "a V that is negative in the direction"
    yield unstable(words, "-x", ON_PARTS, function="x**2")
    yield unstable(words, "-sign(x)", PLAIN, function="Abs(x)", cells={**cube("1"), "surfaces": ["x"]})
    yield unstable("a mixture that is not negative, for cell  field 0", "0", PLAIN, function="-(x**2)")
    outward = {"cells": {**cube(None), "surfaces": ["x"]}, "function": "-Abs(x)"}
    yield unstable("a cube", "sign(x)", PLAIN, **outward)
    words = "a positive speed, and no further functions"
    yield unstable(words, "-x**3/2", PLAIN, function="-(x**2)", speed="-1")
    yield unstable(words, "0", PLAIN, function="-(x**2)", speed="0")
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

    # x' = -2 x, unstable by V = root_x, if 2 x = 2 w Abs(w) had the same terms on both sides of zero
    subject = {"states": ["x"], "rhs": [["-2*x"]], "at": ["0"], "roots": ["x"]}
    own = {"cells": {**cube("1/2"), "surfaces": ["root_x"]}, "function": "root_x", "direction": ["-1"]}
    proofs = {f"cell {sign} field 0": ON_PARTS for sign in "+-"}
    words = "coefficients that are not negative, for cell - field 0"
    yield of_one_state(words, "", [UNSTABLE], proofs, own, theorem="instability", subject=subject)


def of_other_roots() -> Iterator[Forgery]:
    """A state that stays where its root is zero, so that the other one grows: ``x' = -sign(x), y' = y``."""
    halves: list[Record] = [{}] * 4 + [{"on": ["s0"]}] * 4
    proofs: Record = {"V .": {"simplices": [{}] * 8}, "cell + field 0": {"simplices": halves}}
    proofs["cell - field 0"] = {"simplices": halves[::-1]}
    subject = {"states": ["x", "y"], "rhs": [["-sign(x)", "y"]], "at": ["0", "0"], "roots": ["x"]}
    hypotheses = {"cells": {**cube("1/2"), "surfaces": ["root_x"]}, "function": "root_x**2 + y**2", "verdict": "stable"}
    own = of_one_state("a proof of crosses 0 speeds 0 0", "", [STABLE], proofs, hypotheses, subject=subject)
    yield own


def of_functions_of_roots() -> Iterator[Forgery]:
    """A V about roots of states that says nothing, what is not stated beside it, and times of arrival."""
    slides = {"states": ["x", "y"], "rhs": [["-10*sign(x)", "-y"]], "at": ["0", "0"]}
    hypotheses: Path = ["evidence", 0, "hypotheses"]
    because = "orders of roots by the names of states"
    yield Forgery("one condition", "roots-third", (([*hypotheses, "roots"], ["x"]),), because=because)
    because = "a cube, or a box of roots in the time of the states"
    yield of_one_state(because, "-x", [ATTRACTS], FALLS, {"cells": {**cube("1"), "within": ["1"]}})
    because = "names of roots that are no states"
    named = {"states": ["x", "root_x"], "rhs": [["-x", "-root_x"]], "at": ["0", "0"]}
    yield of_one_state(because, "", [ATTRACTS], FALLS, {"roots": {"x": 3}}, subject=named)
    number = {"name": "root_x", "polynomial": ["-2", "0", "1"], "above": "0"}
    numbered = {"states": ["x"], "rhs": [["-x"]], "at": ["0"], "numbers": [number]}
    yield of_one_state(
        "names of numbers that are no roots", "", [ATTRACTS], FALLS, {"roots": {"x": 3}}, subject=numbered
    )
    because = "a verdict and a time of arrival in roots"
    yield Forgery("one condition", "roots-third", (([*hypotheses, "level"], "1"),), because=because)
    because = "a verdict alone in roots"
    yield Forgery("one condition", "roots-leave", (([*hypotheses, "speed"], "1"),), because=because)
    arrival = {"size": ["1"], "above": "1", "speed": "1", "power": 1}
    yield of_one_state("a time of arrival in roots", "-x", [ATTRACTS], FALLS, {"arrival": arrival, "everywhere": True})
    for because, key, value in (
        ("a time of arrival of positive numbers", "speed", "-1"),
        ("a time of arrival of positive numbers", "size", ["0"]),
        ("a time of arrival with a positive power", "power", 0),
    ):
        yield Forgery("one condition", "roots-arrive", (([*hypotheses, "arrival", key], value),), because=because)

    bent: Any = ([*hypotheses, "function"], "root_x**2 + root_x**4")
    yield Forgery("one condition", "roots-arrive", (bent,), because="a V of forms of one degree")

    def unshown(because: str, function: str, order: int, rhs: list[str], *surfaces: str) -> Forgery:
        """With evidence of all that is asked before what refuses it."""
        own = {**slides, "states": ["x", "y"][: len(rhs)], "rhs": [rhs], "at": ["0"] * len(rhs)}
        falls = {"cells": {**cube("1"), "surfaces": ["root_x", *surfaces]}, "function": function, "roots": {"x": order}}
        known, search = of_one_state(because, "", [ATTRACTS], {}, falls, subject=own), Search()
        hypotheses = json.loads(known.text[0][0])["evidence"][0]["hypotheses"]
        with suppress(NotShownError):
            search.entry(read_subject(own), "lyapunov", hypotheses)
        proofs = {name: evidence for name, (_, evidence) in search.found.items()}
        return of_one_state(because, "", [ATTRACTS], proofs, falls, subject=own)

    # y grows while x stays where Abs(x) bends, whatever the polynomials of V around it
    yield unshown("a proof of face 0", "root_x**2 + y**2", 2, ["-10*sign(x)", "y"])
    yield unshown("a proof of face 0", "Abs(root_x)**3 + y**2", 3, ["-10*sign(x)", "y"])
    yield unshown("a function with a derivative by x", "root_x**2 + y**2", 3, ["-10*sign(x)", "-y"])
    bends = "Abs(root_x)**3 + relu(root_x**3 - 1/64)"
    words = "surfaces that are zeros of roots, or about other states"
    yield unshown(words, bends, 3, ["-2*sign(x) - sign(x - 1/64)"], "root_x**3 - 1/64")


def of_evidence() -> Iterator[Forgery]:
    """Evidence of every kind that shows nothing."""

    def grows(because: str, proof: Record, function: str = "x**2", rhs: str = "x") -> Forgery:
        return of_one_state(because, rhs, [ATTRACTS], {"V ": ON_PARTS, "cell  field 0": proof}, {"function": function})

    square = {"guards": [], "monomials": [[1]], "gram": [["-2"]]}
    yield grows("positive semidefinite matrices", {"squares": [[square]]})
    other = {**square, "gram": [["1"]]}
    yield grows("a sum of squares that is the polynomial of cell  field 0", {"squares": [[other]]})
    resting = {"V ": ON_PARTS, "cell  field 0": PLAIN}
    words = "an affine mixture for cell  field 0"
    yield of_one_state(words, "x", [STABLE], resting, {"verdict": "stable"})
    face: Path = ["evidence", 0, "proofs", "face 0+"]
    words = "multipliers by guard"
    yield Forgery("one condition", "relays-2", ((face, {"mixture": [{}, {}]}),), because=words)
    yield grows("a positive square for cell  field 0", {"squares": [[]]}, rhs="0")
    yield grows("positive coefficients for cell  field 0", ON_PARTS, rhs="0")
    turned = {"simplices": [{"on": [{"d0": "-3"}]}, {"on": [{"u0": "-3"}]}]}
    yield grows("multipliers that are not negative", turned)
    added = {"simplices": [{"on": [{"d0": "3"}]}, {"on": [{"u0": "3"}]}]}
    yield grows("coefficients that are not negative, for cell  field 0", added)
    yield grows("a guard that is negative, for cell  field 0", {"simplices": [{"on": ["u0"]}] * 2})
    flat = {"guards": [], "monomials": [[1]], "gram": [["0"]]}
    yield grows("a positive square for cell  field 0", {"squares": [[flat]]}, rhs="0")
    yield grows("cuts inside an edge", {"simplices": [[0, 1, "2", {}, {}], {}]}, rhs="-x")

    surfaces = {**cube("1"), "surfaces": ["x"]}
    bends: Record = {"V +": {"simplices": [{}, {"on": ["s0"]}]}, "V -": {"simplices": [{"on": ["s0"]}, {}]}}
    grown = {"cell + field 0": {"mixture": [{"d0": "-1"}]}, "cell - field 0": {"mixture": [{"u0": "-1"}]}}
    words = "multipliers of guards, not negative"
    yield of_one_state(words, "x", [ATTRACTS], {**bends, **grown}, {"cells": surfaces, "function": "Abs(x)"})
    rate = {"kind": "finite", "kappa": "1/4"}
    falls = {f"{name}cell {sign} field 0": PLAIN for name in ("", "rate ") for sign in "+-"}
    claims: list[Record] = [ATTRACTS, {"rate": {"function": "Abs(x)", "within": None, **rate}}]
    own: Record = {"cells": {**surfaces, "within": None}, "function": "Abs(x)", "rate": rate}
    words = "a mixture that is bounded for cell + field 0"
    yield of_one_state(words, "x/2 - sign(x)", claims, {**bends, **falls}, own)

    names = [f"x{k}" for k in range(5)]
    subject = {"states": names, "rhs": [[f"-{name}" for name in names]], "at": ["0"] * 5}
    whole: Record = {"simplices": [{}] * 32}
    own = {"cells": cube(None), "function": " + ".join(f"{name}**2" for name in names)}
    proofs = {"V ": whole, "cell  field 0": whole}
    yield of_one_state("simplices in at most 4 variables", "", [ATTRACTS], proofs, own, subject=subject)


def of_squares() -> Iterator[Forgery]:
    """Sums of squares that vanish beside the point, or are none."""
    inside = {"guards": ["s0"], "monomials": [[1]], "gram": [["2"]]}  # x' = 0 at 1/2
    proofs: Record = {"V .": ON_PARTS, "border . +0": PLAIN, "border . -0": PLAIN}
    proofs |= {f"cell {sign} field 0": {"squares": [[inside]]} for sign in "+-"}
    claims = [ATTRACTS, {"attracts": {"function": "x**2", "within": "1", "below": "1"}}]
    own: Record = {"cells": {**cube("1"), "surfaces": ["x - 1/2"]}, "level": "1"}
    words = "a positive square for cell + field 0"
    yield of_one_state(words, "-x*Abs(x - 1/2)", claims, proofs, own)

    eight: Record = {"simplices": [{}] * 8}
    own = {"function": "x**2 + y**2"}
    for because, rhs, verdict, monomials, gram in (
        ("a positive square for cell  field 0", ["-x", "0"], ATTRACTS, [[1, 0]], [["2"]]),
        ("positive semidefinite matrices", ["-y", "-x"], STABLE, [[1, 0], [0, 1]], [["0"], ["2", "0"]]),
    ):
        square = {"guards": [], "monomials": monomials, "gram": gram}
        proofs = {"V ": eight, "cell  field 0": {"squares": [[square]]}}
        subject: Record = {"states": ["x", "y"], "rhs": [rhs], "at": ["0", "0"]}
        stated = {**own, "verdict": verdict["stability"]}
        yield of_one_state(because, "", [verdict], proofs, stated, subject=subject)


def of_pairs() -> Iterator[Forgery]:
    """Pairs of fields that are not looked at, or where several surfaces vanish."""
    proof: Path = ["evidence", 0, "proofs", "face 0+"]
    yield Forgery("one condition", "relays-2", ((proof, {"pairs": [{}, {}]}),), because="evidence of face 0+ pair 0 1")
    shown = []
    for (x, _), (other, _) in permutations(product((1, -1), repeat=2), 2):
        part: Record = {} if x > other else {"on": ["sp" if x < other else "sq" if x > 0 else "sp"]}
        shown.append({"simplices": [part, {"on": ["s2"]}]})
    proof = ["evidence", 0, "proofs", "face 00+"]
    yield Forgery("one condition", "relays-3", ((proof, {"pairs": shown}),), because="one function mu")


def of_further_functions() -> Iterator[Forgery]:
    """Bounds that are negative, and places where all functions stay constant."""

    def bounded(because: str, rhs: str, proof: Record, bound: list[Any]) -> Forgery:
        second = {"functions": [], "zeros": {"cell  field 0": bound}}
        proofs = {"V ": ON_PARTS, "cell  field 0": proof}
        return of_one_state(because, rhs, [ATTRACTS], proofs, {"second": second})

    yield bounded("positive factors of a bound", "0", PLAIN, [["0", [["x", 2]]]])
    yield bounded("even powers, or signed surfaces, in a bound", "-1", PLAIN, [["2", [["x", 1]]]])
    yield bounded("nothing that stays on cell  field 0", "0", PLAIN, [["1", [["0", 2]]]])
    words = "zeros of a bound that can be solved for a variable"  # x' = 0 at 1/2, too
    yield bounded(words, "-x*(1 - 2*x)**2", PLAIN, [["2", [["x - 2*x**2", 2]]]])
    second: Record = {"functions": [], "zeros": []}
    yield of_one_state("bounds by the names of claims", "-x", [ATTRACTS], FALLS, {"second": second})


def of_formulas() -> Iterator[Forgery]:
    """Formulas that Python reads, and that are none of a system."""

    def ahead(because: str, rhs: str) -> Forgery:
        own = {"cells": cube(None), "direction": ["1"]}
        return of_one_state(because, rhs, [UNSTABLE], {}, own, "departure")

    yield ahead("formulas of at most 60 nested operations", "-" * 62 + "1")
    yield ahead("numbers as decimals", "1 + 0*1e-1000")
    yield ahead("whole exponents", "1 + 0*x**+2")
    yield ahead("division by numbers that are not zero", "1/(1 - x)")
    yield ahead("formulas of names, decimals, brackets, commas and + - * /", "1 # x")
    yield ahead("calls of sign, Abs, Max, Min, relu or sat", "foo(2)")
    yield ahead("polynomials of degree at most 40", "1 + x**30*x**30")
    for words, rhs in (
        ("no sine or cosine inside a switching function", "-x + relu(0*sin(x))"),
        ("no sine or cosine inside another", "-x + 0*sin(sin(x))"),
        ("no powers of sines and cosines", "-x + 0*sin(x)**2"),
        ("exp of minus a sum of even powers", "-x + 0*exp(-x**2 + x**4)"),
        ("exp of minus a sum of even powers", "-x + 0*exp(-x**2 + Abs(x))"),
        ("exp of minus a sum of even powers", "-x + 0*exp(-x*Abs(x))"),
        ("switching expressions that are products of the surfaces", "x*sign(2 - x)"),
    ):
        yield of_one_state(words, rhs, [ATTRACTS], FALLS, {})


def of_documents() -> Iterator[Forgery]:
    """Certificates of another form, and without a claim."""
    yield of_one_state("a claim", "-x", [], FALLS, {})
    words = 'evidence of the claim {"attracts": "everywhere"}'
    yield of_one_state(words, "-x", [ATTRACTS, EVERYWHERE], FALLS, {})
    keys = "cells function second verdict everywhere level below rate gain proper growth denominator logarithm"
    yield of_one_state(f"an object with the keys {keys} roots arrival", "-x", [ATTRACTS], FALLS, {"trust": True})
    other: Path = ["version"]
    words = "the version nonsmooth-certificate/2"
    yield Forgery("one condition", "one-linear-1", ((other, "nonsmooth-certificate/3"),), because=words)
    direction = {"cells": cube(None), "direction": ["1.5"]}
    words = "rational numbers as texts such as '-3/4'"
    yield of_one_state(words, "1", [UNSTABLE], {}, direction, "departure")
    yield of_one_state("proofs of claims that are asked", "-x", [ATTRACTS], {**FALLS, "more": PLAIN}, {})
    behind = {"cells": cube(None), "direction": ["1"]}
    words = "a direction in which all velocities at the point lead"
    yield of_one_state(words, "-1", [UNSTABLE], {}, behind, "departure")
    second: Path = ["evidence", 0, "hypotheses", "choice", "second"]
    yield Forgery("one condition", "choice-sides", ((second, -1),), because="a whole number from 0 to 1")


def of_cells() -> Iterator[Forgery]:
    """Systems and cells that are none, or too many."""

    def leaves(because: str, subject: Record, cells: Record | None = None, proofs: Any = None) -> Forgery:
        own = {"states": ["x"], "rhs": [["1"]], "at": ["0"], **subject}
        ahead = {"cells": cells or cube(None), "direction": ["1"] * len(own["states"])}
        return of_one_state(because, "", [UNSTABLE], {} if proofs is None else proofs, ahead, "departure", own)

    nine = {"states": [f"x{k}" for k in range(9)], "rhs": [["1"] * 9], "at": ["0"] * 9}
    yield leaves("1 to 8 states", nine)
    yield leaves("states with different names", {"states": ["x", "x"], "rhs": [["1", "1"]], "at": ["0", "0"]})
    yield leaves("a right-hand side", {"rhs": []})
    yield leaves("proofs by name", {}, proofs=[])
    root = {"name": "r", "polynomial": ["-2", "0", "1"], "above": "0"}
    yield leaves("names of numbers that are no states", {"numbers": [{**root, "name": "x"}]})
    yield leaves("numbers with different names", {"numbers": [root, root]})
    many = {**cube(None), "surfaces": [f"x - {k}" for k in range(10)]}
    yield leaves("at most 1000 cells", {}, many)
    unreduced = {"numbers": [root], "at": [[["0", 0, 0]]]}
    yield leaves("powers below the degree", unreduced)
    words = "right-hand sides with at most 5 sines and cosines"
    yield of_one_state(words, f"-x{' + 0*sin(x)' * 6}", [ATTRACTS], FALLS, {})
    yield of_one_state("a cube of positive size", "x", [ATTRACTS], FALLS, {"cells": cube("-1")})
    for words, surfaces in (
        ("surfaces that are not constant", ["1"]),
        ("surfaces of which no two have a common factor", ["x", "2*x"]),
    ):
        yield leaves(words, {}, {**cube(None), "surfaces": surfaces})
    twice = [["", "x**2"], ["", "2*x**2"]]
    yield of_one_state("one formula of a function on every cell", "-x", [ATTRACTS], FALLS, {"function": twice})
    frame: Path = ["evidence", 0, "hypotheses", "cells", "frame"]
    same = [[["1"]], [["1"]]]
    yield Forgery("one condition", "root-plain", ((frame, same),), because="a frame without roots of states")
    for words, polynomial in (
        ("field: polynomials of degree two at least", ["-1", "1"]),
        ("field: polynomials with one root", ["-2", "0", "2"]),
    ):
        yield leaves(words, {"numbers": [{**root, "polynomial": polynomial}]})
    yield leaves("a number, not an empty list", {"numbers": [root], "at": [[]]})
    pieces = ["evidence", 0, "hypotheses", "function"]
    words = "a sign or a dot for each surface"
    yield Forgery("one condition", "one-relay-1", ((pieces, [["", "x**2"]]),), because=words)


def of_faces() -> Iterator[Forgery]:
    """A V that does not fall where solutions stay on a surface: ``x' = -sign(x), y' = 0``."""
    above: list[Record] = [{}] * 4 + [{"on": ["s0"]}] * 4
    proofs: Record = {"V +": {"simplices": above}, "V -": {"simplices": above[::-1]}}
    proofs |= {"cell + field 0": PLAIN, "cell - field 0": PLAIN}
    proofs["face 0"] = {"squares": [[], []], "mu": [[["-1", [0]]]]}
    subject: Record = {"states": ["x", "y"], "rhs": [["-sign(x)", "0"]], "at": ["0", "0"]}
    own = {"cells": {**cube("1"), "surfaces": ["x"]}, "function": "Abs(x) + y**2"}
    yield of_one_state("a positive square for face 0", "", [ATTRACTS], proofs, own, subject=subject)


def of_points() -> Iterator[Forgery]:
    """Solutions that come to rest at 1/2, where V bends and has the value 1/8."""
    parts = {"---": "-x", "+--": "x", "++-": "3/8 - x/2", "+++": "x - 3/8"}
    surfaces = ["x", "x - 1/4", "x - 1/2"]
    rhs = "-sign(x)*sign(x - 1/4)*sign(x - 1/2)"
    function = [[signs, v] for signs, v in parts.items()]
    proofs: Record = {"empty -+.": {"mixture": [{"s0": "1"}]}, "empty .-+": {"mixture": [{"s1": "1"}]}}
    proofs |= {f"cell {signs} field 0": PLAIN for signs in parts}
    proofs |= {"V ---": {"simplices": [{"on": ["s0"]}, {}]}, "V +--": {"simplices": [{}, {"on": ["s0"]}]}}
    proofs |= {"V ++-": {"mixture": [{"s2": "1/2"}]}, "V +++": {"mixture": [{"s2": "1"}]}}
    proofs |= {"face +0-": {"simplices": [{"mu": [["1/2"]]}]}, "face ++0": {"simplices": [{"mu": [["-1"]]}]}}
    proofs |= {"border +++ +0": PLAIN, "border --- -0": PLAIN}
    own: Record = {"cells": {"within": "1", "surfaces": surfaces, "empty": ["-+.", ".-+"]}, "function": function}
    claims = [ATTRACTS, {"attracts": {"function": function, "within": "1", "surfaces": surfaces, "below": "1/2"}}]
    yield of_one_state("positive coefficients for face +0-", rhs, claims, proofs, {**own, "level": "1/2"})


def of_pieces() -> Iterator[Forgery]:
    """Functions that jump, or are not looked at on both parts of where ``x**2 > 1/16``."""
    beyond: Record = {"simplices": [[0, 1, "1/2", {"on": ["s0"]}, {}], {"on": ["s0"]}]}
    proofs = {"V +": beyond, "V -": ON_PARTS, "cell + field 0": ON_PARTS, "cell - field 0": ON_PARTS}
    jumps = {"function": [["+", "x**2 - 1/8"], ["-", "x**2"]], "cells": {**cube("1"), "surfaces": ["x - 1/2"]}}
    yield of_one_state("functions that are continuous", "-x", [ATTRACTS], proofs, jumps)

    surfaces = ["x**2 - 1/16", "x", "x - 1/8"]
    cells = {**cube("1"), "surfaces": surfaces, "empty": [".-+", "++-"]}
    proofs = {f"cell {signs} field 0": ON_PARTS for signs in ("+++", "-++", "-+-", "---", "+--")}
    proofs |= {"V +..": ON_PARTS, "V -..": ON_PARTS, "empty .-+": {"mixture": [{"s1": "1"}]}}
    proofs["empty ++-"] = {"simplices": [[0, 1, "1/4", {"on": ["s0"]}, {}], {"on": ["s1"]}]}
    parts = [["+++", "x**2"], ["-..", "x**2"], ["+--", "2*x**2 - 1/16"]]
    words = "functions that bend on their surfaces alone"
    yield of_one_state(words, "-x", [ATTRACTS], proofs, {"cells": cells, "function": parts})


def of_escape() -> Iterator[Forgery]:
    """Solutions that need not leave: other fields, other sets, no mixtures."""
    rises = {"rises": {"simplices": [{}, {"on": ["sw"]}]}}

    def escapes(because: str, rhs: list[list[str]], proofs: Record, **hypotheses: Any) -> Forgery:
        names, zero = ["x", "y", "z"][: len(rhs[0])], ["0"] * len(rhs[0])
        subject = {"states": names, "rhs": rhs, "at": zero}
        own = {"within": "1", "surfaces": [], "signs": "", "mixture": [["", 0, "1", zero]], "function": "x"}
        own |= {"along": [], "barriers": [], "direction": ["1", *zero[1:]], **hypotheses}
        return of_subject(because, subject, [UNSTABLE], "escape", own, proofs)

    yield escapes("a cube", [["x"]], rises, within=None)
    yield escapes("fields that are exact: no sines and cosines", [["x + 0*sin(x)"]], rises)
    turning = [["x - 3*y", "3*x - 2*y"]]  # a focus, but for its other velocity on the x axis
    yield escapes("a mixture that is tangent to the subspace", turning, rises, along=["y"])
    away = {"along": ["y"], "direction": ["1", "1"]}
    yield escapes("a direction along the subspace", [["x", "-y"]], rises, **away)
    words = "barriers and a function that are positive in the direction"
    yield escapes(words, [["-x"]], {"rises": ON_PARTS}, function="-(x**2)")
    sheets = {"surfaces": ["y - x**2", "z - x**2"], "signs": "00", "mixture": [["++", 0, "1", ["0", "1", "1"]]]}
    yield escapes("at most one curved surface beside linear ones", [["1", "2*x", "2*x"]], {}, **sheets)
    words = "linear forms, zero on a subspace"
    yield escapes(words, [["x*(4*y - 1)", "0"]], rises, along=["y - 1/2"])
    nothing: Record = {"simplices": [{"on": ["sh"]}] * 8}
    circle = {"surfaces": ["x**2 + y**2"], "signs": "0", "mixture": [["+", 0, "1", ["1", "0"]]]}
    words = "a curved surface with a tangent plane at the point"
    yield escapes(words, [["-y", "x"]], {"beside 0 0": nothing, "rises": nothing}, **circle)
    other = [["-", 0, "1", ["1"]]]
    yield escapes("cells beside the subspace", [["-sign(x)"]], {}, surfaces=["x"], signs="+", mixture=other)
    ahead = {"surfaces": ["x - 1/2"], "signs": "+", "mixture": [["+", 0, "1", ["0"]]]}
    yield escapes("a proof of surface 0", [["x*sign(x - 1/2)"]], rises, **ahead)
    behind = {"surfaces": ["x"], "signs": "-", "mixture": [["-", 0, "1", ["0"]]]}
    yield escapes("a proof of surface 0", [["-sign(x)"]], {}, **behind)
    yield escapes("rises", [["0"]], {})
    pair = [["", 0, "2", ["0"]], ["", 1, "-1", ["0"]]]
    yield escapes("weight 1", [["-x"], ["-3*x"]], rises, mixture=pair)
    heavy = [["", 0, "1 + x**2", ["0"]]]
    yield escapes("a proof of weights", [["x"]], {**rises, "weight 0": ON_PARTS}, mixture=heavy)
    yield escapes("a function that is zero at the point", [["-x"]], {"rises": ON_PARTS}, function="1 - x**2")
    yield escapes("a positive speed", [["-x**3"]], {}, function="x**2", speed="-2")
    yield escapes("a positive speed", [["0"]], {}, speed="0")


def of_choice() -> Iterator[Forgery]:
    """Fields that are no mixture of the right-hand sides ``-x`` and ``-3*x``, or are no fields of the system."""
    subject: Record = {"states": ["x"], "rhs": [["-x"], ["-3*x"]], "at": ["0"]}
    own = {"cells": cube("1"), "function": "-(x**2)", "second": None, "direction": ["1"]}
    for because, surface in (("a number from -1 to 1", ["3"]), ("well-formed data, not a SyntaxError", "1)*3*(1")):
        choice = {"surface": surface, "first": 0, "second": 1}
        hypotheses = {"choice": choice, "theorem": "instability", "hypotheses": own}
        yield of_subject(because, subject, [UNSTABLE], "choice", hypotheses, {"cell  field 0": ON_PARTS})
    ahead = {"theorem": "departure", "hypotheses": {"cells": cube(None), "direction": ["1"]}}
    nested: Any = 0
    for _ in range(5):
        nested = {"surface": ["1"], "first": nested, "second": 0}
    for because, rhs, chosen in (
        ("at most 4 nested choices", [["1"]], nested),
        ("fields that are exact: no sines and cosines", [["1"], ["sin(x)"]], 0),
        ("calls of sign, Abs, Max, Min, relu or sat", [["1"], ["SIGN(x)"]], 0),
    ):
        yield of_subject(because, {**subject, "rhs": rhs}, [UNSTABLE], "choice", {"choice": chosen, **ahead}, {})


def of_parts() -> Iterator[Forgery]:
    """Parts that leave something out, that jump with what is replaced, and that only rest while they are driven."""

    def forged(because: str, claim: Record, rhs: list[str], theorem: str, hypotheses: Record, **more: Any) -> Forgery:
        subject = {"states": ["x", "y", "z"][: len(rhs)], "rhs": [rhs], "at": ["0"] * len(rhs), **more}
        return of_subject(because, subject, [claim], theorem, hypotheses, {})

    def entry(function: str, verdict: str = "asymptotically stable", rate: Record | None = None, **own: Any) -> Record:
        own = {"cells": cube("1"), "function": function, "second": None, "verdict": verdict, "everywhere": False, **own}
        own |= {"level": None, "below": False, "rate": rate}
        names = ["V ", "cell  field 0", *([] if rate is None else ["rate cell  field 0"])]
        names += ["denominator"] if "denominator" in own else []
        return {"theorem": "lyapunov", "hypotheses": own, "proofs": dict.fromkeys(names, ON_PARTS)}

    def parts(*listed: tuple[list[str], Record]) -> Record:
        return {"parts": [{"states": names, "entry": own} for names, own in listed]}

    def with_last(hypotheses: Record, more: Record) -> Record:
        return {"parts": [*hypotheses["parts"][:-1], hypotheses["parts"][-1] | more]}

    leaves = {"cells": cube("1"), "function": "-(y**2)", "second": None, "direction": ["1"]}
    out = {"theorem": "instability", "hypotheses": leaves, "proofs": {"cell  field 0": ON_PARTS}}
    x, y = (["x"], entry("x**2")), (["y"], entry("y**2"))
    resting = ["y"], entry("y**2", "stable")
    for because, claim, rhs, own in (
        ("parts with all states", ATTRACTS, ["-x", "y"], parts(x)),
        ("states of parts that are no others'", ATTRACTS, ["-x", "y"], parts(x, x)),
        ("different states", ATTRACTS, ["-x", "y"], parts((["x", "x"], x[1]), y)),
        ("parts that attract, or hold no states of others", STABLE, ["-x", "x"], parts(x, resting)),
        ("formulas in the states", UNSTABLE, ["-nearest", "y"], parts((["y"], out))),
        ("formulas that are continuous in what is replaced", ATTRACTS, ["-x", "2*y*sign(x)**2 - y"], parts(x, y)),
        (
            "formulas that are continuous in what is replaced",
            ATTRACTS,
            ["-x", "2*y*x**0*sign(x)*sign(x) - y"],
            parts(x, y),
        ),
        (  # decimals that floats do not tell apart
            "formulas that are continuous in what is replaced",
            ATTRACTS,
            ["-x", "1e400*(x - 1e-400)*sign(x - 0.0) - y"],
            parts(x, y),
        ),
        ("a theorem about parts", ATTRACTS, ["-x", "-y"], parts((["x"], {**x[1], "theorem": "basin"}), y)),
    ):
        yield forged(because, claim, rhs, "cascade", own)
    fast, slow = ((["x"], entry("x**2", rate={"kind": kind, "kappa": "1"})) for kind in ("exponential", "algebraic"))
    after = ["y"], entry("y**2", rate={"kind": "exponential", "kappa": "1"})
    relay = {"cells": {**cube("1"), "surfaces": ["y"]}, "function": "Abs(y) + z**2/2"}
    about = {"states": ["y", "z"], "rhs": [["z", "-sign(y)"]], "at": ["0", "0"]}
    hypotheses = {**entry("", "stable")["hypotheses"], **relay}
    bent, _ = Search().entry(read_subject(about), "lyapunov", hypotheses)
    nested = {"theorem": "cascade", "hypotheses": parts(resting), "proofs": {}}
    quotient = entry("y**2", "stable", denominator="1")
    words = "a carried part with a V that bends nowhere, no quotient"
    for because, rhs, first, last in (
        ("a part that is carried by what comes fast to the point", ["-x", "x"], [fast], 1),
        ("a part that is carried by what comes fast to the point", ["-x**3", "x"], [slow], True),
        ("a part that is carried by what comes fast to the point", ["-x**3", "x"], [x], True),
        ("a part that is carried by what comes fast to the point", ["-x**3", "-y + x", "y"], [slow, after], True),
        (words, ["-x", "x"], [fast], nested),
        (words, ["-x", "x"], [fast], quotient),
        (words, ["-x", "z + x", "-sign(y)"], [fast], bent),
    ):
        names = [own for own in "xyz"[: len(rhs)] if not any(own in known for known, _ in first)]
        own = parts(*first, (names, last if isinstance(last, dict) else entry(f"{names[0]}**2", "stable")))
        own["parts"][-1]["carried"] = isinstance(last, dict) or last
        yield forged(because, STABLE, rhs, "cascade", own)
    because = "an unstable part by itself, or that leaves with one right-hand side"
    both = [["-x", "y + x"], ["-x", "y - x"]]
    for sides, leaving in ((both[:1], {}), (both, {"leaves": True})):
        two = {"states": ["x", "y"], "rhs": sides, "at": ["0", "0"]}
        yield of_subject(because, two, [UNSTABLE], "cascade", with_last(parts(x, (["y"], out)), leaving), {})
    ended = parts((["y"], out), x)
    yield forged("an unstable part that ends the list", UNSTABLE, ["-x", "y"], "cascade", ended)
    own = with_last(parts(x, y), {"leaves": True})
    yield forged("parts that leave are unstable", ATTRACTS, ["-x", "-y"], "cascade", own)
    because, roots = "roots of parts just where the subject has roots", {"roots": ["x"]}
    yield forged(because, ATTRACTS, ["-x", "-y"], "cascade", parts(x, y), **roots)
    yield forged(because, ATTRACTS, ["-x", "-y"], "cascade", with_last(parts(y, x), roots))
    others = {"parts": [{**one, "roots": one["states"][:1]} for one in parts(x, y)["parts"]]}
    because = "roots of states of which the subject has roots"
    yield forged(because, ATTRACTS, ["-x", "-y"], "cascade", others, roots=["y"])
    relay_falls = {**entry("")["hypotheses"], "cells": {**cube("1"), "surfaces": ["y"]}, "function": "y**2"}
    alone = {"states": ["y"], "rhs": [["-2*sign(y)"]], "at": ["0"]}
    pulled = ["y"], Search().entry(read_subject(alone), "lyapunov", relay_falls)[0]
    jumps, continuous = {"jumps": True}, {"jumps": "continuous"}
    for because, side, driven, more in (
        ("jumps with forms of first degree in the states of a part", "2*y*sign(x)**2 - y", y, jumps),
        ("jumps with forms of first degree in the states of a part", "-2*sign(y + sign(x))", pulled, jumps),
        ("jumps with forms of first degree in the states of a part", "-2*sign(y - 3*y*sign(x)**2)", pulled, jumps),
        ("jumps with forms of first degree in the states of a part", "-2*sign(y + Max(x, y)/2)", pulled, continuous),
        ("surfaces without switching", "-2*sign(y + sat(x, -1, 1))", pulled, jumps),
        ("jumps with forms whose gradients are independent", "-sign(y) - sign(y + x)", pulled, jumps),
        ("jumps with forms whose gradients are independent", "-sign(y) - sign(y + sat(x, -1, 1))", pulled, continuous),
        (
            "jumps with forms whose gradients are independent",
            "-sign(y + 1.0*x) - sign(y + 1.00000000000000000001*x)",
            pulled,
            jumps,
        ),
        ("parts that jump with others, and are not carried", "-2*sign(y + x)", pulled, {"jumps": False}),
        ("parts that jump with others, and are not carried", "-2*sign(y + x)", pulled, {"jumps": 1}),
        ("parts that jump with others, and are not carried", "-2*sign(y + x)", pulled, {**jumps, "carried": True}),
    ):
        yield forged(because, ATTRACTS, ["-x", side], "cascade", with_last(parts(x, driven), more))
    bare = {"parts": [{**one, "roots": [], "orders": []} for one in parts(x, y)["parts"]]}
    yield forged("orders of roots", ATTRACTS, ["-x", "-y"], "cascade", bare, **roots)
    unlisted = {"parts": [{**one, "roots": False} for one in parts(x, y)["parts"]]}
    yield forged("a list of some items", ATTRACTS, ["-x", "-y"], "cascade", unlisted, **roots)
    # the number that stands for the state root_x would stand for the root of x, too
    about = {"states": ["root_x", "x"], "rhs": [["1 - root_x", "x - 1"]], "at": ["1", "1"], "roots": ["root_x", "x"]}
    hidden = parts((["root_x"], entry("root_x**2", cells=cube("1/2"))), (["x"], entry("root_x**2", "stable")))
    for one, names in zip(hidden["parts"], ([], ["x"]), strict=True):
        one["roots"] = names
    hidden["parts"][-1]["entry"]["hypotheses"]["cells"] = cube("1/2")
    hidden["parts"][-1]["entry"]["proofs"]["cell  field 0"] = {}
    because = "names of roots that are no states of any part"
    yield of_subject(because, about, [STABLE], "cascade", hidden, {})
    carried = {"parts": [{**one, "roots": []} for one in parts(fast, (["y"], entry("y**2", "stable")))["parts"]]}
    because = "carried parts without roots of states"
    yield forged(because, STABLE, ["-x", "x"], "cascade", with_last(carried, {"carried": True}), **roots)
    for because, rhs, surface, state in (
        ("a surface that all cells lead to", ["y", "sign(x + y)"], "x + y", "y"),
        ("a surface through the point that gives the state", ["-x", "1 - sign(y - 1)"], "y - 1", "y"),
        ("a surface through the point that gives the state", ["-x", "-sign(x + y**3 + y)"], "x + y**3 + y", "y"),
        ("a state beside others", ["-x", "-sign(x + y)"], "x + y", "z"),
        ("formulas that are continuous in what is replaced", ["2*x*sign(y)**2 - x", "-sign(y)"], "y", "y"),
    ):
        own = {"cells": {**cube("1/2"), "surfaces": [surface]}, "surface": 0, "state": state, "entry": x[1]}
        yield forged(because, ATTRACTS, rhs, "sliding", own)
    own = {"cells": {**cube("1/2"), "surfaces": ["y"]}, "surface": 0, "state": "y", "entry": x[1]}
    yield forged("a surface without roots of states", ATTRACTS, ["-x", "-sign(y)"], "sliding", own, roots=["x"])
    alone = {"cells": {**cube("1/2"), "surfaces": ["x"]}, "surface": 0, "state": "x", "entry": x[1]}
    line = {"states": ["x"], "rhs": [["-sign(x)"]], "at": ["0"]}
    yield of_subject("a state beside others", line, [ATTRACTS], "sliding", alone, {})


def of_circles() -> Iterator[Forgery]:
    """Angles whose sines are not those of whole multiples, and a V that is not zero at the point."""
    eight: Record = {"simplices": [{}] * 8}
    proofs: Record = {"V ": eight, "cell  field 0": eight}

    def turns(
        because: str, rhs: str, shown: Record | None = None, v: str = "sin_x**2 + cos_x**2", **own: Any
    ) -> Forgery:
        subject = {"states": ["x"], "rhs": [[rhs]], "at": ["0"], **own}
        hypotheses = {"angles": ["x"], "cells": cube("1"), "function": v}
        return of_subject(because, subject, [STABLE], "circles", hypotheses, shown or proofs)

    yield turns("sines and cosines of sums of multiples of angles", "-sin(x + 1)")
    yield turns("whole multiples of angles", "4*sin(x/2) - sin(x)")
    yield turns("whole multiples of angles", "4e400*sin(1e-400*x) - sin(x)")  # floats: sin(0)
    yield turns("no other functions than sines and cosines on circles", "sin(x) + 0*tanh(y)")
    yield turns("formulas in the states", "-sin(x) + 0*sin_x")
    yield turns("a V that is zero at the point", "1", {"V ": PLAIN, "cell  field 0": PLAIN}, "1")
    yield turns("no roots beside angles", "-sin(x)", roots=["x"], order=0)
    yield turns("angles that are 0 at the point", "-sin(x)", at=["1"])
    none: Record = {"angles": [], "cells": cube("1"), "function": "x**2"}
    words = "angles that are different states"
    subject: Record = {"states": ["x"], "rhs": [["-x"]], "at": ["0"]}
    yield of_subject(words, subject, [STABLE], "circles", none, FALLS)


def of_centres() -> Iterator[Forgery]:
    """Springs of which two act in turn, or gain; other mirrors and factors, and no square."""
    eight: Record = {"simplices": [{}] * 8}
    still = {"turns  field 0": eight}
    mirror: Record = {"mirror": [["1", "0"], ["0", "-1"]]}

    def turns(because: str, rhs: list[list[str]], proofs: Record = still, **hypotheses: Any) -> Forgery:
        subject = {"states": ["x", "y"], "rhs": rhs, "at": ["0", "0"]}
        own: Record = {"cells": cube("1"), "weights": {"": ["1", "1"]}, "sense": -1} | hypotheses
        theorem = "reversible" if "mirror" in own else "integral"
        return of_subject(because, subject, [STABLE], theorem, own, proofs)

    spring = [["y", "-x"]]
    plane = [[["1", "0"], ["0", "1"]]] * 2
    yield turns("a frame where a V alone shows a verdict", spring, cells={**cube("1"), "frame": plane}, **mirror)
    words = "one right-hand side in two states, without roots"
    yield turns(words, [*spring, ["y", "-4*x"]], {**still, "turns  field 1": eight}, **mirror)
    yield turns("a square", spring, cells=cube(None), **mirror)
    beside: Record = {"within": "1", "surfaces": ["x - 1/2"], "empty": []}
    sides: Record = {"weights": {"-": ["1", "1"], "+": ["1", "1"]}}
    words = "lines through the point, and surfaces outside the square"
    yield turns(words, [["y", "-x - (1 + sign(x - 1/2))*y"]], cells=beside, **sides, **mirror)
    yield turns("a sense of 1 or -1", spring, sense=-2, **mirror)
    yield turns("a reflection", [["x + y", "y - x"]], mirror=[["0", "0"]] * 2)
    yield turns(
        "sines and cosines of what the reflection keeps, up to its sign", [["y", "-x + 0*sin(x + y)"]], **mirror
    )
    yield turns("fields that the reflection reverses", [["x + y", "y - x"]], **mirror)
    # x' = -x y - y r^2, y' = -y^2 + x r^2: some solutions run into the point
    run_in = [["-x*y - y*(x**2 + y**2)", "-y**2 + x*(x**2 + y**2)"]]
    yield turns("positive coefficients for turns  field 0", run_in, sense=1, **mirror)
    for weights, words in (({}, "weights for each cell"), ({"": ["-1", "-1"]}, "positive weights")):
        yield turns(words, spring, weights=weights, **mirror)
    quarters = [f"{first}{second}" for first in "-+" for second in "-+"]
    skew: Record = {"within": "1", "surfaces": ["x - y", "x + y"], "empty": []}
    within: Record = {"cells": skew, "weights": {key: ["2", "1"] for key in quarters}}
    proofs: Record = {f"turns {own} field 0": eight for own in quarters}
    yield turns("equal weights beside lines that are no axes", spring, proofs, **within, **mirror)

    plain: Record = {"exponent": "0", "factors": []}
    gains = [["y + x", "y - x"]]  # div f = 2, and ln(x^2 + y^2) rises by 2: the factor is infinite at the point
    yield turns("an integrating factor", gains, **plain)
    square: Record = {"exponent": "0", "factors": [["x**2 + y**2", "-1"]]}
    yield turns("factors that are not zero at the point", gains, **square)
    yield turns("an integral without sines and cosines of states", [["y", "-x + 0*sin(x)"]], **plain)
    halves: Record = {"cells": {"within": "1", "surfaces": ["x"], "empty": []}, "sense": -1}
    halves["weights"] = {"-": ["1", "1"], "+": ["1", "1"]}
    proofs = {f"turns {own} field 0": eight for own in "-+"}
    grows = [["y + (1 + sign(x))*y**2/2", "-x"]]  # by the energies of both sides, each half turn more than the last
    yield turns("the same flux from both sides of a line", grows, proofs, **halves, **plain)


def of_polygons() -> Iterator[Forgery]:
    """Polygons into which starts come, or that do not hold the point."""
    square = ["8 -8", "8 8", "-8 8", "-8 -8"]

    def outside(because: str, rhs: list[str], corners: list[str], surfaces: list[str], **own: Any) -> Forgery:
        about: Record = {"unit": "1/4", "corners": corners, **own}
        subject = {"states": ["x", "y"], "rhs": [rhs], "at": ["0", "0"]}
        return of_subject(because, subject, [{"outside": about}], "outside", {**about, "surfaces": surfaces}, {})

    beside = ["12 -4", "12 4", "4 4", "4 -4"]
    yield outside("the point to the left of the polygon", ["x - 2", "y"], beside, [])
    away = "velocities that lead to the right at"
    yield outside(f"{away} ((8, -8), (8, 8))", ["x*(y**2 - 1)", "y*(x**2 - 1)"], square, [])
    turned = [f"{name}*sign(4 - x - y)" for name in "xy"]
    yield outside(f"{away} ((8, 8),)", turned, square, ["4 - x - y"])
    yield outside("two whole numbers in a text", ["x", "y"], ["+8 -8", *square[1:]], [])
    yield outside("a unit of lengths", ["x", "y"], square, [], unit=None)
    yield outside("sines and cosines of at most 64", ["x + 0*sin(x + 65)", "y"], square, [])
    yield outside("sines, cosines, tanh and atan of affine functions", ["x + 0*sin(x*y)", "y"], square, [])
    yield outside("sines and cosines that are not multiplied by each other", ["x + sin(x)*sin(y)/9", "y"], square, [])
    spring, line = ["y", "-x + x**3 - y"], ["6 -1", "5 1"]
    for corners, ends in ((line, ["1 0", "1 1"]), ([], ["1 0", "0 1"])):
        yield outside("corners, and half-lines along the axes", spring, corners, [], ends=ends)
    yield outside("the point to the left of the polygon", ["-y", "-x + x**3"], line[::-1], [], ends=["0 1", "1 0"])
    yield outside("sides that do not meet", spring, ["6 -1", "5 1", "5 -2"], [], ends=["1 0", "0 1"])
    yield outside(f"{away} ((6, -1),)", ["y", "-x + x**3 - y - x**5/99"], line, [], ends=["1 0", "0 1"])
    yield outside("half-lines without sines and cosines", ["y + 0*sin(x)", spring[1]], line, [], ends=["1 0", "0 1"])
    numbers: Path = ["statement", "subject", "numbers"]
    root = {"name": "r", "polynomial": ["-2", "0", "1"], "above": "0"}
    for name, words in (("outside-plain-square", "a polygon"), ("basin-plain-1", "a mesh")):
        yield Forgery("one condition", name, ((numbers, [root]),), because=f"rational numbers, for {words}")


def of_meshes() -> Iterator[Forgery]:
    """Meshes whose border is not in the level set, that overlap themselves, or are none."""
    hypotheses: Path = ["evidence", 0, "hypotheses"]
    claims: Path = ["statement", "claims"]
    mesh = good_certificates()["basin-plain-1"]["evidence"][0]["hypotheses"]["mesh"]

    def changed(because: str, *changes: tuple[Path, Any]) -> Forgery:
        return Forgery("one condition", "basin-plain-1", changes, because=because)

    def meshed(because: str, **own: Any) -> Forgery:
        other = {**mesh, **own}
        return changed(because, ([*hypotheses, "mesh"], other), ([*claims, 2, "attracts", "mesh"], other))

    low = [([*hypotheses, "local", "level"], "1/64"), ([*claims, 1, "attracts", "below"], "1/64")]
    yield changed("a border in the level set, or at the level: (1, 0)", *low)
    quarter = [([*hypotheses, "local", "denominator"], "1/4"), ([*claims, 1, "attracts", "denominator"], "1/4")]
    proof: tuple[Path, Any] = (["evidence", 0, "proofs", "denominator"], {"simplices": [{}] * 8})
    yield changed("a V without a denominator beside a mesh", *quarter, proof)
    one = [([*hypotheses, "below"], True), ([*claims, 2, "attracts", "below"], True)]
    yield changed("a level that is a whole number", *one)
    rests = ["-x + x**3/2", "-y"]  # at x = sqrt(2), in the mesh
    yield changed("a function that falls on simplex 0", (["statement", "subject", "rhs"], [rests]))
    yield meshed("a simplex", triangles=[])
    words = "sides of one simplex to the left, and of one to the right"
    yield meshed(words, triangles=[*mesh["triangles"], mesh["triangles"][0]])
    yield meshed("3 whole numbers in a text", corners=[f"{mesh['corners'][0]} 0", *mesh["corners"][1:]])
    turned = [" ".join(reversed(own.split())) for own in mesh["triangles"]]
    yield meshed("simplices of positive size", triangles=turned)


def of_resting_places() -> Iterator[Forgery]:
    """W falls in all triangles, and a solution rests on a side between them, or at a corner of them."""
    eight: Record = {"simplices": [{}] * 8}
    two: Record = {"simplices": [{}, {}]}
    for because, rhs, surfaces, height in (
        ("a function that falls on side 0 2", "x**2/16 - y", ["x - 2"], 0),
        ("velocities in a half plane at (8, 8)", "y*(1 - y)*sign(y - 2)", ["x - 2", "y - 2"], 8),
    ):
        corners = [(8, height, 0), (10, height, 1), (8, height + 2, 1), (6, height, 1), (8, height - 2, 1)]
        mesh = {
            **{"unit": "1/4", "corners": [" ".join(map(str, own)) for own in corners]},
            "triangles": ["0 1 2", "0 2 3", "0 3 4", "0 4 1"],
        }
        dots = "." * len(surfaces)
        empty = [f"{dots[:k]}+{dots[k + 1 :]}" for k in range(len(surfaces))]
        local: Record = {"cells": {"within": "1/2", "surfaces": surfaces, "empty": empty}, "function": "x**2 + y**2"}
        local |= {"verdict": "asymptotically stable", "everywhere": False, "level": "1/4", "below": False}
        local |= {"rate": None, "second": None}
        proofs = {f"V {dots}": eight, f"cell {'-' * len(dots)} field 0": eight}
        proofs |= {f"empty {own}": PLAIN for own in empty}
        proofs |= {f"border {dots} {sign}{k}": two for sign in "+-" for k in range(2)}
        subject: Record = {"states": ["x", "y"], "rhs": [["x*(1 - x)*sign(x - 2)", rhs]], "at": ["0", "0"]}
        level = {"function": "x**2 + y**2", "within": "1/2", "below": "1/4"}
        claims = [ATTRACTS, {"attracts": level}, {"attracts": {"mesh": mesh, "below": 1}}]
        hypotheses = {"local": local, "surfaces": surfaces, "mesh": mesh, "below": 1}
        yield of_subject(because, subject, claims, "basin", hypotheses, proofs)


def of_a_relay_in_space() -> Iterator[Forgery]:
    """W falls in all tetrahedra, and rises along solutions that slide between them: ``y' = 2 y**3/3 - y``."""
    good = good_certificates()["space-relay-1"]["evidence"][0]["hypotheses"]
    own: Record = {"states": ["x", "y", "z"], "rhs": [["-x - 8*sign(x)", "-y + 2*y**3/3", "-z"]], "at": ["0", "0", "0"]}
    entry, claims = Search().entry(read_subject(own), "lyapunov", good["local"])
    mesh = {"mesh": good["mesh"], "below": good["below"]}
    because = "a function that falls on the face (1, 7)"
    yield of_subject(because, own, [*claims, {"attracts": mesh}], "basin", good, entry["proofs"])


def of_homogeneous_systems() -> Iterator[Forgery]:
    """Points that do not attract everywhere, and weights of another degree."""
    good: Path = ["evidence", 0, "hypotheses"]
    first = Forgery("one condition", "homogeneous-root", (([*good, "weights"], ["-1"]),), because="positive weights")
    yield first
    yield replace(first, changes=(([*good, "cells", "within"], "1"),), because="the whole space")

    def scaled(because: str, rhs: str, surfaces: list[str], verdict: str = "asymptotically stable") -> Forgery:
        about = {"states": ["x"], "rhs": [[rhs]], "at": ["0"]}
        bare = {"second": None, "everywhere": False, "level": None, "below": False, "rate": None}
        own = {"cells": {**cube("1/2"), "surfaces": surfaces}, "function": "x**2", "verdict": verdict, **bare}
        entry, _ = Search().entry(read_subject(about), "lyapunov", own)
        whole = {"cells": {**cube(None), "surfaces": surfaces}, "weights": ["1"], "entry": entry}
        return of_subject(because, about, [EVERYWHERE], "homogeneous", whole, {})

    yield scaled("a point that attracts", "-relu(x)", ["x"], "stable")
    yield scaled("surfaces whose terms have one weight", "-x*sign(1 - x)", ["x - 1"])
    yield scaled("velocities whose terms have the weights of one degree", "-x + x**3", [])


def of_forms_of_several_degrees() -> Iterator[Forgery]:
    """Solutions that stay where x = y = 0 < z and leave beyond z = 2, though V falls in the cube, and all is of forms.

    Beside that line fields push ``(2 z, 2 z**3)``, ``(0, -z)`` and ``(-2 z, 0)`` across, the first with V' = 0.
    """
    above, names = "(1 + sign(z))/2", ("x", "y", "z")

    def inside(x: str, y: str, end: str) -> str:
        return f"{above}*(1 {x} sign(x))/2*(1 {y} sign(y))/2*(1 + sign({end}))/2"

    more = {
        inside("-", "+", "z - 8*y"): ("2*z", "y + z**2*(2*z - x - y/2)", "z**2*(z/2 - 2*y)"),
        inside("+", "-", "z + 8*y"): ("0", "y - z", "z"),
        inside("+", "+", "z - 8*y"): ("-2*z", "0", "0"),
    }
    rhs = [f"-{name}" + "".join(f" + {here}*({own[k]})" for here, own in more.items()) for k, name in enumerate(names)]
    subject: Record = {"states": list(names), "rhs": [rhs], "at": ["0", "0", "0"]}
    surfaces, empty = ["x", "y", "z", "z - 8*y", "z + 8*y"], [".++.-", ".-+-.", ".+-+.", ".--.+"]
    function = "x**2 + y**2 + z**2 + Abs(x)*Abs(z) - Abs(y)*Abs(z)/2"
    own: Record = {"cells": {"within": "1", "surfaces": surfaces, "empty": empty}, "function": function}
    own |= {"verdict": "asymptotically stable", "everywhere": False, "below": False}
    own |= dict.fromkeys(("second", "level", "rate"))
    on_line = {"simplices": [{"mu": [["0", "-1"], ["0", "3/4"]]}, {"on": ["s2"] * 8}]}
    entry, _ = Search(known={"face 00+..": on_line}).entry(read_subject(subject), "lyapunov", own)
    hypotheses = {**own, "everywhere": True}
    words = "cones and forms, for the whole space"
    yield of_subject(words, subject, [ATTRACTS, EVERYWHERE], "lyapunov", hypotheses, entry["proofs"])


def of_sets_of_equilibria() -> Iterator[Forgery]:
    """Orbits about the point, a curve of equilibria, one that is seen by a root, and levels of nothing."""
    near = {"approaches": "near"}

    def approach(because: str, rhs: list[str], bound: Any, cell: str = "", **more: Any) -> Forgery:
        about = {"states": ["x", "y"], "rhs": [rhs], "at": ["0", "0"]}
        where = more.get("cells", cube("1"))
        verdict = {"verdict": "stable", "second": None, "everywhere": False, "level": None, "below": False}
        own = {"cells": where, "function": "x**2 + y**2", "rate": None, **verdict}
        proofs = Search().entry(read_subject(about), "lyapunov", own)[0]["proofs"]
        name = f"cell {cell} field 0"
        hypotheses = {"cells": cube("1"), "function": "x**2 + y**2", "zeros": {name: bound}, "level": None}
        hypotheses |= {"proper": None, **more}
        return of_subject(because, about, [STABLE, near], "approach", hypotheses, {**proofs, name: PLAIN})

    yield approach("velocities that lead along no place where V is kept", ["y", "-x"], [])
    curved = ["x*(y - x**2)", "x**2 - y"]
    yield approach("flat places where V is kept", curved, [["2", [["y - x**2", 2]]]])
    rests, line = ["0", "-y"], [["2", [["y", 2]]]]
    yield approach("a positive level on a cube", rests, line, level="0")
    yield approach("a positive level on a cube", rests, line, level="1", cells=cube(None))
    rooted = approach("a system that is not seen by roots of its states", rests, line)
    ((text, times),) = rooted.text
    yield replace(rooted, text=((text.replace('"at":["0","0"]', '"at":["0","0"],"roots":["x"]'), times),))


def of_names_of_roots() -> Iterator[Forgery]:
    """Roots that are none, or not rational at the point."""
    roots: Path = ["statement", "subject", "roots"]
    yield Forgery("one condition", "one-linear-1", ((roots, []),), because="roots of different states")
    ahead = {"cells": cube(None), "direction": ["1", "0"]}
    subject: Record = {"states": ["x", "root_x"], "rhs": [["1", "1"]], "at": ["0", "0"], "roots": ["x"]}
    yield of_subject("names of roots that are no states", subject, [UNSTABLE], "departure", ahead, {})
    number = {"name": "root_x", "polynomial": ["-2", "0", "1"], "above": "0"}
    named = {"states": ["x"], "rhs": [["1"]], "at": ["0"], "roots": ["x"], "numbers": [number]}
    along = {"cells": cube(None), "direction": ["1"]}
    yield of_subject("names of numbers that are no roots", named, [UNSTABLE], "departure", along, {})
    first = Forgery("one condition", "root-third", ((["statement", "subject", "orders"], [1]),))
    yield replace(first, because="roots of an order of two at least")
    other = (["statement", "subject", "rhs", 0, 0], "-sign(x)*Abs(x)**(1/2) + 2*x")
    yield replace(first, changes=(other,), because="powers of the roots that are listed")
    unordered: Any = (["statement", "subject", "order"], GONE)
    because = "an order of sines and cosines beside roots"
    yield Forgery("one condition", "root-sines", (unordered,), because=because)
    subject = {"states": ["x"], "rhs": [["1 - sqrt(Abs(x))"]], "at": ["2"], "roots": ["x"]}
    cells = {"within": "1/2", "surfaces": ["root_x + 1"], "empty": ["-"]}
    proofs = {"V .": ON_PARTS, "cell + field 0": ON_PARTS, "empty -": PLAIN}
    own = {"cells": cells, "function": "root_x**2"}
    yield of_one_state("a point whose roots are rational", "", [ATTRACTS], proofs, own, subject=subject)


def conditions() -> Iterator[Forgery]:
    """All of them."""
    for kind in (
        *(
            of_lyapunov,
            of_gain,
            of_quotients,
            of_proper,
            of_instability,
            of_roots,
            of_other_roots,
            of_functions_of_roots,
        ),
        *(of_evidence, of_squares, of_pairs, of_further_functions, of_formulas, of_documents),
        *(of_cells, of_faces, of_points, of_pieces),
        *(of_escape, of_choice, of_circles, of_centres, of_polygons, of_meshes, of_names_of_roots, of_parts),
        *(of_resting_places, of_a_relay_in_space, of_homogeneous_systems, of_forms_of_several_degrees),
        of_sets_of_equilibria,
    ):
        yield from kind()
