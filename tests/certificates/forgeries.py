"""Forged certificates: good ones with something changed, so that they claim what is false or show too little.

A forgery is kept as what it changes, so that a thousand of them are a small file.
"""

from __future__ import annotations

import copy
import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

Record: TypeAlias = dict[str, Any]
Path: TypeAlias = list[Any]  # keys and indices from the top of a document

GONE = {"gone": True}  # in the place of a value: the key is left out


@dataclass(frozen=True)
class Forgery:
    """A certificate that must be rejected.

    Attributes:
        kind: what is wrong.
        of: the name of the good certificate that it was; empty where it is a text of its own.
        changes: paths, each with its new value.
        text: pieces of a text, each with the number of times that it is repeated.
        because: the words with which it is refused, where it is made for these.
    """

    kind: str
    of: str = ""
    changes: tuple[tuple[Path, Any], ...] = ()
    text: tuple[tuple[str, int], ...] = ()
    because: str = ""

    @property
    def record(self) -> Record:
        """As the corpus keeps it."""
        own = {"text": self.text} if self.text else {"of": self.of, "changes": self.changes}
        return {"kind": self.kind, **own, **({"because": self.because} if self.because else {})}

    def document(self, good: Record) -> Record:
        """The forged certificate."""
        found = copy.deepcopy(good)
        for path, value in copy.deepcopy(self.changes):  # a later change may be inside the value of an earlier one
            own: Any = found
            for key in path[:-1]:
                own = own[key]
            if value == GONE:
                del own[path[-1]]
            elif isinstance(own, list) and path[-1] == len(own):
                own.append(value)
            else:
                own[path[-1]] = value
        return found

    @property
    def content(self) -> str:
        """The text of a forgery that is one."""
        return "".join(piece * times for piece, times in self.text)


HYPOTHESES: Path = ["evidence", 0, "hypotheses"]
PROOFS: Path = ["evidence", 0, "proofs"]
SUBJECT: Path = ["statement", "subject"]
CLAIMS: Path = ["statement", "claims"]


def cells_of(good: Record) -> tuple[Path, Record]:
    """Where a theorem's hypotheses name surfaces and the cube, and these."""
    hypotheses, where = good["evidence"][0]["hypotheses"], HYPOTHESES
    if "local" in hypotheses:
        hypotheses, where = hypotheses["local"], [*HYPOTHESES, "local"]
    if "choice" in hypotheses:
        hypotheses, where = hypotheses["hypotheses"], [*HYPOTHESES, "hypotheses"]
    if "parts" in hypotheses:
        hypotheses, where = hypotheses["parts"][0]["entry"]["hypotheses"], [*where, "parts", 0, "entry", "hypotheses"]
    return ([*where, "cells"], hypotheses["cells"]) if "cells" in hypotheses else (where, hypotheses)


# ---- each kind gives the changes that it makes to a good certificate, or none ---------------------


def other_version(good: Record) -> Iterator[Any]:
    """Of a version that is not known."""
    yield [(["version"], "nonsmooth-certificate/3")]
    yield [(["version"], GONE)]


def other_frame(good: Record) -> Iterator[Any]:
    """Keys that are missing, or one too many."""
    for key in ("statement", "evidence"):
        yield [([key], GONE)]
        yield [([key], None)]
    yield [(["proof"], {})]
    yield [([*SUBJECT, "domain"], "1")]
    yield [([*HYPOTHESES, "trust"], True)]


def without_evidence(good: Record) -> Iterator[Any]:
    """Claims of which nothing is shown."""
    yield [(["evidence"], [])]
    yield [(PROOFS, {})] if good["evidence"][0]["proofs"] else None
    yield [(CLAIMS, [])]


def without_one_proof(good: Record) -> Iterator[Any]:
    """A proof less: of a cell, of a face, of V, of the border, of an empty pattern."""
    for name in good["evidence"][0]["proofs"]:
        yield [([*PROOFS, name], GONE)]


def with_one_proof_more(good: Record) -> Iterator[Any]:
    """A proof of a claim that is not asked."""
    proofs = good["evidence"][0]["proofs"]
    for name in list(proofs)[:2]:
        yield [([*PROOFS, name + "+"], proofs[name])]
        yield [([*PROOFS, " " + name], proofs[name])]


def with_empty_proofs(good: Record) -> Iterator[Any]:
    """A proof of nothing in the place of one."""
    for name, own in good["evidence"][0]["proofs"].items():
        yield [([*PROOFS, name], {})]
        for kind, listed in own.items():
            if listed:
                yield [([*PROOFS, name, kind], [])]


def with_exchanged_proofs(good: Record) -> Iterator[Any]:
    """The proof of V for a cell."""
    proofs = good["evidence"][0]["proofs"]
    first = next((name for name in proofs if name.startswith("V")), None)
    for name in proofs:
        if first is not None and name.startswith("cell") and proofs[name] != proofs[first]:
            yield [([*PROOFS, name], proofs[first]), ([*PROOFS, first], proofs[name]), ([*PROOFS, "none"], {})]


def other_field(good: Record) -> Iterator[Any]:
    """Another subject: time runs backward; a field more that leads away; a point beside."""
    subject = good["statement"]["subject"]
    for k, side in enumerate(subject["rhs"]):
        yield [([*SUBJECT, "rhs", k], [f"-({own})" for own in side])]
        yield [([*SUBJECT, "rhs", k, 0], f"{side[0]} - 100*({side[0]})")]
        yield [([*SUBJECT, "rhs", k, 0], f"{side[0]} + sign({subject['states'][-1]} - 1/64)")]
    away = [f"-8*({own})" for own in subject["rhs"][0]]
    yield [([*SUBJECT, "rhs", len(subject["rhs"])], away)]


def other_states(good: Record) -> Iterator[Any]:
    """Names that are not known, twice there, or no names."""
    names = good["statement"]["subject"]["states"]
    yield [([*SUBJECT, "states", 0], "other")]
    yield [([*SUBJECT, "states", 0], "1")]
    yield [([*SUBJECT, "states", 0], f"{names[0]} ")]
    yield [([*SUBJECT, "states", 0], "\uff58")]
    yield [([*SUBJECT, "states"], [*names, names[0]])]
    yield [([*SUBJECT, "at"], [])]


def other_claims(good: Record) -> Iterator[Any]:
    """A claim more that no theorem shows, or one that is larger than what is shown."""
    claims = good["statement"]["claims"]
    more: list[Any] = [
        {"stability": "exponentially stable"},
        {"stability": True},
        {"attracts": "everything"},
        {"gain": {"gamma": "1"}},
        {},
        None,
        "stable",
        [claims[0]],
    ]
    if {"stability": "unstable"} not in claims:
        more += [{"stability": "unstable"}, {"equilibrium": False}]
    else:
        more += [{"stability": "stable"}, {"attracts": "everywhere"}]
    for own in more:
        yield [([*CLAIMS, len(claims)], own)]
    for k, own in enumerate(claims):
        for kind in ("attracts", "rate"):
            for key in own.get(kind, {}) if isinstance(own.get(kind), dict) else ():
                if isinstance(own[kind][key], str):
                    yield [([*CLAIMS, k, kind, key], f"{own[kind][key]} ")]
                yield [([*CLAIMS, k, kind, key], GONE)]


def other_surfaces(good: Record) -> Iterator[Any]:
    """A surface less, twice, with a common factor, constant or switched."""
    place, own = cells_of(good)
    surfaces, where = own["surfaces"], [*place, "surfaces"]
    name = good["statement"]["subject"]["states"][0]
    if surfaces:
        yield [(where, surfaces[1:])]
        yield [(where, [*surfaces, surfaces[0]])]
        yield [(where, [*surfaces, f"-2*({surfaces[0]})"])]
        yield [(where, [*surfaces, f"({surfaces[0]})*(1 + {name}**2)"])]
        yield [([*where, 0], f"({surfaces[0]})**2")]
    for wrong in ("1", f"Abs({name})", f"sign({name})", f"1/{name}", "", "0"):
        yield [([*where, len(surfaces)], wrong)]


def other_cells(good: Record) -> Iterator[Any]:
    """Cells that are said to be empty and are not; cubes of no size, or where nothing was shown."""
    where, own = cells_of(good)
    size = len(own["surfaces"])
    for mark in ("." * size, "+" * size, "-" * size, "+" * (size + 1)):
        if mark not in own.get("empty", [mark]):
            yield [([*where, "empty"], [*own["empty"], mark])]
            yield [([*where, "empty"], [*own["empty"], mark]), ([*PROOFS, f"empty {mark}"], {"mixture": [{}]})]
    other_sizes: tuple[Any, ...] = ("0", "-1", "1e9", 1, "1/0", "", [], "inf", True)
    for within in other_sizes:
        yield [([*where, "within"], within)]


def other_coordinates(good: Record) -> Iterator[Any]:
    """Frames whose matrices are not inverse, or none; and a V that was shown in one, with more than a verdict.

    The same of maps that bend.
    """
    where, own = cells_of(good)
    if "coordinates" in own:
        to_states, back = own["coordinates"]
        shifted = [f"{text} + 1" for text in to_states]
        others: list[Any] = [[back, to_states], [to_states, to_states], [to_states], [to_states, back[:1]]]
        for other in (*others, [shifted, back], 1):
            yield [([*where, "coordinates"], other)]
        yield [([*where, "coordinates"], [to_states, [f"-({text})" for text in back]])]
        yield [([*where, "frame"], [[["1", "0"], ["0", "1"]]] * 2)]
    if "frame" not in own:
        return
    to_states, back = own["frame"]
    none = [["0"] * len(back) for _ in back]
    for wrong in ([back, to_states], [to_states, none], [none, none], [to_states], [to_states, to_states], None, [], 1):
        yield [([*where, "frame"], wrong)]
    yield [([*where, "frame"], [to_states, [[f"-{own}" for own in row] for row in back]])]
    for key, value in (("level", "1/1000"), ("everywhere", True), ("rate", {"kind": "exponential", "kappa": "1/1000"})):
        yield [([*HYPOTHESES, key], value)]


def other_function(good: Record) -> Iterator[Any]:
    """A V that is not zero at the point, negative, not continuous, or no formula."""
    hypotheses = good["evidence"][0]["hypotheses"]
    own = hypotheses.get("function")
    where = [*HYPOTHESES, "function"]
    if own is None:
        return
    name = good["statement"]["subject"]["states"][0]
    if isinstance(own, str):
        wrong = [f"{own} + 1", f"-({own})", f"{own} + 1000*{name}", "0", f"({own})*0", f"{own} + sign({name})"]
        wrong += [f"{own} # and more", f"({own},)", f"{own} if {name} else 0", f"[{own}][0]", f"(t := {own})"]
        wrong += [f"{own}\n", f"({own}\n)*1", f"eval('{name}')", f"{own} + {name}.real", f"{own} @ 1", f"{own} % 2"]
        wrong += [f"{own} + 1j*{name}", f"{own} + 0x1*{name}", f"{own} ** 41", f"{own} ** -1", f"({own})**(1/2)"]
        for text in wrong:
            if text.strip() != own:
                yield [(where, text)]
    else:
        yield [(where, own[1:])]
        yield [(where, [*own, ["." * len(own[0][0]), "0"]])]
        yield [([*where, 0, 1], f"{own[0][1]} + {name}*100 + 1")]
    yield [(where, None)]


def other_level(good: Record) -> Iterator[Any]:
    """Levels and rates beyond those that are shown."""
    hypotheses = good["evidence"][0]["hypotheses"]
    if good["evidence"][0]["theorem"] != "lyapunov":
        return
    for level in ("1000000", "-1", "0", "1/0", 1, True, "half"):
        if hypotheses["level"] is not None:
            yield [([*HYPOTHESES, "level"], level)]
    if hypotheses["rate"] is not None:
        for kappa in ("1000000", "-1", "0", "1/0"):
            yield [([*HYPOTHESES, "rate", "kappa"], kappa)]
        yield [([*HYPOTHESES, "rate", "kind"], "hyperbolic")]
        yield [([*HYPOTHESES, "rate", "function"], "0")]
    else:
        yield [([*HYPOTHESES, "rate"], {"kind": "finite", "kappa": "1000"})]
    for verdict in ("exponentially stable", "unstable", True, None):
        yield [([*HYPOTHESES, "verdict"], verdict)]


def other_direction(good: Record) -> Iterator[Any]:
    """Directions along which V is not negative, or that are none."""
    direction = good["evidence"][0]["hypotheses"].get("direction")
    if direction is None:
        return
    where = [*HYPOTHESES, "direction"]
    yield [(where, ["0"] * len(direction))]
    yield [(where, [*direction, "0"])]
    yield [(where, direction[1:])]
    yield [(where, None)]
    if good["evidence"][0]["theorem"] == "departure":
        yield [(where, [f"-{own}" if own != "0" else own for own in direction])]


def other_parts(good: Record) -> Iterator[Any]:
    """Parts that are left out, twice there or in another order, and other surfaces and states that they give."""
    hypotheses = good["evidence"][0]["hypotheses"]
    if "parts" in hypotheses:
        own, where = hypotheses["parts"], [*HYPOTHESES, "parts"]
        for wrong in ([], own + own[:1], [{**part, "states": []} for part in own], None):
            yield [(where, wrong)]
        yield [([*where, 0, "states"], [*own[0]["states"], "q"])]
        yield [([*where, 0, "entry", "proofs"], {})]
    if "entry" in hypotheses:
        for key, wrong in (("surface", 1), ("surface", -1), ("state", "q"), ("state", 0), ("entry", None)):
            yield [([*HYPOTHESES, key], wrong)]
        yield [([*HYPOTHESES, "entry", "proofs"], {})]
        yield [([*HYPOTHESES, "entry", "theorem"], "outside")]


def other_choice(good: Record) -> Iterator[Any]:
    """A choice of what is no right-hand side, or no mixture of them, and theorems that one choice does not decide."""
    hypotheses = good["evidence"][0]["hypotheses"]
    if "choice" not in hypotheses:
        return
    where = [*HYPOTHESES, "choice"]
    for wrong in (-1, 64, "0", True, None, {}, {"surface": ["2"], "first": 0, "second": 1}):
        yield [(where, wrong)]
    for surface in ("x)*9 + (x", "1j", ["1/0"], ["-9/8"], [], 0):
        yield [(where, {"surface": surface, "first": 0, "second": 1})]
    for theorem in ("lyapunov", "choice", "outside", None):
        yield [([*HYPOTHESES, "theorem"], theorem)]
    yield [([*CLAIMS, 1], {"equilibrium": False})]


def other_reflection(good: Record) -> Iterator[Any]:
    """What is no reflection, or does not reverse the field."""
    if "mirror" not in good["evidence"][0]["hypotheses"]:
        return
    one, none = ["1", "0"], ["0", "1"]
    for wrong in (
        [one, none],
        [["-1", "0"], ["0", "-1"]],
        [one, ["0", "-2"]],
        [["3/5", "4/5"], ["4/5", "-3/5"]],
        [one],
        "1",
        [],
    ):
        yield [([*HYPOTHESES, "mirror"], wrong)]


def other_integral(good: Record) -> Iterator[Any]:
    """Other integrating factors, and some that are zero at the point, or no functions."""
    hypotheses = good["evidence"][0]["hypotheses"]
    if "factors" not in hypotheses:
        return
    for wrong in ("x", "1", "1/x", "exp(x)", hypotheses["exponent"] + " + y", None, 0):
        yield [([*HYPOTHESES, "exponent"], wrong)]
    pairs: list[Any] = [["x", "-1"], ["1 + x + y", "1/3"], ["1 + x", "x"], ["1 + x"], ["0", "1"], ["1", 1], {}]
    for pair in pairs:
        yield [([*HYPOTHESES, "factors"], [pair])]


def other_turning(good: Record) -> Iterator[Any]:
    """Weights with which the lowest terms do not turn, of other cells, or none; the other sense, or none."""
    hypotheses = good["evidence"][0]["hypotheses"]
    if "sense" not in hypotheses:
        return
    weights = hypotheses["weights"]
    for pair in (["5", "1"], ["1", "7/2"], ["-1", "-1"], ["0", "0"], ["1"], [1, 1], "1"):
        yield [([*HYPOTHESES, "weights"], dict.fromkeys(weights, pair))]
    for wrong in ({}, {**weights, "--": ["1", "1"]}, list(weights), None):
        yield [([*HYPOTHESES, "weights"], wrong)]
    for sense in (-hypotheses["sense"], 0, 2, "1", True, None):
        yield [([*HYPOTHESES, "sense"], sense)]


def other_denominator(good: Record) -> Iterator[Any]:
    """Quotients that are not positive, not zero at the point, or no polynomials."""
    if "denominator" not in good["evidence"][0]["hypotheses"]:
        return
    for wrong in ("x**2 - y**2", "x**2", "-1", "0", "x**2 + y**2 + x**4", "Abs(x) + 1", "(x**2 + y**2)**3", 1, "1/x"):
        yield [([*HYPOTHESES, "denominator"], wrong)]
    yield [([*HYPOTHESES, "denominator"], GONE)]


def other_mixture(good: Record) -> Iterator[Any]:
    """A solution that leaves: weights, cells, barriers, a subspace or a function that do not fit."""
    hypotheses = good["evidence"][0]["hypotheses"]
    if "mixture" not in hypotheses:
        return
    where = [*HYPOTHESES, "mixture"]
    count = len(good["statement"]["subject"]["states"])
    yield [(where, [])]
    for k, (cell, _, weight, _) in enumerate(hypotheses["mixture"]):
        for other in ("0", f"-({weight})", "x", "sign(x)", f"({weight}) + x**2/3 - 1/2"):
            yield [([*where, k, 2], other)]
        yield [([*where, k, 1], len(good["statement"]["subject"]["rhs"]))]
        yield [([*where, k, 1], "0")]
        yield [([*where, k, 0], cell + "+")]
        if cell:
            yield [([*where, k, 0], cell.translate(str.maketrans("+-", "-+")))]
        if "0" in hypotheses["signs"]:
            yield [([*where, k, 3], ["0"] * count)]
    if len(hypotheses["mixture"]) > 1:
        yield [(where, hypotheses["mixture"][1:])]
    for forms in (["1"], ["x"], ["x**2"], [f"{name}" for name in good["statement"]["subject"]["states"]]):
        yield [([*HYPOTHESES, "along"], forms)]
    yield [([*HYPOTHESES, "function"], f"-({hypotheses['function']})")]
    yield [([*HYPOTHESES, "function"], f"{hypotheses['function']} + 1")]
    yield [([*HYPOTHESES, "barriers"], [["-1", "0"]])]
    yield [([*HYPOTHESES, "barriers"], [["x - x**2*100", "0"]])]
    for k in range(len(hypotheses["barriers"])):
        yield [([*HYPOTHESES, "barriers", k, 1], "1000")]
    yield [([*HYPOTHESES, "signs"], hypotheses["signs"] + "+")]


def other_mesh(good: Record) -> Iterator[Any]:
    """A mesh with a hole, a fold, a lower border, a value that rises, a simplex turned over; a larger level."""
    hypotheses = good["evidence"][0]["hypotheses"]
    if "mesh" not in hypotheses:
        return
    where, own = [*HYPOTHESES, "mesh"], hypotheses["mesh"]
    kind = "triangles" if "triangles" in own else "tetrahedra"
    corners, simplices, last = own["corners"], own[kind], len(good["statement"]["claims"]) - 1
    claim = [*CLAIMS, last, "attracts", "mesh"]
    meshes = [{**own, kind: changed} for changed in (simplices[1:], simplices[:-1], [], [*simplices, simplices[0]])]
    for k, simplex in enumerate(simplices):
        a, *first, b, c = simplex.split(" ")
        start = " ".join([a, *first])
        for turned in (
            f"{start} {c} {b}",
            f"{start} {a} {b}",
            f"{start} {b} 999",
            f"{start} {b}",
            f"{start} {b} {c} ",
            f"-{start} {b} {c}",
        ):
            meshes.append({**own, kind: [*simplices[:k], turned, *simplices[k + 1 :]]})
    for k, corner in enumerate(corners):
        place = corner.rpartition(" ")[0]
        for moved in (f"{place} -9", f"{place} 1/2", place, " ".join(["0"] * (place.count(" ") + 2))):
            meshes.append({**own, "corners": [*corners[:k], moved, *corners[k + 1 :]]})
    meshes += [{**own, "unit": unit} for unit in ("4", "0", "-1/4", "1/0", 1, None)]
    for changed in meshes:
        yield [(where, changed)]
        yield [(where, changed), (claim, changed)]
    for below in (hypotheses["below"] + 1, "1", True, None, 10**6):
        yield [([*HYPOTHESES, "below"], below), ([*CLAIMS, last, "attracts", "below"], below)]
    yield [([*HYPOTHESES, "local", "level"], None)]
    yield [([*HYPOTHESES, "local", "level"], "1/64")]


def other_polygon(good: Record) -> Iterator[Any]:
    """A polygon that is turned over, that meets itself or the point, that holds it not; other corners."""
    hypotheses = good["evidence"][0]["hypotheses"]
    if not hypotheses.get("corners"):  # of a basin that ends at lines alone there are none
        return
    own, last = hypotheses["corners"], len(good["statement"]["claims"]) - 1
    claim = [*CLAIMS, last, "outside", "corners"]
    rings = [own[::-1], own[:2], [], [*own, own[0]], own * 2]
    if len(own) > 1:  # there is one alone where lines bound the rest
        rings += [[*own, own[1]], [own[1], own[0], *own[2:]]]
    for k in range(len(own)):
        for corner in ("0 0", "1 0", "0 99", "1/2 0", "1", "1 2 3", 7, f"{own[k]} "):
            rings.append([*own[:k], corner, *own[k + 1 :]])
            rings.append([*own[:k], corner, *own[k:]])
    for ring in rings:
        yield [([*HYPOTHESES, "corners"], ring), (claim, ring)]
    for unit in ("4", "0", "-1/4", "1/0", 1, None):
        yield [([*HYPOTHESES, "unit"], unit)]
    yield [([*HYPOTHESES, "surfaces"], ["y - 1"])]


def other_theorem(good: Record) -> Iterator[Any]:
    """The evidence of one theorem for another."""
    for name in ("lyapunov", "instability", "departure", "Lyapunov", "", None, "show_stability"):
        if name != good["evidence"][0]["theorem"]:
            yield [(["evidence", 0, "theorem"], name)]


def other_numbers(good: Record) -> Iterator[Any]:
    """Numbers of the evidence that are changed, or no numbers."""
    for name, own in good["evidence"][0]["proofs"].items():
        for kind, listed in own.items():
            if kind == "squares" and listed and listed[0]:
                gram: Path = [*PROOFS, name, kind, 0, 0, "gram", 0, 0]
                for value in ("-1", "1000003/7", "0/1", "1.5", 1, "1/0", "NaN", "9" * 5000):
                    yield [(gram, value)]
                yield [([*PROOFS, name, kind, 0, 0, "guards"], ["s99"])]
                yield [([*PROOFS, name, kind, 0, 0, "monomials", 0], [])]
            if kind == "simplices" and listed and isinstance(listed[0], list):
                for k, other in ((2, "0"), (2, "1"), (2, "-1/2"), (2, "3/2"), (0, 99), (0, listed[0][1]), (3, "")):
                    yield [([*PROOFS, name, kind, 0, k], other)]
            if kind == "simplices":
                yield [([*PROOFS, name, kind], listed[1:])]
                yield [([*PROOFS, name, kind, 0], {"on": ["s99"]})]
                yield [([*PROOFS, name, kind, 0], {"on": [{"s99": "1"}]})]
            if kind == "mixture" and listed and listed[0]:
                guard = next(iter(listed[0]))
                yield [([*PROOFS, name, kind, 0, guard], f"-{listed[0][guard]}")]
                yield [([*PROOFS, name, kind, 0, guard], "1000003/7")]


Kinds: TypeAlias = tuple[Callable[[Record], Iterator[Any]], ...]

KINDS: Kinds = (
    other_version,
    other_frame,
    without_evidence,
    without_one_proof,
    with_one_proof_more,
    with_empty_proofs,
    with_exchanged_proofs,
    other_field,
    other_states,
    other_claims,
    other_surfaces,
    other_cells,
    other_coordinates,
    other_function,
    other_level,
    other_direction,
    other_mixture,
    other_mesh,
    other_polygon,
    other_theorem,
    other_numbers,
    other_choice,
    other_parts,
    other_reflection,
    other_integral,
    other_turning,
    other_denominator,
)


def forgeries(name: str, good: Record, kinds: Kinds) -> dict[str, list[Forgery]]:
    """All forgeries of a good certificate, by kind."""
    found: dict[str, list[Forgery]] = {}
    for kind in kinds:
        listed = [Forgery(kind.__name__, name, tuple(own)) for own in kind(good) if own]
        if listed:
            found[kind.__name__] = listed
    return found


# ---- texts that are no certificates, or take long to check ---------------------------------------


def square(factor: str) -> Record:
    """Evidence that a positive multiple of x**2 is positive."""
    return {"squares": [[{"guards": [], "monomials": [[1]], "gram": [[factor]]}]]}


def certificate_text(
    rhs: str, surfaces: Sequence[str] = (), function: str = "x**2", proofs: Record | None = None
) -> str:
    """The text of a certificate in one state, with parts of the forger's choice; it is good for ``-x``."""
    bare = {"second": None, "verdict": "stable", "everywhere": False, "level": None, "below": False, "rate": None}
    hypotheses = {"cells": {"within": "1", "surfaces": surfaces, "empty": []}, "function": function, **bare}
    own = {"V ": square("1"), "cell  field 0": square("2")} if proofs is None else proofs
    data = {
        "version": "nonsmooth-certificate/2",
        "statement": {
            "subject": {"states": ["x"], "rhs": [[rhs]], "at": ["0"]},
            "claims": [{"stability": "stable"}],
        },
        "evidence": [{"theorem": "lyapunov", "hypotheses": hypotheses, "proofs": own}],
    }
    return json.dumps(data)


def split_text(text: str, times: int) -> tuple[tuple[str, int], ...]:
    """Pieces of a text in which ``@...@`` is repeated."""
    head, piece, tail = text.split("@")
    return (head, 1), (piece, times), (tail, 1)


def texts() -> Iterator[Forgery]:
    """Bombs of depth, digits and exponents, and documents that are no JSON."""
    for opened in ("[", '{"a":', "[[],", '{"version":['):
        for times in (1_000, 100_000):
            yield Forgery("deep document", text=((opened, times),))
    for own in ("", " ", "null", "[]", "{}", "0", "NaN", '"version"', '{"version":1', "\x00", "\ufeff{}", "{'a': 1}"):
        yield Forgery("no document", text=((own or "\n", 1),))
    for key in ("version", "statement", "evidence"):
        good = certificate_text("-x")
        yield Forgery("key twice", text=((good[:-1] + f', "{key}": null}}', 1),))
    for digits in (5_000, 50_000):
        yield Forgery("long number", text=split_text(certificate_text("-x*@9@"), digits))
        yield Forgery("long number", text=(('{"version": ', 1), ("9", digits), ("}", 1)))
    for number in ("1e999", "1e9999", "1e-999", "9e999**40", "(1e999**40)**40", "((1e999**40)**40)**40"):
        yield Forgery("large exponent", text=((certificate_text(f"-x*{number}"), 1),))
    for power in (
        "x**41",
        "x**1000000",
        "x**-1",
        "x**x",
        "x**2.0",
        "((x**40)**40)**40",
        "(1+x)**40*x",
        "x**True",
    ):
        yield Forgery("large power", text=((certificate_text(f"-{power}"), 1),))
    for opened, closed in (
        ("(", ")"),
        ("-", ""),
        ("Abs(", ")"),
        ("(x,", ""),
        ("x**", ""),
        ("x if x else ", ""),
        ("x+", ""),
    ):
        for times in (70, 300):
            text = opened * times + "x" + closed * times
            yield Forgery("deep formula", text=((certificate_text(text[:3900]), 1),))
    wrong = ["-x;", "x=-x", "lambda: -x", "(lambda: -x)()", "[-x][0]", "(-x,)", "(-x).real", "-f(x)", "-Max(*x)"]
    wrong += [
        "__import__('os')",
        "-x*'1'",
        "-x*b'1'",
        "-x + len('')",
        "f'{-x}'",
        "-x and -x",
        "-x or x",
        "not x",
        "-(x)()",
    ]
    wrong += [
        "-x*(1 < 2)",
        "~x + 1",
        "-x // 1",
        "-x @ 1",
        "-x << 0",
        "-x if 1 else x",
        "(t := -x)",
        "-x + 0*t",
        "-x*x**0x0",
    ]
    wrong += ["-0x1*x", "-x + 0j", "-x # + 2*x", "-x - \uff10", "-\uff58", "-x/0", "-x*x/x", "-x/(1-1)", "None"]
    wrong += [
        "-True*x",
        "-x + (...)",
        "y",
        "-X",
        "",
        "-sat(x)",
        "Max()",
        "-sign(x=1)*x",
        "-relu(x, x)",
        "-x ** 1.0",
    ]
    for own in wrong:
        yield Forgery("no formula", text=((certificate_text(own), 1),))
        yield Forgery("no function", text=((certificate_text("-x", function=own), 1),))
    yield Forgery("many cells", text=((certificate_text("-x", [f"x-{k}/100" for k in range(1, 64)]), 1),))
    yield Forgery("high surfaces", text=((certificate_text("-x", [f"(x+{k})**40+1" for k in range(1, 30)]), 1),))
    tree: Any = {}
    for _ in range(40):
        tree = [0, 1, "1/" + "9" * 200, tree, {}]
    long = {"V ": {"simplices": [tree, {}]}, "cell  field 0": square("2")}
    yield Forgery("long shares", text=((certificate_text("-x", function="x**40", proofs=long), 1),))
