"""Arrays whose certificates are kept in the corpus, and what is forged of them."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path as FilePath
from typing import Any

import nonsmooth.symbolic
from nonsmooth.proofs.certificate import build_certificate
from nonsmooth.proofs.theorem4 import check_cells
from nonsmooth.symbolic.files.scene_file import load_scene
from tests.certificates.cases import diamonds
from tests.certificates.corpus import PREFIX
from tests.certificates.forgeries import (
    CLAIMS,
    GONE,
    HYPOTHESES,
    PROOFS,
    SUBJECT,
    Forgery,
    Kinds,
    Record,
    other_frame,
    other_version,
    with_one_proof_more,
    without_evidence,
    without_one_proof,
)
from tests.conftest import Arrays

SCENES = (
    ("four-wheel", "nearest"),
    ("four-wheel", "box"),
    ("four-wheel-side", "nearest"),
    ("four-wheel-side", "box"),
    ("rectangle", "nearest"),
    ("rectangle", "box"),
    ("ring-3", "nearest"),
    ("ring-3", "box"),
    ("ring-5", "nearest"),
    ("ring-6", "nearest"),
    ("ring-6", "box"),
    ("elliptic", "nearest"),
    ("spiral-30", "nearest"),
    ("spiral-30", "box"),
    ("conveyor-3", "nearest"),
    ("conveyor-3", "box"),
    ("saddle", "nearest"),
    ("saddle", "box"),
    ("outward", "nearest"),
    ("outward", "box"),
    ("off-center", "nearest"),
    ("off-center", "box"),
    ("differential-drive", "nearest"),
    ("differential-drive", "box"),
    ("omni-3", "nearest"),
    ("omni-3", "box"),
    ("mecanum-4", "nearest"),
    ("mecanum-4", "box"),
    ("roller-bed", "nearest"),
    ("roller-bed", "box"),
)
BY_ANOTHER_FUNCTION = (16, 63)  # arrays that attract although |c|^2 grows; the law of the second is by another P
TOLERANCES = '[tolerance]\nposition = "1/50"\nheading = "1 deg"\nspeed = "1/50"\nmu_roll = "1/5"\nmu_side = "1/5"\n'
BUILT_IN = FilePath(nonsmooth.symbolic.__path__[0]) / "scenes"


def array_certificates() -> Iterator[tuple[str, Record]]:
    """Certificates of small arrays by name, written now."""
    for name, rule in SCENES:
        yield f"{PREFIX}{name}-{rule}", build_certificate(check_cells(load_scene(name, rule=rule)))
    for seed in BY_ANOTHER_FUNCTION:
        yield f"{PREFIX}cocircular-{seed}", build_certificate(check_cells(Arrays().cocircular(seed)))
    with tempfile.TemporaryDirectory() as folder:
        path = FilePath(folder) / "four-wheel-tolerances.toml"
        text = (BUILT_IN / "four-wheel.toml").read_text(encoding="utf-8")
        path.write_text(f"{text}\n{TOLERANCES}", encoding="utf-8")
        yield f"{PREFIX}four-wheel-tolerances", build_certificate(check_cells(load_scene(str(path))))
    yield f"{PREFIX}four-wheel-basin", with_basin(build_certificate(check_cells(load_scene("four-wheel"))))


def with_basin(good: Record) -> Record:
    """The certificate of four wheels with one theorem more: diamonds from which bodies come to the point."""
    own = good["evidence"][0]["hypotheses"]
    shared = {name: own[name] for name in ("points", "cells")}
    mesh = {"mesh": diamonds((2, 8, 15), unit="1/32"), "below": 2}
    hypotheses = {"within": good["statement"]["subject"]["radius"], **shared, **mesh, "squared_radius": "1/256"}
    claims = [*good["statement"]["claims"], {"attracts": mesh}]
    entry = {"theorem": "basin", "hypotheses": hypotheses, "proofs": {}}
    statement = {**good["statement"], "claims": claims}
    return {**good, "statement": statement, "evidence": [*good["evidence"], entry]}


# ---- each kind gives the changes that it makes to a good certificate ------------------------------


def half(number: str) -> str:
    """Of a rational number."""
    return str(Fraction(number) / 2)


def other_cells(good: Record) -> Iterator[Any]:
    """A cell less, twice, clockwise, with a corner less; no cells."""
    cells = good["evidence"][0]["hypotheses"]["cells"]
    where = [*HYPOTHESES, "cells"]
    for k, cell in enumerate(cells):
        yield [(where, [*cells[:k], *cells[k + 1 :]])]
        yield [([*where, len(cells)], cell)]
        yield [([*where, k, "polygon"], cell["polygon"][::-1])]
        yield [([*where, k, "polygon"], cell["polygon"][1:])]
        yield [([*where, k, "polygon", 0], -1)]
        yield [([*where, k, "area"], "1")]
    yield [(where, [])]


def other_points(good: Record) -> Iterator[Any]:
    """A corner at another place, without a weight, or one that no cell has."""
    points = good["evidence"][0]["hypotheses"]["points"]
    where = [*HYPOTHESES, "points"]
    for k, (x, y, _) in enumerate(points):
        yield [([*where, k], [x, y, "0"])]
        yield [([*where, k], [x, y, "-1"])]
        yield [([*where, k], ["1/97", y, "1"])]
        yield [([*where, len(points)], points[k])]


def other_twists(good: Record) -> Iterator[Any]:
    """A twist that is changed, left out, or listed twice."""
    for k, cell in enumerate(good["evidence"][0]["hypotheses"]["cells"]):
        where = [*HYPOTHESES, "cells", k, "twists"]
        yield [(where, cell["twists"][1:])]
        yield [(where, [*cell["twists"], ["1", "1/3", "1/7"]])]
        for entry in range(3):
            yield [([*where, 0, entry], "1000003/7")]
            yield [([*where, 0, entry], 1)]


def other_acting(good: Record) -> Iterator[Any]:
    """Other wheels that act in a cell."""
    count = len(good["statement"]["subject"]["wheels"])
    for k, cell in enumerate(good["evidence"][0]["hypotheses"]["cells"]):
        where, own = [*HYPOTHESES, "cells", k, "wheels"], cell["wheels"]
        yield [(where, [] if own is None else None)]
        yield [(where, [count + 1])]
        if own is not None:
            yield [(where, own[1:])]
            yield [(where, [0, *own])]
            yield [(where, [str(number) for number in own])]
            yield [(where, [True, *own[1:]])]


def other_array(good: Record) -> Iterator[Any]:
    """Another subject: a wheel less, moved, driven otherwise, of other friction; another point or square."""
    subject = good["statement"]["subject"]
    for k, wheel in enumerate(subject["wheels"]):
        where = [*SUBJECT, "wheels", k]
        along, across = wheel["friction"]
        yield [([*where, "friction"], [across, along])] if along != across else None
        yield [([*where, "friction"], [along, "-1"])]
        yield [([*where, "direction"], ["1", "1"])]
        yield [([*where, "position", 0], "1/13")]
        yield [([*where, "speed"], "1000003/7")]
        yield [([*where, "axis"], ["1", "1"])]
        yield [([*where, "mass"], "1")]
        yield [(where, GONE)]
    radius = subject["radius"]
    for other in ("0", "-1", "1000", *([half(radius)] if isinstance(radius, str) else [])):
        yield [([*SUBJECT, "radius"], other)]
    yield [([*SUBJECT, "at", 0], "1/11")]
    yield [([*SUBJECT, "rule"], "ellipse")]
    yield [([*SUBJECT, "loads"], "elastic" if subject["rule"] == "nearest" else None)]
    yield [([*SUBJECT, "rule"], "box" if subject["rule"] == "nearest" else "nearest")]


def other_numbers(good: Record) -> Iterator[Any]:
    """Generators without a root, with several, or too many; numbers of no form."""
    field = good["statement"]["subject"]["field"]
    where = [*SUBJECT, "field"]
    for k in range(len(field)):
        yield [([*where, k, "above"], "-1")]
        yield [([*where, k, "above"], "1000")]
        yield [([*where, k, "polynomial", 0], "1")]
        yield [([*where, k, "polynomial"], ["-6", "11", "-6", "1"])]
        yield [([*where, k, "polynomial"], [])]
        yield [([*where, k, "polynomial"], ["-1", *["0"] * 400, "1"])]
    yield [(where, field * 500 or [{"polynomial": ["-2", "0", "1"], "above": "0"}] * 500)]
    wrong: tuple[Any, ...] = ("1.0", "1e9", "NaN", "1/0", "9" * 5000, 1, True, None, [], [[]], [["1", 99]], [["1", -1]])
    for number in (*wrong, [["1", *[0] * 65]], [["1", "0"]], {"1": 1}):
        yield [([*SUBJECT, "wheels", 0, "speed"], number)]


WORDS: dict[str, tuple[Any, ...]] = {
    "equilibrium": (True, False, 1, "holds"),
    "translation": ("asymptotically stable", "stable", "unstable", "undecided"),
    "rotation": ("unstable", "stable, not attractive", "asymptotically stable"),
    "feedback": ("stabilizable", "no certificate", "not applicable"),
    "theorem 4": ("holds", "fails", "hypotheses not met", "undecided"),
    "obstruction": (["0", "0", "1"], None),
    "disc": ({"squared_radius": "1000", "decreases": "strictly"}, {"squared_radius": "1/97", "decreases": "weakly"}),
    "arrival": ({"squared_radius": "1/4", "rate": "1000"}, {"squared_radius": "1000", "rate": "1/1000"}),
    "tolerances": ({"radius": "1/1000", "start": "1/8", "rate": "1"},),
    "stability": ("stable",),
}


def other_claims(good: Record) -> Iterator[Any]:
    """A claim more, of another word than what is shown."""
    claims = good["statement"]["claims"]
    for kind, words in WORDS.items():
        for word in words:
            if {kind: word} not in claims or word == 1:
                yield [([*CLAIMS, len(claims)], {kind: word})]
    for more in ({}, None, "holds", [claims[0]], {**claims[0], **claims[-1]}):
        yield [([*CLAIMS, len(claims)], more)]


def other_disc(good: Record) -> Iterator[Any]:
    """A disc that is too large, or of no size."""
    wrong: tuple[Any, ...] = ("1000", "0", "-1", "1/0", 1, [])
    for disc in wrong:
        yield [([*HYPOTHESES, "disc"], disc)]


def other_rate(good: Record) -> Iterator[Any]:
    """A rate of arrival that is too fast, or none; the claim says the same."""
    disc, claims = good["evidence"][0]["hypotheses"]["disc"], good["statement"]["claims"]
    place = next((k for k, own in enumerate(claims) if "arrival" in own), len(claims))
    wrong: tuple[Any, ...] = ("1000", "0", "-1", "1/0", 1, [])
    for rate in wrong:
        arrival = {"squared_radius": disc, "rate": rate}
        yield [([*HYPOTHESES, "rate"], rate), ([*CLAIMS, place], {"arrival": arrival})]
        yield [([*CLAIMS, place], {"arrival": arrival})]


def restated(good: Record, where: tuple[str, ...], value: Any) -> Any:
    """The hypotheses with another value at a place, and the claims that repeat it."""
    changes: list[Any] = [([*HYPOTHESES, *where], value)]
    for k, claim in enumerate(good["statement"]["claims"]):
        ((kind, about),) = claim.items()
        if (kind, where) == ("drift", ("drift",)):
            changes.append(([*CLAIMS, k, kind], value))
        elif kind in REPEATED.get(where[:-1], ()) and where[-1] in about:
            changes.append(([*CLAIMS, k, kind, where[-1]], value))
        elif (kind, where) in (("turning", ("turn",)), ("turning", ("ellipse", "turn"))):
            changes.append(([*CLAIMS, k, kind, "per_distance"], value))
    return changes


REPEATED: dict[tuple[str, ...], tuple[str, ...]] = {
    ("ellipse",): ("swing", "arrival", "turning"),
    ("ellipse", "arrival"): ("arrival",),
    ("law",): ("feedback rate",),
}
BOUNDS: tuple[tuple[tuple[str, ...], tuple[Any, ...]], ...] = (
    (("drift",), (["-1000", "1000", "1"], ["0", "0", "1/2"], ["1", "1", "0"], ["1", "-1", "-1"], [])),
    (("turn",), ("1000003", "-1", "0", "NaN", [])),
    (("ellipse", "squared_radius"), ("1000", "0", "-1")),
    (("ellipse", "form"), (["1", "2", "1"], ["0", "0", "0"], ["-1", "0", "-1"], ["1"])),
    (("ellipse", "level"), ("1000", "0", "-1", "1/1000000")),
    (("ellipse", "squared_swing"), ("1/1000000", "0", "-1")),
    (("ellipse", "bend"), ("0", "-1")),
    (("ellipse", "turn"), ("1000003", "0")),
    (("ellipse", "arrival", "rate"), ("1000", "0", "-1")),
    (("ellipse", "arrival", "speeds"), ([], ["1000"], ["1/9", "1/8"], ["0"], ["1/1000"] * 65)),
    (("ellipse", "arrival", "bend"), ("0", "-1")),
    (("ellipse", "arrival", "level"), ("1/1000000", "-1")),
    (("ellipse", "arrival", "form"), (["1", "2", "1"],)),
    (("law", "kappa"), ("1000", "0", "-1", "1/0")),
    (("law", "weight"), ("0", "-1", "1/1000003")),
    (("law", "form"), (["1", "1/3", "1"], ["1", "0", "-1"])),
    (("law", "squared_reach"), ("1000003", "0", "-1")),
    (("law", "least"), ("1000", "0")),
    (("law", "slack"), ("0", "-1/2")),
)


def other_bounds(good: Record) -> Iterator[Any]:
    """Numbers beside the verdicts that are too good, or none; the claims say the same."""
    hypotheses = good["evidence"][0]["hypotheses"]
    for where, values in BOUNDS:
        holder: Any = hypotheses
        for key in where[:-1]:
            holder = holder.get(key) if isinstance(holder, dict) else None
        if not isinstance(holder, dict) or where[-1] not in holder:
            continue
        for value in values:
            if value != holder[where[-1]]:
                yield restated(good, where, value)
        yield [([*HYPOTHESES, *where], GONE)]


def bounds_elsewhere(good: Record) -> Iterator[Any]:
    """Bounds of another array, and claims of bounds without any."""
    claims, hypotheses = good["statement"]["claims"], good["evidence"][0]["hypotheses"]
    law = {"form": ["1", "0", "1"], "weight": "1", "kappa": "1000", "squared_reach": None}
    yield [([*HYPOTHESES, "law"], law), ([*CLAIMS, len(claims)], {"feedback rate": law})]
    start = {"squared_radius": "1/1000"}
    for claim in (
        {"swing": {**start, "squared_swing": "1/1000"}},
        {"turning": {**start, "per_distance": "1/1000"}},
        {"feedback rate": law},
        {"drift": ["0", "0", "7"]},
    ):
        yield [([*CLAIMS, len(claims)], claim)]
    if hypotheses["disc"] is None or good["statement"]["claims"][-1] != {"theorem 4": "fails"}:
        turning = {"squared_radius": hypotheses["disc"], "per_distance": "1000003"}
        yield [([*HYPOTHESES, "turn"], "1000003"), ([*CLAIMS, len(claims)], {"turning": turning})]


LAWS: tuple[Record, ...] = (
    {"signs": [1]},
    {"twists": [["1", "0", "0"]] * 3},
    {"plane": ["0", "0", "0"]},
    {"law": []},
    {},
)


def other_proofs(good: Record) -> Iterator[Any]:
    """Weights, multipliers, separators, barriers and laws that show nothing."""
    proofs = good["evidence"][0]["proofs"]
    for name, own in proofs.items():
        where = [*PROOFS, name]
        if name in ("lowest", "highest"):
            yield [([*where, "weights"], ["0"] * len(own["weights"]))]
            yield [([*where, "weights", 0], "-1")]
            yield [([*where, "weights"], own["weights"][1:])]
            yield [([*where, "multipliers"], ["0"] * 4)]
            yield [([*where, "multipliers", 2], "1000")]
        elif name == "separator":
            yield [(where, ["0", "0"])]
            yield [(where, own[:1])]
        elif name.startswith("barrier"):
            yield [(where, ["0", "0", "0"])]
            yield [(where, ["1000", "1000", "-1"])]
        for law in LAWS:
            yield [([*PROOFS, "feedback"], law)]
        yield [(where, None)]
    yield [([*PROOFS, "separator"], ["1", "0"])] if "separator" not in proofs else None


def other_tolerances(good: Record) -> Iterator[Any]:
    """Larger tolerances, a smaller disc, a faster rate."""
    if "tolerances" not in good["statement"]["subject"]:
        bounds = {"radius": "1/16", "start": "1/8", "rate": "1/8"}
        entry = {"theorem": "tolerances", "hypotheses": bounds, "proofs": {}}
        yield [(["evidence", 1], entry), ([*CLAIMS, 0], {"tolerances": bounds})]
        return
    claims = good["statement"]["claims"]
    k = next(k for k, own in enumerate(claims) if "tolerances" in own)
    for key, value in (("radius", "1/1000"), ("rate", "1000"), ("start", "10"), ("start", "1/1000"), ("rate", "0")):
        yield [(["evidence", 1, "hypotheses", key], value), ([*CLAIMS, k, "tolerances", key], value)]
    sizes: tuple[Any, ...] = (
        ("position", "1"),
        ("heading", "1/2"),
        ("speed", "2"),
        ("mu_side", "-1"),
        ("mu_roll", GONE),
    )
    for key, value in sizes:
        yield [([*SUBJECT, "tolerances", key], value)]


def other_basin(good: Record) -> Iterator[Any]:
    """Another square, other values of W, a mesh that folds, is cut, or reaches beyond the square."""
    where = ["evidence", 1, "hypotheses"]
    for entry in good["evidence"][1:]:
        if entry["theorem"] != "basin":
            return
        corners, triangles = (entry["hypotheses"]["mesh"][name] for name in ("corners", "triangles"))
        for within in ("0", "-1/2", "1/3", "3/5", "2"):
            yield [([*where, "within"], within)]
        for k, corner in enumerate(corners):
            x, y, value = corner.split(" ")
            for other in (f"{x} {y} {int(value) + 2}", f"{y} {x} {value}", f"{2 * int(x)} {2 * int(y)} {value}"):
                yield [([*where, "mesh", "corners", k], other)]
        for k in range(len(triangles)):
            yield [([*where, "mesh", "triangles"], [*triangles[:k], *triangles[k + 1 :]])]
        yield [([*where, "below"], 3)]
        yield [([*where, "squared_radius"], "1/257")]
        yield [([*where, "mesh", "unit"], "1/30")]


def other_theorem(good: Record) -> Iterator[Any]:
    """Theorems of systems, and none."""
    for name in ("lyapunov", "escape", "theorem 5", "", None):
        yield [(["evidence", 0, "theorem"], name)]
    yield [(["evidence"], [good["evidence"][0]] * 21)]


ARRAY_KINDS: Kinds = (
    other_version,
    other_frame,
    without_evidence,
    without_one_proof,
    with_one_proof_more,
    other_cells,
    other_points,
    other_twists,
    other_acting,
    other_array,
    other_numbers,
    other_claims,
    other_disc,
    other_rate,
    other_bounds,
    bounds_elsewhere,
    other_proofs,
    other_tolerances,
    other_basin,
    other_theorem,
)


def array_texts() -> Iterator[Forgery]:
    """Bombs of depth, digits and products in the text of a good certificate, and a key that is there twice."""
    _, good = next(array_certificates())
    text = json.dumps(good, separators=(",", ":"))
    speed, first = '"speed":', text.index('"speed":')
    head, tail = text[: first + len(speed)], text[first + len(speed) :].partition(",")[2]
    for times in (5_000, 500_000):
        yield Forgery("long number", text=((f'{head}"', 1), ("9", times), (f'",{tail}', 1)))
        yield Forgery("long denominator", text=((f'{head}"1/', 1), ("9", times), (f'",{tail}', 1)))
        yield Forgery("deep number", text=((head, 1), ("[", times), ("]", times), (f",{tail}", 1)))
        yield Forgery("many products", text=((f'{head}[["1"]', 1), (',["1/7"]', times), (f"],{tail}", 1)))
        yield Forgery("long product", text=((f'{head}[["1"', 1), (",0", times), (f"]],{tail}", 1)))
    for times in (1_000, 100_000):
        yield Forgery(
            "many sums", text=((f'{head}[["1"]', 1), (f',["1/{"9" * 3000}7"]', times // 500), (f"],{tail}", 1))
        )
    for key in ("version", "statement", "evidence"):
        yield Forgery("key twice", text=((f'{text[:-1]},"{key}":null}}', 1),))
    yield Forgery("key twice", text=((text.replace(speed, '"speed":"2","speed":', 1), 1),))
