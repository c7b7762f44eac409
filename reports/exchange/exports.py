"""Files of a decided plain system for other programs: provers (.smt2, .kyx), and the field with V (.py, .c)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

LANGUAGES = {".py": "python", ".c": "c"}


def _program(result: Any, ending: str) -> bytes:
    return result.formulas().program(LANGUAGES[ending]).encode()


def _problem(result: Any, ending: str) -> bytes:
    """The inequalities that the certificate of a check of a plain system rests on.

    Raises:
        NoCertificateError: where there is no certificate.
        SceneError: for a verdict that rests on no inequality.
    """
    from nonsmooth.proofs.checker.descriptions import describe
    from nonsmooth.reports.exchange.obligations import keymaerax_text, obligations_of, smtlib_text

    certificate = result.certificate()
    states = " and ".join(f"z{k} of {name}" for k, name in enumerate(result.evidence.scene.states))
    head = [f"{result.evidence.scene.name}: written by nonsmooth. What its certificate states:"]
    head += [f"  {line}" for line in describe(certificate["statement"])]
    head += [f"In displacements from the point over the half-width of the checked cube: {states},"]
    head += ["or what the certificate names in place of a state (a root, sine and cosine)."]
    head += ["A query with weights w is about all mixtures of fields that are tangent to a surface: sliding."]
    text = smtlib_text if ending == ".smt2" else keymaerax_text
    return text(obligations_of(certificate, result.evidence.scene.origin), head).encode()


EXPORTS: Mapping[str, Callable[[Any, str], bytes]] = {
    ".smt2": _problem,
    ".kyx": _problem,
    ".py": _program,
    ".c": _program,
}
