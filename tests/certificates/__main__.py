"""Write the corpus of certificates anew: ``python -m tests.certificates``, at the root of the repository.

Good ones are files of their own in ``good``; forged ones are lines of ``bad.jsonl``, as changes to good ones.
"""

from __future__ import annotations

import json
import random
from collections.abc import Iterator, Mapping

from nonsmooth.proofs.checker.statements import refusal
from tests.certificates.cases import cases
from tests.certificates.corpus import BAD, GOOD, Record, forged, text_of
from tests.certificates.forgeries import Forgery, forgeries, texts
from tests.certificates.inclusion import contradiction

MOST_BYTES = 20_000
EACH = 5  # forgeries of a good certificate


def write() -> None:
    """Write both.

    Raises:
        ValueError: where a good certificate is rejected, or a forged one is accepted.
    """
    GOOD.mkdir(exist_ok=True)
    for old in GOOD.glob("*.json"):
        old.unlink()
    good: dict[str, Record] = {}
    for case in cases():
        certificate = case.certificate()
        text = text_of(certificate)
        refused = refusal(json.loads(text), len(text))
        if refused:
            raise ValueError(f"{case.name} is rejected: required {refused}")
        if len(text) <= MOST_BYTES:
            good[case.name] = certificate
            (GOOD / f"{case.name}.json").write_text(text, encoding="utf-8")
    kept = list(chosen(good))
    BAD.write_text("".join(json.dumps(own.record, separators=(",", ":")) + "\n" for own in kept), encoding="utf-8")
    print(f"{len(good)} good, {len(kept)} forged")


def chosen(good: Mapping[str, Record]) -> Iterator[Forgery]:
    """Some forgeries of each good certificate, of kinds that took turns, and all texts."""
    source, turn = random.Random(1), 0
    for name, certificate in good.items():
        by_kind = forgeries(name, certificate)
        kinds = list(by_kind)
        for _ in range(EACH):
            turn += 1
            own = source.choice(by_kind[kinds[turn % len(kinds)]])
            if is_rejected(own, good):
                yield own
    yield from (own for own in texts() if is_rejected(own, good))


def is_rejected(own: Forgery, good: Mapping[str, Record]) -> bool:
    """Whether the checker rejects a forgery; what it accepts must be true after all, such as of a centre in reverse.

    Raises:
        ValueError: where floats contradict what it accepts.
    """
    if forged(own, good):
        return True
    seen = contradiction(own.document(good[own.of])["statement"]) if own.of else "a text of its own"
    print(f"accepted: {json.dumps(own.record)[:300]}")
    if seen:
        raise ValueError(f"accepted, but {seen}")
    return False


write()
