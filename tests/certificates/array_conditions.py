"""Forged certificates of arrays that one condition of the checker refuses, and no other one; see `conditions`.

Laws of one rule under the other one are refused in any case, but by other words.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator
from fractions import Fraction
from typing import Any

from tests.array_certificates import said
from tests.certificates.corpus import good_arrays
from tests.certificates.forgeries import CLAIMS, GONE, HYPOTHESES, PROOFS, SUBJECT, Forgery, Path, Record

FOUR, BOX, OUTWARD = "four-wheel-nearest", "four-wheel-box", "outward-box"
FAILS: Record = {"feedback": "no certificate", "theorem 4": "fails"}

# A mesh of four wheels with sides below the level 1 that do not close: from corner 4 over 0, 1 and 2 to 3.
OPEN: Record = {
    "corners": ["-4 -2 0", "0 -4 0", "4 1 0", "0 4 1", "-14 -3 1", "-8 -6 1", "-4 -8 1", "6 -8 1", "14 2 1"],
    "triangles": ["0 6 1", "0 4 5", "0 5 6", "1 6 7", "1 7 2", "2 7 8", "2 8 3"],
}


def of_array(because: str, name: str, claims: Record, *changes: tuple[Path, Any]) -> Forgery:
    """A certificate of the corpus with other claims, where None leaves one out, and other changes."""
    own = {**said(good_arrays()[f"array-{name}"]), **claims}
    listed = [{kind: about} for kind, about in own.items() if about is not None]
    return Forgery("one condition", f"array-{name}", ((CLAIMS, listed), *changes), because=because)


def hypothesis(key: str, value: Any) -> tuple[Path, Any]:
    """One hypothesis of theorem 4."""
    return [*HYPOTHESES, key], value


def of_clauses() -> Iterator[Forgery]:
    """Bounds without a disc, of a body that does not rest, and over no denominator."""
    words = "a disc of starts that arrive"
    arrival: Record = {"squared_radius": None, "rate": "1"}
    yield of_array(words, FOUR, {"disc": None, "arrival": arrival}, hypothesis("disc", None))
    words = "a disc of starts, and a body that rests at the point without turning"
    turning: Record = {"squared_radius": "1/4", "per_distance": "1"}
    yield of_array(words, FOUR, {"turning": turning}, hypothesis("turn", "1"))
    turning = {"squared_radius": None, "per_distance": "0"}
    changes = hypothesis("disc", None), hypothesis("turn", "0")
    yield of_array(words, BOX, {"disc": None, "turning": turning}, *changes)
    words = "a bound of the rotation for each unit of distance"
    for name, turn in (("rectangle-box", "0"), (BOX, "-1")):
        turning = {"squared_radius": "1/4", "per_distance": turn}
        yield of_array(words, name, {"turning": turning}, hypothesis("turn", turn))
    drift: list[Any] = ["0", "0", "1"]
    words = "a direction in which all velocities at the point lead"
    yield of_array(words, "off-center-nearest", {"drift": drift}, hypothesis("drift", drift))
    quarters = {"weights": ["1/4", "0", "1/4", "0", "0", "1/4", "0", "1/4"], "multipliers": ["0", "0", "0", "1"]}
    still = [([*PROOFS, name], quarters) for name in ("lowest", "highest")]
    claims = {"drift": drift, "rotation": "stable, not attractive", "theorem 4": "fails"}
    words = "weights and multipliers of the lowest rate at rest"
    yield of_array(words, FOUR, claims, hypothesis("drift", drift), *still)
    drift = ["0", "0", "0"]
    yield of_array("a drift over a positive denominator", FOUR, {"drift": drift}, hypothesis("drift", drift))


def of_discs() -> Iterator[Forgery]:
    """Discs beyond the square or the wheels, and times of arrival for which bodies are too slow."""
    arrival: Record = {"squared_radius": "1/4"}
    for words, rate in (("a positive rate", "-1"), ("a rate at which the distance falls in the square", "1000")):
        yield of_array(words, FOUR, {"arrival": {**arrival, "rate": rate}}, hypothesis("rate", rate))
    disc = {"decreases": "strictly"}
    claims: Record = {"disc": {**disc, "squared_radius": "1"}, "arrival": {"squared_radius": "1", "rate": "1"}}
    yield of_array("a disc in the square where V* shows one", FOUR, claims, hypothesis("disc", "1"))
    claims = {"disc": {**disc, "squared_radius": "4"}, "arrival": None}
    changes = hypothesis("disc", "4"), hypothesis("rate", None)
    yield of_array("a disc in the support polygon", FOUR, claims, *changes, *larger_square())
    yield of_array("the barrier 1 0", OUTWARD, {}, ([*PROOFS, "barrier 1 0"], ["0", "0", "0"]))


def larger_square() -> tuple[tuple[Path, Any], ...]:
    """Four wheels with a square that is six times as large, beyond the wheels."""
    points = good_arrays()[f"array-{FOUR}"]["evidence"][0]["hypotheses"]["points"]
    return ([*SUBJECT, "radius"], "3"), hypothesis("points", scaled(points, 6))


def of_feedback() -> Iterator[Forgery]:
    """Laws for which nothing speaks, and planes that hold not all motions."""
    law: Path = [*PROOFS, "feedback"]
    signs = (law, {"signs": [1] * 8})
    yield of_array("no evidence of a clause that does not apply", "four-wheel-side-nearest", {}, signs)
    for plane in (["0", "0", "0"], ["0", "0", "1"]):
        claims = {**FAILS, "obstruction": plane}
        yield of_array("a plane of all motions", FOUR, claims, (law, {"plane": plane}))
    yield of_array("a sign, 1 or -1, of each motion at the point", FOUR, {}, (law, {"signs": [2] + [1] * 7}))
    claims = {"feedback": "stabilizable", "obstruction": None, "theorem 4": "holds"}
    words = "signs of translations that all lead inward"
    yield of_array(words, "differential-drive-nearest", claims, (law, {"signs": [1, 1]}))
    yield of_array("three twists, under rule box", "conveyor-3-box", {}, (law, {"signs": [1]}))
    twists = [["1", "0", "0"], ["0", "1", "0"], ["0", "0", "1"]]
    yield of_array("signs of translations, under rule nearest", FOUR, {}, (law, {"twists": twists}))


def of_wheels_in_a_line() -> Iterator[Forgery]:
    """Wheels that roll along the line on which they stand, said to bring a body home from beside it."""
    wheel = {"direction": ["1", "0"], "speed": "0", "friction": ["1", "1/2"]}
    subject = {
        **{"field": [], "at": ["0", "0"], "radius": "1/2", "rule": "box", "loads": [["1", "0", "0"]] * 2},
        "wheels": [{**wheel, "position": [x, "0"]} for x in ("1", "-1")],
    }
    points = [["1/2", "1/2", "1"], ["-1/2", "1/2", "1"], ["-1/2", "-1/2", "1"], ["1/2", "-1/2", "1"]]
    cell = {"polygon": [0, 1, 2, 3], "wheels": None, "twists": [["0", "0", "0"]]}
    end = {"weights": ["1"], "multipliers": ["0", "0", "0", "1"]}
    twists = [["0", "1", "0"], ["1", "1", "0"], ["0", "2", "1"]]
    proofs = {"lowest": end, "highest": end, "feedback": {"twists": twists}}
    claims = {"feedback": "stabilizable", "disc": None, "drift": None}
    changes = ((SUBJECT, subject), (HYPOTHESES, {"points": points, "cells": [cell], "disc": None}), (PROOFS, proofs))
    yield of_array("tight rows of rank three", BOX, claims, *changes)


def of_law() -> Iterator[Forgery]:
    """Rates of laws of wheels that do not roll so, about no point, or with other forms."""

    def law(because: str, name: str, claims: Record | None = None, *changes: tuple[Path, Any], **own: Any) -> Forgery:
        stated = {"form": ["1", "0", "1"], "weight": "1", "kappa": "1/1000", "squared_reach": None, **own}
        claim = {key: value for key, value in stated.items() if key not in ("slack", "least")}
        return of_array(because, name, {**(claims or {}), "feedback rate": claim}, hypothesis("law", stated), *changes)

    yield law("rolling rows of wheels with rims, under rule nearest", "four-wheel-side-nearest")
    yield law("a positive weight and rate", FOUR, kappa="-1")
    far: Record = {"squared_reach": "1000000", "slack": "1", "least": "1"}
    yield law("a distance at which the rotation adds little to V", FOUR, form=["1", "0", "2"], **far)
    yield law("a distance within which the rate holds", FOUR, form=["1", "0", "2"])
    yield law("cells at the point of less than a half plane", "differential-drive-nearest")
    yield law("a positive quadratic form", FOUR, form=["-1", "0", "-1"])
    yield law("a rate at which the law lets V fall", FOUR, kappa="100")


def of_tolerances() -> Iterator[Forgery]:
    """Bounds and tolerances for which nothing is shown."""
    name, where = "four-wheel-tolerances", ["evidence", 1, "hypotheses"]
    wheels: Path = [*SUBJECT, "wheels"]
    good = good_arrays()[f"array-{name}"]
    bounds = said(good)["tolerances"]
    alone = (["evidence"], good["evidence"][1:])
    others: Record = dict.fromkeys(said(good))

    def bound(because: str, **own: str) -> Forgery:
        stated = {**bounds, **own}
        return of_array(because, name, {"tolerances": stated}, (where, stated))

    def built(because: str, *changes: tuple[Path, Any]) -> Forgery:
        return of_array(because, name, {**others, "tolerances": bounds}, alone, *changes)

    sound = "tolerances, and bounds within the square"
    yield bound("at most 200 characters", rate=f"{'0' * 200}{bounds['rate']}")
    yield bound(sound, rate=f"-{bounds['rate']}")
    yield bound(sound, radius="1")
    yield bound("a rate outside the disc", rate="1000")
    yield built("tolerances, under rule nearest", ([*SUBJECT, "rule"], "box"), ([*SUBJECT, "loads"], "elastic"))
    one = good["statement"]["subject"]["wheels"][0]
    yield built("two wheels at least, which fix the motion", (wheels, [one]))
    yield built(sound, ([*wheels, 0, "axis"], one["direction"]))
    yield built(sound, ([*SUBJECT, "tolerances", "speed"], "-1/50"))
    exact = ([*SUBJECT, "tolerances"], dict.fromkeys(good["statement"]["subject"]["tolerances"], "0"))
    tiny = {**bounds, "radius": f"1/{2**70}"}
    words = "discs of sizes that differ less"
    yield of_array(words, name, {**others, "tolerances": tiny}, alone, exact, (["evidence", 0, "hypotheses"], tiny))
    yield built("numbers of moderate size", *(([*wheels, k, "speed"], str(2**140)) for k in range(4)))
    yield built("friction in both directions", ([*wheels, 0, "friction"], ["1", "0"]))
    outward = [{**own, "speed": "-1"} for own in good["statement"]["subject"]["wheels"]]
    yield built("a rate outside the disc", (wheels, outward))
    yield built("a rate outside the disc", ([*SUBJECT, "tolerances", "heading"], "1/10"))


def of_array_cells() -> Iterator[Forgery]:
    """Cells that are not convex, hide the point, or of which other wheels, or none, move the body."""
    cells: Path = [*HYPOTHESES, "cells"]
    good = good_arrays()[f"array-{FOUR}"]["evidence"][0]["hypotheses"]
    back = [[x, y, "-1"] for x, y, _ in good["points"]]
    yield of_array("points with positive weights", FOUR, {}, hypothesis("points", back))
    yield of_array("a positive radius", FOUR, {}, ([*SUBJECT, "radius"], "-1/2"))
    yield of_array("a rule, nearest or box, and loads under box", FOUR, {}, ([*SUBJECT, "loads"], "elastic"))
    first = good["cells"][0]
    parts = [{**first, "polygon": polygon} for polygon in ([0, 1, 9], [0, 9, 1, 2])]
    changes: tuple[tuple[Path, Any], ...]
    changes = hypothesis("points", [*good["points"], ["1/8", "3/8", "1"]]), (cells, [*parts, *good["cells"][1:]])
    yield of_array("cell 1: a convex polygon, counterclockwise", FOUR, {}, *changes)
    yield of_array("cell 0: wheels that the rule takes", FOUR, {}, ([*cells, 0, "wheels"], [1, 1, 2]))

    other = {**good["cells"][2], **{key: good["cells"][3][key] for key in ("wheels", "twists")}}
    claims = {"disc": {"squared_radius": "1/4", "decreases": "weakly"}, "arrival": None, "feedback rate": None}
    changes = ([*cells, 2], other), hypothesis("rate", None), hypothesis("law", None)
    yield of_array("cell 2: wheels by their distance, at every corner", FOUR, claims, *changes)

    good = good_arrays()["array-differential-drive-nearest"]["evidence"][0]["hypotheses"]
    halves = [{**own, "polygon": [k for k in own["polygon"] if k != 6]} for own in good["cells"]]
    changes = hypothesis("points", good["points"][:-1]), (cells, halves)
    yield of_array("cell 0: the checked point as a corner", "differential-drive-nearest", {}, *changes)

    good = good_arrays()[f"array-{OUTWARD}"]["evidence"][0]
    still = [{**own, "twists": [["0", "0", "0"]]} for own in good["hypotheses"]["cells"]]
    claims = {"disc": {"squared_radius": "1/4", "decreases": "weakly"}}
    claims["turning"] = {"squared_radius": "1/4", "per_distance": "0"}
    barriers = (([*PROOFS, name], GONE) for name in good["proofs"] if name.startswith("barrier"))
    yield of_array(
        "cell 1: all twists that minimize D", OUTWARD, claims, (cells, still), hypothesis("disc", "1/4"), *barriers
    )


def scaled(points: list[list[str]], factor: int) -> list[list[str]]:
    """Corners with rational places so many times as far from the point."""
    return [[str(factor * Fraction(x)), str(factor * Fraction(y)), w] for x, y, w in points]


def of_ellipses() -> Iterator[Forgery]:
    """Ellipses about the point that reach beyond the cells or the wheels, hold no disc, or are left ever faster."""
    beyond: Record = {"sides": False}
    for words, size, changes, more in (
        ("an ellipse inside the cells at the point", "1/4", (), {}),
        ("an ellipse inside the cells at the point", "1/4", (), {"sides": True}),
        ("true, where the lines of sides are crossed beyond these", "1/100", (), beyond),
        ("an ellipse in the support polygon", "4", larger_square(), {}),
    ):
        swing = {"squared_radius": size, "squared_swing": size}
        ellipse = {**swing, "form": ["1", "0", "1"], "level": size, "bend": "0", "arrival": None, **more}
        yield of_array(words, FOUR, {"swing": swing}, hypothesis("ellipse", ellipse), *changes)

    name = "cocircular-16"
    own = good_arrays()[f"array-{name}"]["evidence"][0]["hypotheses"]["ellipse"]
    words = "an ellipse that holds the disc of starts"
    yield of_array(words, name, {}, hypothesis("ellipse", {**own, "level": "0"}))
    words = "a bound of what the rotation adds to V"
    yield of_array(words, name, {}, hypothesis("ellipse", {**own, "bend": f"-{own['bend']}"}))
    arrival = {"squared_radius": own["squared_radius"], "rate": "-1/4"}
    back = {**own, "arrival": {**own["arrival"], "rate": "-1/4"}}
    words = "a rate at which bodies arrive"
    yield of_array(words, name, {"arrival": arrival}, hypothesis("ellipse", back))
    slow = {**own["arrival"], "speeds": ["1/3", *own["arrival"]["speeds"][1:]], "rate": "1/4"}
    claims = {"arrival": {"squared_radius": own["squared_radius"], "rate": "1/4"}}
    words = "positive speeds, the largest first"
    yield of_array(words, name, claims, hypothesis("ellipse", {**own, "arrival": slow}))
    start = own["squared_radius"]
    for words, claims, more in (
        ("a level that holds the disc of starts", {}, {"arrival": {**own["arrival"], "level": "0"}}),
        ("a speed at which V falls in the cells at the point", {}, {"arrival": {**own["arrival"], "speeds": ["1000"]}}),
        (
            "an ellipse in the disc that bodies stay in",
            {"swing": {"squared_radius": start, "squared_swing": "1/100000"}},
            {"squared_swing": "1/100000"},
        ),
        (
            "a body that arrives, and rests at the point without turning",
            {"turning": {"squared_radius": start, "per_distance": "100000"}},
            {"turn": "100000"},
        ),
    ):
        yield of_array(words, name, claims, hypothesis("ellipse", {**own, **more}))


def of_basins() -> Iterator[Forgery]:
    """Meshes of arrays beyond the wheels or the square, and ends that are no polygon in the disc."""
    name = "four-wheel-basin"
    where: Path = ["evidence", 1, "hypotheses"]
    points = good_arrays()[f"array-{name}"]["evidence"][1]["hypotheses"]["points"]
    wide = ([*where, "within"], "3"), ([*where, "points"], scaled(points, 6))
    yield of_array("a square in the support polygon", name, {}, *wide)
    mesh = good_arrays()[f"array-{name}"]["evidence"][1]["hypotheses"]["mesh"]

    def ends(because: str, *changes: tuple[Path, Any], below: Any = 2, **own: Any) -> Forgery:
        stated = {**mesh, **own}
        changes = ([*where, "mesh"], stated), ([*where, "below"], below), *changes
        return of_array(because, name, {"attracts": {"mesh": stated, "below": below}}, *changes)

    disc: Path = [*where, "squared_radius"]
    yield ends("a level that is a whole number", below=True)
    yield ends("one polygon in which bodies end", below=3)
    yield ends("one polygon in which bodies end", (disc, "1/16"), below=1, **OPEN)  # whose first side is left out
    yield ends("a polygon in the disc in which bodies end", (disc, "1/100000"))
    yield ends("a mesh inside the square", (disc, "1"), unit="1/20")
    weight = Fraction(1, 3**57)
    tiny = [[str(weight * Fraction(own)) for own in point] for point in points]
    yield of_array("corners that are enclosed", name, {}, ([*where, "points"], tiny))

    # wheels that turn outward, at places that are those of the mesh times a negative number
    good = good_arrays()[f"array-{name}"]
    entry = copy.deepcopy(good["evidence"][1])
    own = entry["hypotheses"]
    for cell in own["cells"]:
        cell["twists"] = [list(map(opposite, twist)) for twist in cell["twists"]]
    own["mesh"] = {"unit": "-1/32", "corners": mesh["corners"][:8], "triangles": mesh["triangles"][:8]}
    own["below"] = 1
    stated = {"mesh": own["mesh"], "below": 1, "squared_radius": own["squared_radius"]}
    claims = {**dict.fromkeys(said(good)), "ends": stated}
    outward = [([*SUBJECT, "wheels", k, "speed"], "-1") for k in range(4)]
    yield of_array("a positive unit", name, claims, (["evidence"], [entry]), *outward)


def opposite(number: Any) -> Any:
    """The number of a field times -1: a text, or a list of products that begin with their factor."""
    if isinstance(number, str):
        return str(-Fraction(number))
    return [[opposite(factor), *rest] for factor, *rest in number]


def array_conditions() -> Iterator[Forgery]:
    """All of them."""
    for kind in (
        of_clauses,
        of_discs,
        of_feedback,
        of_wheels_in_a_line,
        of_law,
        of_tolerances,
        of_array_cells,
        of_ellipses,
        of_basins,
    ):
        yield from kind()
