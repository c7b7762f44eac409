"""Write the corpus of certificates anew: ``python -m tests.certificates``, at the root of the repository.

Good ones are files of their own in ``good``; forged ones are lines of ``bad.jsonl``, and of ``bad_arrays.jsonl``, as
changes to good ones.  With ``arrays`` behind it the command writes those of arrays alone.
"""

from __future__ import annotations

import argparse
import json
import random
from collections.abc import Iterable, Mapping
from pathlib import Path

from nonsmooth.proofs.checker.statements import refusal
from tests.certificates.array_conditions import array_conditions
from tests.certificates.arrays import ARRAY_KINDS, array_certificates, array_texts
from tests.certificates.cases import cases
from tests.certificates.conditions import conditions
from tests.certificates.corpus import BAD, BAD_ARRAYS, GOOD, PREFIX, Record, forged, text_of
from tests.certificates.forgeries import KINDS, Forgery, Kinds, forgeries, texts
from tests.certificates.inclusion import contradiction
from tests.oracles.rebuilt_arrays import assert_still_true

MOST_BYTES = 20_000
EACH, EACH_ARRAY = 5, 12  # forgeries of a good certificate


def write(*, arrays_only: bool) -> None:
    """Write both.

    Raises:
        ValueError: where a good certificate is rejected, or a forged one is accepted.
    """
    of_arrays = [*array_texts(), *array_conditions()]  # some are made from good ones, which are deleted below
    forged_anyway = [] if arrays_only else [*texts(), *conditions()]
    GOOD.mkdir(exist_ok=True)
    for old in GOOD.glob(f"{PREFIX}*.json" if arrays_only else "*.json"):
        old.unlink()
    if not arrays_only:
        write_part(((case.name, case.certificate()) for case in cases()), BAD, KINDS, forged_anyway, EACH)
    write_part(array_certificates(), BAD_ARRAYS, ARRAY_KINDS, of_arrays, EACH_ARRAY)


def write_part(
    certificates: Iterable[tuple[str, Record]],
    file: Path,
    kinds: Kinds,
    further: Iterable[Forgery],
    each: int,
) -> None:
    """Write good certificates, so many that are forged of each, and further forged ones."""
    good: dict[str, Record] = {}
    for name, certificate in certificates:
        text = text_of(certificate)
        refused = refusal(json.loads(text), len(text))
        if refused:
            raise ValueError(f"{name} is rejected: required {refused}")
        if len(text) <= MOST_BYTES:
            good[name] = certificate
            (GOOD / f"{name}.json").write_text(text, encoding="utf-8")
    source, turn = random.Random(1), 0
    kept = list[Forgery]()
    for name, certificate in good.items():
        by_kind = forgeries(name, certificate, kinds)
        names = list(by_kind)
        for _ in range(each):
            turn += 1
            kept.append(source.choice(by_kind[names[turn % len(names)]]))
    kept = [own for own in (*kept, *further) if is_rejected(own, good)]
    file.write_text("".join(json.dumps(own.record, separators=(",", ":")) + "\n" for own in kept), encoding="utf-8")
    print(f"{len(good)} good, {len(kept)} forged")


def is_rejected(own: Forgery, good: Mapping[str, Record]) -> bool:
    """Whether the checker rejects a forgery; what it accepts must be true after all, such as of a centre in reverse.

    Raises:
        ValueError: where floats contradict what it accepts.
    """
    if forged(own, good):
        return True
    print(f"accepted: {json.dumps(own.record)[:300]}")
    document = own.document(good[own.of]) if own.of else {}
    if own.of.startswith(PREFIX):
        assert_still_true(document)
        return False
    seen = contradiction(document["statement"]) if own.of else "a text of its own"
    if seen:
        raise ValueError(f"accepted, but {seen}")
    return False


parser = argparse.ArgumentParser(prog="python -m tests.certificates", description="Write the corpus anew.")
parser.add_argument("part", nargs="?", choices=["arrays"], help="certificates of arrays alone")
write(arrays_only=parser.parse_args().part is not None)
