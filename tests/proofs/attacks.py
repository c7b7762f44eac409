"""What is attacked with mutants: by theorem, valid certificates and an oracle that sees what is false.

Each oracle shares no theory with the checker, or no code: floats along the literal formulas, polygons, the motion of
arrays by the definitions, arrays drawn from a box, or the workbench's decision of an array that is built anew.
"""

from __future__ import annotations

import random
from collections.abc import Collection, Mapping
from functools import partial
from typing import Any, TypeAlias

from nonsmooth.proofs.certificate import build_certificate
from nonsmooth.proofs.checker.statements import THEOREMS
from nonsmooth.proofs.theorem4 import check_cells
from tests.array_certificates import said
from tests.certificates.corpus import good_arrays, good_certificates, text_of
from tests.certificates.inclusion import contradiction, half_width
from tests.conftest import Arrays
from tests.oracles.bodies_in_triangles import assert_bodies_end
from tests.oracles.mutants import Attack, at_random, claiming, searching
from tests.oracles.rebuilt_arrays import assert_still_true
from tests.oracles.tied_arrays import scene_of, tied_array
from tests.proofs import test_escape_theorem as escapes
from tests.proofs import test_scalar_stability as scalar
from tests.proofs import test_second_function as further
from tests.proofs import test_square_roots as roots
from tests.proofs import test_tied_arrays as tied
from tests.proofs.checker import test_irrational as irrational
from tests.proofs.robust import test_certified_bound as robust

Record: TypeAlias = dict[str, Any]

SMALL = 5_000  # bytes of a certificate of a plain system
TIED = 30  # tied arrays


def small_ones(theorem: str) -> list[Record]:
    """Small good certificates whose first theorem is this one."""
    good = good_certificates().values()
    return [record for record in good if record["evidence"][0]["theorem"] == theorem and len(text_of(record)) < SMALL]


def of_few_states(theorem: str) -> list[Record]:
    """Those for which a search takes no long time."""
    return [record for record in small_ones(theorem) if len(record["statement"]["subject"]["states"]) < 3]


def assert_floats_agree(record: Record, source: random.Random) -> None:
    """Polygons and slopes of the literal formulas contradict no claim."""
    reason = contradiction(record["statement"], half_width(record["evidence"][0]["hypotheses"]))
    assert not reason, reason


def assert_array_agrees(record: Record, source: random.Random) -> None:
    """What is said of an array is decided afresh; arrays that are drawn from a box obey what is said of it."""
    for entry in record["evidence"]:
        if entry["theorem"] == "theorem 4":
            assert_still_true({**record, "evidence": [entry]})
    if "tolerances" in said(record):
        robust.assert_arrays_obey(record, robust.ARRAYS)


def assert_paths_agree(record: Record, source: random.Random) -> None:
    """Bodies near the point move as is said."""
    tied.assert_paths_agree(record, seed=1)


def assert_solution_leaves(record: Record, source: random.Random) -> None:
    """A polygon along the mixture that is named leaves, and other polygons do not contradict that."""
    for entry in record["evidence"]:
        if entry["theorem"] == "escape":
            escapes.assert_leaves({**record, "evidence": [entry]})
    assert_floats_agree(record, source)


# ---- originals -----------------------------------------------------------------------------------


def escaping(without: Collection[str] = ()) -> list[Record]:
    """Solutions that leave, of small good certificates and of the tests' own one field, but for some of those."""
    of_one_field = [name for name in escapes.LEAVING if not name.startswith(("one", "neither", "three"))]
    names = [name for name in of_one_field if name not in without]
    return [*small_ones("escape"), *map(escapes.certificate, names)]


def in_one_state(count: int = len(scalar.TRUE)) -> list[Record]:
    """At most so many systems without roots and of short numbers."""
    names = [name for name in scalar.TRUE if "root" not in name and "large" not in name]
    return [scalar.certificate(name) for name in names[:count]]


def of_arrays() -> list[Record]:
    """All good ones of arrays."""
    return list(good_arrays().values())


def with_laws() -> list[Record]:
    """Arrays whose feedback clause has evidence."""
    return [record for record in of_arrays() if "feedback" in record["evidence"][0]["proofs"]]


def of_bounds() -> list[Record]:
    """Nothing but what is said of arrays within tolerances."""
    return [robust.bounds_only(record) for record in of_arrays() if "tolerances" in said(record)]


def of_basins() -> list[Record]:
    """Nothing but the triangles of arrays."""
    records = []
    for record in of_arrays():
        entries = [entry for entry in record["evidence"] if entry["theorem"] == "basin"]
        claims = [claim for claim in record["statement"]["claims"] if {"attracts", "ends"} & set(claim)]
        if entries:
            records.append({**record, "statement": {**record["statement"], "claims": claims}, "evidence": entries})
    return records


def of_ties(count: int = TIED) -> list[Record]:
    """Arrays whose wheels are tied."""
    scenes = [scene_of(Arrays(), tied_array(seed)[0]) for seed in range(count)]
    return [build_certificate(check_cells(scene)) for scene in scenes]


BY_CORPUS = {
    theorem: Attack(partial(small_ones, theorem), assert_floats_agree) for theorem in THEOREMS if theorem != "escape"
}
SEARCHED = {
    f"{theorem}, searched": Attack(partial(of_few_states, theorem), assert_floats_agree, (searching,))
    for theorem in THEOREMS
}
ATTACKS: Mapping[str, Attack] = {
    **BY_CORPUS,
    "escape": Attack(escaping, assert_solution_leaves, sees_evidence=True),
    **SEARCHED,
    "one state": Attack(in_one_state, scalar.assert_true),
    "roots": Attack(roots.originals, roots.assert_true),
    "irrational numbers": Attack(irrational.originals, assert_floats_agree, (at_random, claiming, searching)),
    "further functions": Attack(further.originals, further.assert_true, (at_random, searching), sees_evidence=True),
    "theorem 4": Attack(of_arrays, assert_array_agrees, sees_evidence=True),
    "feedback": Attack(with_laws, assert_array_agrees, (partial(claiming, proof="feedback"),), sees_evidence=True),
    "ties": Attack(of_ties, assert_paths_agree),
    "tolerances": Attack(of_bounds, assert_array_agrees),
    "triangles": Attack(of_basins, assert_bodies_end, (at_random, claiming)),
}
