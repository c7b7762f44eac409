"""What a certificate of an array states in version 2, in the words of version 1: for the checker of that version.

:mod:`.array_checker` shares no code with the checker of today.  It had no words for rows without friction, which rule
``nearest`` leaves out.
"""

from __future__ import annotations

import json
from typing import Any, TypeAlias

from nonsmooth.proofs.checker.contact import Cells, Motion
from nonsmooth.proofs.checker.wheels import read_array
from tests.oracles import array_checker

Record: TypeAlias = dict[str, Any]

UNDECIDED = "undecided"


def earlier_array(certificate: Record) -> Record | None:
    """A certificate of version 1 that states the same; None where version 1 has no words for it.

    Args:
        certificate: accepted by the checker of version 2.
    """
    subject, evidence = certificate["statement"]["subject"], certificate["evidence"][0]
    hypotheses, proofs = evidence["hypotheses"], evidence["proofs"]
    cells = Cells(read_array(subject), hypotheses["points"], hypotheses["cells"])
    of_pairs = [motion.rows[0][1] == motion.rows[1][1] for cell in cells.listed for motion in cell.motions]
    if subject["rule"] == "nearest" and not all(of_pairs):
        return None
    said = {kind: about for claim in certificate["statement"]["claims"] for kind, about in claim.items()}
    equilibrium = {True: "holds", False: "fails", None: UNDECIDED}[said.get("equilibrium")]
    (feedback,) = proofs.get("feedback", {"": None}).values()
    document = {
        "schema": array_checker.SCHEMA,
        **{key: subject[key] for key in ("field", "at", "radius", "rule", "loads", "wheels")},
        "points": hypotheses["points"],
        "cells": [
            {
                "polygon": own["polygon"],
                "loaded": own["wheels"] if subject["rule"] == "box" else None,
                "states": [_state(own, proofs, k, motion) for k, motion in enumerate(cell.motions)],
            }
            for own, cell in zip(hypotheses["cells"], cells.listed, strict=True)
        ],
        "equilibrium": {"verdict": equilibrium, "separator": proofs.get("separator")},
        "translation": {"verdict": said.get("translation", UNDECIDED), "squared_radius": hypotheses["disc"]},
        "rotation": {
            "verdict": said.get("rotation", UNDECIDED),
            "lowest": proofs.get("lowest"),
            "highest": proofs.get("highest"),
        },
        "feedback": {"verdict": said.get("feedback", UNDECIDED), "evidence": feedback},
        "theorem4": said.get("theorem 4", UNDECIDED),
        "notes": {},
    }
    if "tolerances" in said:
        document["robust"] = {"tolerance": subject["tolerances"], **said["tolerances"]}
    return document


def _state(cell: Record, proofs: Record, k: int, motion: Motion) -> Record:
    rows = [f"{kind}{number}" for kind, number in motion.rows]
    return {"rows": rows, "twist": cell["twists"][k], "barrier": proofs.get(f"barrier {motion.cell} {k}")}


def refusal_of_version_1(certificate: Record) -> str:
    """What the checker of version 1 does not show of a certificate of version 2; empty where it is valid there too.

    Raises:
        ValueError: where version 1 has no words for it.
    """
    document = earlier_array(certificate)
    if document is None:
        raise ValueError("rows without friction")
    return array_checker.check_certificate(json.loads(json.dumps(document)))
