"""Certificates of plain systems in two states: the statement that a V proves, for the stand-alone checker of systems.

The checker (:mod:`nonsmooth.proofs.system_checker`) reads the formulas itself and proves everything anew, so a
certificate holds no more than the system, V, its domain and what is claimed, and of LaSalle's principle the curves on
which V' may vanish.  It takes rational numbers and switching lines.  Verdicts without V, by the velocities at the
equilibrium: :mod:`nonsmooth.proofs.systems.fan_certificate`.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import replace
from fractions import Fraction
from typing import Any

from nonsmooth.proofs.system_checker import SCHEMA, check_certificate
from nonsmooth.proofs.systems.conclusion import Method
from nonsmooth.proofs.systems.decay_rate import DecayRate
from nonsmooth.proofs.systems.invariance import Staying, staying_of
from nonsmooth.proofs.systems.system_facts import (
    gain_words,
    proving_pieces,
    proving_text,
    rate_words,
    reached_words,
    region_rate_words,
    rewriting_words,
)
from nonsmooth.proofs.systems.system_stability import SystemResult
from nonsmooth.proofs.verdicts import Translation
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.scene_error import one_line
from nonsmooth.symbolic.surfaces import factorize
from nonsmooth.symbolic.switched_system import SwitchedSystem

CLAIMS = ("level", "rate")  # that a certificate may do without
UNSHOWN = "the stand-alone checker does not show"
LEFT_OUT = "left out"  # key of the notes
MOST_LEFT_OUT, LONGEST = 16, 400  # lines of it that are read, and characters of each
BY_FUNCTION = (Method.LYAPUNOV, Method.INVARIANCE, Method.GROWTH)  # what a V decides


class NoCertificateError(ValueError):
    """A verdict that has no certificate, in one line."""


def build_system_certificate(result: SystemResult) -> dict[str, Any]:
    """The certificate of a verdict, accepted by the stand-alone checker.

    Args:
        result: of a check that a Lyapunov function decides, alone or with LaSalle's principle.

    Raises:
        NoCertificateError: for a verdict that something else decides, for numbers with roots, and where the checker
            does not show all of it within its limits.
    """
    if result.proving is None or result.domain is None or result.method not in BY_FUNCTION:
        raise NoCertificateError(
            f"a certificate needs a verdict by a Lyapunov function, received one by {result.method}"
        )
    system, radius = result.scene, result.domain.radius
    certificate = {
        "schema": SCHEMA,
        **about(system),
        "radius": None if radius is None else exact_text(radius),
        "lyapunov": _lyapunov(result),
        "verdict": str(result.verdict),
        "level": None if result.near is None else exact_text(result.near.level),
        "rate": None if result.rate is None else _rate(result.rate),
        "notes": notes(system),
    }
    if system.by_roots is not None:
        certificate |= {"roots": list(system.by_roots.roots.rooted), "rate": None}  # rates are in the roots' time
    if result.method is Method.INVARIANCE:
        certificate["curves"] = _curves(result)

    def write(claims: Collection[str]) -> dict[str, Any]:
        return {**certificate, **dict.fromkeys(set(CLAIMS).difference(claims))}

    shown, refused = accepted_claims(write, check_certificate)
    return with_left_out(shown, [*_left_out(result, refused), *_beyond_the_form(result)])


def without_numbers(certificate: dict[str, Any], result: SystemResult) -> dict[str, Any]:
    """A certificate of the verdict by other evidence than the V whose numbers the check prints: they are left out."""
    why = dict.fromkeys(CLAIMS, f"{UNSHOWN} the V that shows it")
    return with_left_out(certificate, [*_left_out(result, why), *_beyond_the_form(result)])


def _left_out(result: SystemResult, refused: Mapping[str, str]) -> Iterator[str]:
    """What a check says of the domain of V that a certificate does not hold, each with the reason."""
    if "level" in refused and result.near is not None:
        yield f"{reached_words(result.near, result.scene.states)}: {refused['level']}"
    if "rate" in refused and result.rate is not None:
        yield f"{rate_words(result)}: {refused['rate']}"


def _beyond_the_form(result: SystemResult) -> Iterator[str]:
    """What a check says that certificates have no words for."""
    if result.region is not None and result.region != result.near:
        yield f"{reached_words(result.region, result.scene.states)}: beyond the certified square"
    if result.region_rate is not None:
        yield f"{region_rate_words(result)}: beyond the certified square"
    if result.gain is not None:
        yield f"{gain_words(result)}: certificates hold no disturbances"
    if result.everywhere and result.domain is not None and result.domain.radius is not None:
        yield "all starts in the plane reach the equilibrium: V is certified on a square"
    if result.finite_time:
        yield "solutions near the equilibrium arrive in finite time: certificates hold no times of roots"


def with_stated_function(result: SystemResult) -> SystemResult | None:
    """The same verdict by the scene's own V and LaSalle's principle; None where these do not show it.

    For a searched V that falls strictly, of higher degree, which the checker does not show within its limits.
    """
    attracts = result.verdict is Translation.ASYMPTOTICALLY_STABLE and result.searched is not None
    if not attracts or staying_of(result.lyapunov) is not Staying.NONE:
        return None
    alone = replace(result, searched=None, region=None, rate=None, gain=None, near=None, region_rate=None)
    own, where = result.lyapunov, result.reported_domain
    return replace(alone, method=Method.INVARIANCE, certificate=own, domain=where, staying=Staying.NONE)


def _curves(result: SystemResult) -> list[str]:
    """The factors of V' on all cells: curves on which it may vanish."""
    found: dict[str, None] = {}
    for cell in () if result.certificate is None else result.certificate.cells:
        for rate in cell.rates:
            factored = factorize(rate) if rate else None
            for factor, _ in () if factored is None else factored[1]:
                found[str(replace(factor, variables=result.scene.states))] = None
    return list(found)


def require_no_roots(system: SwitchedSystem) -> None:
    """Refuse square roots of states.

    Raises:
        NoCertificateError: for a system with such.
    """
    if system.by_roots is not None:
        raise NoCertificateError("a certificate needs formulas without sqrt(Abs(x)), received some with it")


def accepted(certificate: dict[str, Any], check: Callable[[Any], str]) -> dict[str, Any]:
    """The certificate, which a stand-alone checker has accepted.

    Args:
        certificate: what is written.
        check: the checker; it says what is not shown.

    Raises:
        NoCertificateError: where something is not shown.
    """
    refused = check(certificate)
    if refused:
        raise NoCertificateError(f"{UNSHOWN} it: required {refused}")
    return certificate


def accepted_claims(
    write: Callable[[Collection[str]], dict[str, Any]], check: Callable[[Any], str]
) -> tuple[dict[str, Any], dict[str, str]]:
    """A certificate with as many of its claims of region and rate as a checker accepts, and why not the others.

    Args:
        write: the certificate with some of the claims :data:`CLAIMS`, as far as they are made.
        check: the checker; it says what is not shown.

    Raises:
        NoCertificateError: where the verdict itself is not shown.
    """
    whole = write(CLAIMS)
    if not check(whole):
        return whole, {}
    shown, kept, refused = accepted(write(()), check), list[str](), dict[str, str]()
    for claim in CLAIMS:
        tried = write((*kept, claim))
        if tried == shown:
            continue  # not made
        why = check(tried)
        if why:
            refused[claim] = f"{UNSHOWN} it: required {why}"
        else:
            shown = tried
            kept.append(claim)
    return shown, refused


def with_left_out(certificate: dict[str, Any], sentences: Iterable[str]) -> dict[str, Any]:
    """The certificate with what a check says and it does not hold, under its notes."""
    said = list(sentences)
    return {**certificate, "notes": {**certificate["notes"], LEFT_OUT: said}} if said else certificate


def left_out(certificate: Any) -> list[str]:
    """What the notes of a certificate say that it does not hold, as lines; the checkers read no notes."""
    said = certificate["notes"].get(LEFT_OUT, []) if isinstance(certificate["notes"], dict) else []
    lines = said if isinstance(said, list) else []
    return [one_line(str(line))[:LONGEST] for line in lines[:MOST_LEFT_OUT]]


def notes(system: SwitchedSystem) -> dict[str, Any]:
    """The name of the scene, and the stated formulas where the right-hand sides are others; nothing that is proved."""
    found: dict[str, Any] = {"scene": system.name}
    if system.written:
        found["stated"] = [[one_line(formula) for formula in member] for member in system.written]
        found["right-hand sides"] = rewriting_words(system)
    return found


def about(system: SwitchedSystem) -> dict[str, Any]:
    """What a certificate is about; where roots of states stand for these, what was stated."""
    at = system.check.equilibrium
    if system.by_roots is not None:
        names, rooted = system.by_roots.roots.states, system.by_roots.roots.rooted
        stated = [z * abs(z) if name in rooted else z for name, z in zip(names, at, strict=True)]
        rhs = [[one_line(formula) for formula in member] for member in system.written]
        return {"states": list(names), "rhs": rhs, "at": [exact_text(value) for value in stated]}
    return {
        "states": list(system.states),
        "rhs": [[one_line(side.text) for side in member.rhs] for member in system.members],
        "at": [exact_text(value) for value in at],
    }


def find_system_difference(file: str, system: SwitchedSystem) -> str:
    """The first key in which a certificate that was accepted is about another system; empty where there is none.

    Args:
        file: of the certificate.
        system: to compare with, formula by formula as text.

    Raises:
        NoCertificateError: for a point that no certificate can name.
    """
    with open(file, encoding="utf-8") as stream:
        data = json.load(stream)
    return next((f"other {key}" for key, value in about(system).items() if data[key] != value), "")


def certificate_text(certificate: dict[str, Any]) -> str:
    """As the file is written."""
    return json.dumps(certificate, indent=1, ensure_ascii=True) + "\n"


def exact_text(value: Number | Fraction) -> str:
    """A rational number as certificates write it.

    Raises:
        NoCertificateError: for a number with roots.
    """
    text = str(value)
    if not set(text) <= set("-0123456789/"):
        raise NoCertificateError(f"a certificate of a plain system needs rational numbers, received {text[:60]}")
    return text


def _lyapunov(result: SystemResult) -> str | list[dict[str, Any]]:
    pieces = proving_pieces(result)
    if len(pieces) <= 1:
        return str(pieces[0].potential) if pieces else proving_text(result)
    found = []
    for piece in pieces:
        if piece.start is None or piece.end is None:
            raise NoCertificateError("a certificate needs a V on cones with both rays")
        rays = {key: [exact_text(v) for v in ray] for key, ray in (("from", piece.start), ("to", piece.end))}
        found.append({**rays, "V": str(piece.potential)})
    return found


def _rate(rate: DecayRate) -> dict[str, str]:
    return {"kind": rate.decay.name.lower(), "kappa": exact_text(rate.kappa)}
