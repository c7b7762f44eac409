"""``python -m tests.evidence.published_systems``: systems of the literature, and from where they are certified.

A line of JSON for each system is written into ``--into``, and what stands there is not computed again, so that a study
goes on where it was stopped.  Printed is a table: the verdict beside what is published, whether every start arrives,
the part of the sampled starts that arrive which a certified region holds, seconds of a processor, and how many of
``--starts`` random starts in the region go astray, by polygons along the literal formulas, without the proof.
``--search best`` examines a choice of them with more effort.  A basin that reaches to infinity has no share: of those,
and of all others, the share is also taken in a square of one half-width, which is the same for all (NEAR).
``--page docs/systems.md`` writes the table between the marks of that page, of what has been computed so far.
The study ends with status 1 where a verdict is not the published one, or a start goes astray.
"""

from __future__ import annotations

import argparse
import re
import statistics
import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nonsmooth.proofs.kernel.subject import NoCertificateError, about
from nonsmooth.proofs.systems.basin import CertifiedBasin
from nonsmooth.proofs.systems.domain import ReshapedRegion
from nonsmooth.reports.checks.check import check_system
from nonsmooth.symbolic.files.system_builder import build_system
from tests.certificates.inclusion import Array, FloatInclusion
from tests.evidence.measured_tables import Lines, Record
from tests.proofs.literature import literature
from tests.proofs.system_families import ATTRACTS, Known, families

STEPS, FINENESS = 1_500, 0.02  # of a polygon, and the length of a step against the distance from the point
ARRIVED = 0.2  # of the distance of the start
PASSES = ((1, 0.1), (10, 0.1), (10, 1e-5))  # how much finer steps are, and from how far away velocities, of a step
AROUND = 1.25  # of the extent of a region: the box over which starts are sampled in three states and more
SAMPLED = 2_000
NEAR = 4  # half-widths of the checked square: the window over which all regions are compared, where they reach so far
NAMES = ("system", "published", "verdict", "from where", "share", "share near", "seconds", "astray")
MARKED = {"fast": r"(?s)(<!-- systems -->\n).*?(?=<!-- end -->)", "best": r"(?s)(<!-- best -->\n).*?(?=<!-- end -->)"}
BEST = (
    "van der Pol, reversed, mu 1/3",
    "van der Pol, reversed, mu 1",
    "van der Pol, reversed, mu 3",
    "two machines",
    "x y below one",
    "two products",
    "softening cubic spring",
    "softening spring 3",
    "inside the unit circle",
    "Duffing, one well",
    "competition of two species",
    "pendulum",
    "sliding beside a cubic",
    "relay against a cubic",
    "softening spring and relay",
    "anti-windup",
    "boost converter, current control",
    "negative loop of two genes",
    "two units with bias",
    "focus with quadratic terms",
    "Tibken",
    "van der Pol in three states",
    "FOSSIL, NonPoly2",
    "x' B x in 3 states",
    "x' B x in 4 states",
)


def systems() -> Iterator[Known]:
    """Those of the literature, and those of the families."""
    yield from literature()
    yield from families()


def examined(known: Known, search: str, starts: int) -> Record:
    """The verdict, and the region of an attracting point."""
    check = {"radius": "1/2", **known.check}
    document = {"system": {"states": list(known.states), "rhs": list(known.rhs)}, "check": check}
    system = build_system(document, known.name, Path("published.toml"))
    begin = time.process_time()
    result = check_system(system)
    decided = time.process_time()
    found = {"verdict": result.verdict, "reason": result.reason, "decided": decided - begin}
    if result.verdict != ATTRACTS:
        return {**found, "where": ""}
    if result.evidence.reach.everywhere:
        return {**found, "where": "everywhere"}
    reach = result.with_region(search).evidence.reach
    found["region"] = time.process_time() - decided
    scene = result.evidence.scene
    if reach.basin is not None and len(known.states) > 2:
        return {**found, **in_space(scene, reach.basin, reach.reshaped, starts)}
    if reach.basin is not None:
        basin = reach.basin
        lost = astray(scene, in_simplices(basin, starts))
        near = share_near(scene, basin.holds, np.abs(basin.border).max(axis=0))
        size = f"{len(basin.simplices)} {basin.kind}"
        return {**found, "where": size, "share": basin.share, "near": near, "astray": lost}
    if reach.reshaped is not None:
        own = reach.reshaped
        inside, share = below_level(scene, own, starts)
        near = share_near(scene, holds_below(scene, own), np.abs(inside).max(axis=0))
        return {**found, "where": "another V", "share": share, "near": near, "astray": astray(scene, inside)}
    return {**found, "where": "a level of V" if reach.region is not None else "near the point"}


def in_space(system: Any, basin: CertifiedBasin, further: ReshapedRegion | None, starts: int) -> Record:
    """What tetrahedra and the level set of another V, where there is one, hold together."""
    drawn = in_simplices(basin, starts)
    certified: list[Callable[[Array], NDArray[np.bool_]]] = [basin.holds]
    places, where = [drawn, basin.border], f"{len(basin.simplices)} {basin.kind}"
    if further is not None:
        below, _ = below_level(system, further, starts)
        places.append(below)
        certified.append(holds_below(system, further))
        where += " and another V"

    def is_certified(x: Array) -> NDArray[np.bool_]:
        return np.any([own(x) for own in certified], axis=0)

    extent = np.abs(np.vstack(places)).max(axis=0)
    lost = [astray(system, own) for own in (drawn, *places[2:])]
    return {
        "where": where,
        "share": share_near(system, is_certified, extent, np.inf),
        "near": share_near(system, is_certified, extent),
        "astray": None if None in lost else sum(own for own in lost if own is not None),
    }


def holds_below(system: Any, own: ReshapedRegion) -> Callable[[Array], NDArray[np.bool_]]:
    """Which places have V below its level in its cube."""
    inclusion, level, half = FloatInclusion(about(system), 1), float(own.region.level), float(own.region.radius)

    def is_below(x: Array) -> NDArray[np.bool_]:
        below = inclusion.function(own.formula.text, x) < level
        return np.asarray(below & (np.abs(x).max(axis=1) <= half))

    return is_below


def share_near(
    system: Any, certified: Callable[[Array], NDArray[np.bool_]], extent: Array, window: float = NEAR
) -> float | None:
    """Of random starts in the window that come to the point, the part that is certified; None where none is followed.

    Args:
        system: in the displacement from the point.
        certified: which places are in the region.
        extent: of the region, in each state: the window ends a little beyond it, or at the largest one.
        window: the largest one, in half-widths of the checked square.
    """
    half = np.minimum(AROUND * extent, window * float(system.check.radius))
    starts = np.random.default_rng(2).uniform(-half, half, (SAMPLED, len(half)))
    inside = certified(starts)
    gone = astray_ones(system, starts[~inside])
    return None if gone is None else float(inside.sum()) / max(len(starts) - len(gone), 1)


def in_simplices(basin: CertifiedBasin, count: int) -> Array:
    """Random starts in triangles or tetrahedra."""
    random = np.random.default_rng(1)
    chosen = basin.corners[random.choice(basin.simplices, count)][:, :, :-1]
    return np.asarray(np.einsum("ij,ijk->ik", random.dirichlet(np.ones(basin.simplices.shape[1]), count), chosen))


def below_level(system: Any, own: ReshapedRegion, count: int) -> tuple[Array, float | None]:
    """Random starts with V below its level, and the part that these are of the starts around that come home."""
    inclusion, random = FloatInclusion(about(system), 1), np.random.default_rng(1)
    level, half = float(own.region.level), float(own.region.radius)
    states = len(system.states)
    inside = np.zeros((0, states))
    while len(inside) < count:
        places = random.uniform(-half, half, (20 * count, states))
        inside = np.vstack([inside, places[inclusion.function(own.formula.text, places) < level]])
    extent = AROUND * np.abs(inside).max(axis=0)
    around = random.uniform(-extent, extent, (SAMPLED, states))
    certified = inclusion.function(own.formula.text, around) < level
    gone = astray_ones(system, around[~certified])
    if gone is None:
        return inside[:count], None
    coming = len(around) - len(gone)
    return inside[:count], float(certified.sum()) / coming if coming else None


def astray(system: Any, starts: Array) -> int | None:
    """How many starts come no nearer; None for formulas that are not followed here."""
    found = astray_ones(system, starts)
    return None if found is None else len(found)


def astray_ones(system: Any, starts: Array) -> NDArray[np.intp] | None:
    """The numbers of the starts that come no nearer; None for formulas that are not followed here.

    Near the border of a basin steps of two per cent may lead out of it, and so may velocities from places beside: who
    is astray is followed again by a tenth, and then with velocities from places that are nearer by far.
    """
    try:
        inclusion = FloatInclusion(about(system), 1)
    except NoCertificateError:
        return None
    left = np.arange(len(starts))
    furthest = 4 * float(np.linalg.norm(starts, axis=1).max()) if len(starts) else 0.0
    for finer, near in PASSES:
        left = left[lost(inclusion, starts[left], furthest, finer, near)]
    return left


def lost(inclusion: FloatInclusion, starts: Array, furthest: float, finer: int, near: float) -> NDArray[np.intp]:
    """The numbers of the starts that come no nearer, by steps of a part of the usual length.

    Velocities are taken from places around, up to a part of a step away.
    """
    x, begin, todo = starts.copy(), np.linalg.norm(starts, axis=1), np.arange(len(starts))
    for _ in range(STEPS * finer):
        size = np.linalg.norm(x[todo], axis=1)
        todo = todo[(size > ARRIVED * begin[todo]) & (size < furthest)]
        if not len(todo):
            break
        size = np.linalg.norm(x[todo], axis=1)
        v = inclusion.members(x[todo], near * FINENESS / finer * size)
        x[todo] += (FINENESS / finer * size / (np.linalg.norm(v, axis=1) + 1e-300))[:, None] * v
    return np.nonzero(np.linalg.norm(x, axis=1) > begin)[0]  # slides are slow by such steps: nearer is enough


# ---- the table -----------------------------------------------------------------------------------


def row(known: Known, own: Record) -> tuple[str, ...]:
    """A line of the table."""
    share = "" if own.get("share") is None else f"{own['share']:.3f}"
    seconds = f"{own['decided']:.1f} + {own['region']:.1f}" if "region" in own else f"{own['decided']:.1f}"
    near = "" if own.get("near") is None else f"{own['near']:.3f}"
    lost = "" if own.get("astray") is None else str(own["astray"])
    truth = f"{known.truth}{' from everywhere' if known.everywhere else ''}: {known.source}"
    verdict = own["verdict"] if own["verdict"] != "undecided" else f"undecided: {own['reason']}"
    return known.name, truth, verdict, own["where"], share, near, seconds, lost


def table(rows: Iterable[tuple[str, ...]]) -> str:
    """In Markdown."""
    lines = [NAMES, ("---",) * len(NAMES), *rows]
    return "\n".join(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in line)} |" for line in lines) + "\n"


def summary(found: list[tuple[Known, Record]]) -> str:
    """How many, how much and how long, in a sentence or two."""
    shares = [own["share"] for _, own in found if own.get("share") is not None]
    seconds = [own["region"] for _, own in found if "region" in own]
    wrong = sum(is_wrong(known, own) for known, own in found)
    undecided = sum(own["verdict"] == "undecided" for _, own in found)
    missed = sum(known.everywhere and own["where"] != "everywhere" for known, own in found)
    said = (
        f"{len(found)} systems: {wrong} wrong, {undecided} undecided, {missed} of those that attract from everywhere "
    )
    said += "without that claim."
    if shares:
        said += f" {len(shares)} regions hold {statistics.median(shares):.3f} of the sampled starts that arrive in the "
        said += f"median, {min(shares):.3f} at least, in {statistics.median(seconds):.1f} s of a processor in the "
        said += f"median, {max(seconds):.1f} s at most."
    near = [own["near"] for _, own in found if own.get("near") is not None]
    if near:
        said += f" Near the point they hold {statistics.median(near):.3f} in the median, {min(near):.3f} at least."
    return said


def is_wrong(known: Known, own: Record) -> bool:
    """Whether a verdict is not the published one, or a start goes astray."""
    return own["verdict"] not in (known.truth, "undecided") or bool(own.get("astray"))


def write(page: Path, found: list[tuple[Known, Record]], search: str) -> None:
    """The table and its summary between the marks of a page for a search."""
    text = f"{summary(found)}\n\n{table(row(known, own) for known, own in found)}"
    page.write_text(
        re.sub(MARKED[search], lambda part: part[1] + text, page.read_text(encoding="utf-8")), encoding="utf-8"
    )


def main() -> int:
    """Examine all, and print the table; 1 where something is wrong."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--search", default="fast", choices=("fast", "best"))
    parser.add_argument("--starts", type=int, default=10_000)
    parser.add_argument("--only", default="", help="systems whose names hold this")
    parser.add_argument("--into", type=Path, default=Path("build/published_systems"))
    parser.add_argument("--page", type=Path, help="whose table is written, of what has been computed")
    chosen = parser.parse_args()
    chosen.into.mkdir(parents=True, exist_ok=True)
    lines = Lines(chosen.into / f"{chosen.search}.jsonl")
    listed = [known for known in systems() if chosen.only in known.name]
    if chosen.search == "best":
        listed = [known for known in listed if known.name in BEST]
    if chosen.page is not None:
        write(
            chosen.page,
            [(known, lines.known[known.name]) for known in listed if known.name in lines.known],
            chosen.search,
        )
        return 0
    found = []
    for known in listed:
        own = lines.of(known.name, lambda known=known: examined(known, chosen.search, chosen.starts))  # type: ignore[misc]
        found.append((known, own))
        print(table([row(known, own)]).splitlines()[-1], flush=True)
    print(f"\n{summary(found)}")
    return int(any(is_wrong(known, own) for known, own in found))


if __name__ == "__main__":
    raise SystemExit(main())
