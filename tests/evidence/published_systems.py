"""``python -m tests.evidence.published_systems``: planar systems of the literature, and from where they are certified.

A line of JSON for each system is written into ``--into``, and what stands there is not computed again, so that a study
goes on where it was stopped.  Printed is a table: the verdict beside what is published, whether every start arrives,
the part of the sampled starts that arrive which a certified region holds, seconds of a processor, and how many of
``--starts`` random starts in the region go astray, by polygons along the literal formulas, without the proof.
The study ends with status 1 where a verdict is not the published one, or a start goes astray.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nonsmooth.proofs.kernel.subject import NoCertificateError, about
from nonsmooth.proofs.systems.basin import CertifiedBasin
from nonsmooth.reports.check import check_system
from nonsmooth.symbolic.files.system_file import build_system
from tests.certificates.inclusion import Array, FloatInclusion
from tests.evidence.measured_tables import Lines, Record
from tests.proofs.published_regions import PUBLISHED
from tests.proofs.system_families import ATTRACTS, Known, families

STEPS, FINENESS = 1_500, 0.02  # of a polygon, and the length of a step against the distance from the point
ARRIVED = 0.2  # of the distance of the start
NAMES = ("system", "published", "verdict", "from where", "share", "seconds", "astray")


def systems() -> Iterator[Known]:
    """Those of the families, and those whose regions are published."""
    yield from families()
    for own in PUBLISHED:
        yield Known(f"{own.name} (region)", own.rhs, ATTRACTS, own.source, {"radius": str(own.radius)})
    for mu in (3,):
        yield Known(f"van der Pol {mu}", ("-y", f"x - {mu}*(1 - x**2)*y"), ATTRACTS, "LyZNet: 0.852 of the region")


def examined(known: Known, search: str, starts: int) -> Record:
    """The verdict, and the region of an attracting point."""
    check = {"radius": "1/2", **known.check}
    document = {"system": {"states": ["x", "y"], "rhs": list(known.rhs)}, "check": check}
    system = build_system(document, known.name, Path("published.toml"))
    begin = time.process_time()
    result = check_system(system)
    decided = time.process_time()
    found = {"truth": known.truth, "source": known.source, "verdict": result.verdict, "decided": decided - begin}
    if result.verdict != ATTRACTS:
        return {**found, "where": ""}
    if result.evidence.reach.everywhere:
        return {**found, "where": "everywhere"}
    basin = result.with_region(search).evidence.reach.basin
    found["region"] = time.process_time() - decided
    if basin is None:
        return {**found, "where": "a level of V" if result.evidence.reach.region is not None else "near the point"}
    lost = astray(result.evidence.scene, basin, starts)
    return {**found, "where": "triangles", "share": basin.share, "triangles": len(basin.triangles), "astray": lost}


def astray(system: Any, basin: CertifiedBasin, count: int) -> int | None:
    """How many random starts in triangles come no nearer; None for formulas that are not followed here.

    Near the border of a basin steps of two per cent may lead out of it: who is astray is followed again by a tenth.
    """
    try:
        inclusion = FloatInclusion(about(system), 1)
    except NoCertificateError:
        return None
    random = np.random.default_rng(1)
    chosen = basin.corners[random.choice(basin.triangles, count)][:, :, :2]
    x: Array = np.einsum("ij,ijk->ik", random.dirichlet(np.ones(3), count), chosen)
    furthest = 1.1 * float(np.linalg.norm(basin.corners[:, :2], axis=1).max())
    for finer in (1, 10):
        x = x[lost(inclusion, x, furthest, finer)]
    return len(x)


def lost(inclusion: FloatInclusion, starts: Array, furthest: float, finer: int) -> NDArray[np.intp]:
    """The numbers of the starts that come no nearer, by steps of a part of the usual length."""
    x, begin, todo = starts.copy(), np.linalg.norm(starts, axis=1), np.arange(len(starts))
    for _ in range(STEPS * finer):
        size = np.linalg.norm(x[todo], axis=1)
        todo = todo[(size > ARRIVED * begin[todo]) & (size < furthest)]
        if not len(todo):
            break
        size = np.linalg.norm(x[todo], axis=1)
        v = inclusion.members(x[todo], 0.1 * FINENESS / finer * size)
        x[todo] += (FINENESS / finer * size / (np.linalg.norm(v, axis=1) + 1e-300))[:, None] * v
    return np.nonzero(np.linalg.norm(x, axis=1) > begin)[0]  # slides are slow by such steps: nearer is enough


def row(name: str, own: Record) -> str:
    """A line of the table."""
    share = f"{own['share']:.3f} ({own['triangles']})" if "share" in own else ""
    seconds = f"{own['decided']:.1f} + {own.get('region', 0.0):.1f}"
    lost = "" if own.get("astray") is None else str(own["astray"])
    cells = (name, f"{own['truth']}: {own['source']}", own["verdict"], own["where"], share, seconds, lost)
    return f"| {' | '.join(cells)} |"


def main() -> int:
    """Examine all, and print the table; 1 where something is wrong."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--search", default="fast", choices=("fast", "best"))
    parser.add_argument("--starts", type=int, default=10_000)
    parser.add_argument("--only", default="", help="systems whose names hold this")
    parser.add_argument("--into", type=Path, default=Path("build/published_systems"))
    chosen = parser.parse_args()
    chosen.into.mkdir(parents=True, exist_ok=True)
    lines, wrong, shares, seconds = Lines(chosen.into / f"{chosen.search}.jsonl"), 0, list[float](), list[float]()
    print(f"| {' | '.join(NAMES)} |\n|{' --- |' * len(NAMES)}")
    for known in systems():
        if chosen.only in known.name:
            own = lines.of(known.name, lambda known=known: examined(known, chosen.search, chosen.starts))  # type: ignore[misc]
            print(row(known.name, own), flush=True)
            wrong += own["verdict"] not in (known.truth, "undecided") or bool(own.get("astray"))
            shares += [own["share"]] if "share" in own else []
            seconds += [own["region"]] if "region" in own else []
    if shares:
        print(f"\n{len(shares)} regions of triangles: share {statistics.median(shares):.3f} in the median, ", end="")
        print(
            f"{min(shares):.3f} at least; {statistics.median(seconds):.1f} s in the median, {max(seconds):.1f} at most"
        )
    print(f"{wrong} wrong")
    return 1 if wrong else 0


if __name__ == "__main__":
    raise SystemExit(main())
