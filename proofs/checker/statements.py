"""What a certificate states, and whether its evidence shows it.

A certificate of version ``nonsmooth-certificate/2`` has three entries, and notes that nobody reads.  The *statement*
names its subject, a plain system or an array of driven wheels, and claims about it.  The *evidence* is a list of
theorems, each with its hypotheses and, by name, the proofs of what these need.  Every theorem derives from the subject
what that is, so a forger cannot leave anything out; what it shows is a list of claims.  The certificate is valid if
every claim of the statement is among those that were shown.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any, TypeAlias

from .cells import System
from .escape import show_escape
from .positivity import Proofs
from .roots import read_subject
from .theorem4 import CLAUSES, show_theorem4
from .theorems import Statement, show_departure, show_instability, show_stability
from .tolerances import show_tolerances
from .wheels import Array, read_array
from .work import BUDGET, MALFORMED, RejectedError, items, rational, require, take

VERSION = "nonsmooth-certificate/2"
MAX_THEOREMS = 20

Theorem: TypeAlias = Callable[[Any, Any, Proofs], list[Statement]]  # of a subject and hypotheses: what it shows

THEOREMS: dict[str, Theorem] = {  # of systems
    "lyapunov": show_stability,
    "instability": show_instability,
    "departure": show_departure,
    "escape": show_escape,
}
OF_ARRAYS: dict[str, Theorem] = {
    "theorem 4": show_theorem4,
    "tolerances": show_tolerances,
}


def is_of_array(subject: Any) -> bool:
    """Whether a subject is an array of driven wheels; else it is a plain system."""
    return type(subject) is dict and "wheels" in subject


def show_claims(data: Any, size: int) -> list[Statement]:
    """Show every claim of a certificate.

    Args:
        data: parsed JSON.
        size: its length in bytes, which limits the work.

    Returns:
        The claims of its statement.

    Raises:
        RejectedError: for a claim that is not shown.
    """
    claims, shown = show_evidence(data, size)
    for claim in not_among(shown, claims):
        require(False, f"evidence of the claim {json.dumps(claim)[:200]}")
    require(claims, "a claim")
    return claims


def show_evidence(data: Any, size: int) -> tuple[list[Statement], list[Statement]]:
    """What a certificate claims, and what its evidence shows of its subject, whatever it claims.

    Raises:
        RejectedError: for a hypothesis that is not shown.
    """
    with BUDGET.granted(size):
        version, statement, evidence, _ = take(data, "version statement evidence", "notes")
        require(version == VERSION, f"the version {VERSION}")
        about, claims = take(statement, "subject claims")
        subject = read_array(about) if is_of_array(about) else read_subject(about)
        shown: list[Statement] = []
        for entry in items(evidence, most=MAX_THEOREMS):
            shown += show_entry(subject, entry)
        return items(claims), shown


def not_among(shown: list[Statement], claims: list[Statement]) -> list[Statement]:
    """The claims that are not among what was shown."""
    texts = {json.dumps(own, sort_keys=True) for own in shown}  # which tell truth values from numbers
    return [claim for claim in claims if json.dumps(claim, sort_keys=True) not in texts]


def show_entry(subject: System | Array, entry: Any) -> list[Statement]:
    """What one theorem shows of a subject by its proofs.

    Raises:
        RejectedError: for a hypothesis that is not shown, and for proofs of what is not asked.
    """
    theorem, hypotheses, data = take(entry, "theorem hypotheses proofs")
    known = OF_ARRAYS if isinstance(subject, Array) else THEOREMS
    require(type(theorem) is str and theorem in known, f"a theorem of {', '.join(known)}")
    proofs = Proofs(data)
    shown = known[theorem](subject, hypotheses, proofs)
    proofs.require_used()
    return shown


def refusal(data: Any, size: int) -> str:
    """Why a certificate is rejected, in one line; empty where it is valid."""
    try:
        show_claims(data, size)
    except RejectedError as error:
        return str(error)
    except MALFORMED as error:
        return f"well-formed data, not a {type(error).__name__}"
    return ""


def describe(statement: Any, notes: Any = None) -> list[str]:
    """What a valid certificate states, in lines; the name of an array is told by the notes, which show nothing."""
    if is_of_array(statement["subject"]):
        return _of_array(statement, notes.get("scene") if type(notes) is dict else None)
    return _of_system(statement)


def _of_array(statement: Any, name: Any) -> list[str]:
    """The array, the verdicts of all clauses, and what is said of arrays within tolerances."""
    subject, named = statement["subject"], f", noted as {str(name)[:60]!r}" if name is not None else ""
    x, y = map(_number, subject["at"])
    side = _number(subject["radius"])
    head = f"array: {len(subject['wheels'])} wheels, rule {subject['rule']}, at ({x}, {y}), square of half side {side}"
    said = {clause: word for claim in statement["claims"] for clause, word in claim.items()}
    if "equilibrium" in said:
        said["equilibrium"] = "holds" if said["equilibrium"] else "fails"
    lines = [f"{head}{named}", *(f"{clause}: {said.get(clause, 'undecided')}" for clause in CLAUSES)]
    if "tolerances" in said:
        radius, start, rate = (f"{float(rational(said['tolerances'][key])):.4g}" for key in ("radius", "start", "rate"))
        lines.append(
            f"within the tolerances: bodies from within {start} end within {radius}, at a rate of at least {rate}"
        )
    return lines


def _number(data: Any) -> str:
    return data if type(data) is str and len(data) < 30 else "an exact number of its field"


def _of_system(statement: Any) -> list[str]:
    """The system with its first claim, and every further claim on a line."""
    system = read_subject(statement["subject"])
    point = ", ".join(map(str, system.at))
    pairs = zip(system.coordinates, system.states, strict=True)
    roots = "".join(f", {own} = sign({name})*sqrt(Abs({name}))" for own, name in pairs if own != name)
    said = []
    for claim in statement["claims"]:
        ((kind, about),) = claim.items()
        said.append(_DESCRIBED[kind](about, system))
    return [f"system in {', '.join(system.states)} at ({point}){roots}: {said[0]}", *said[1:]]


def _stability(said: str, system: System) -> str:
    return said


def _equilibrium(said: bool, system: System) -> str:
    return "0 is not in F at the point: every solution leaves it"


def _attracts(said: Any, system: System) -> str:
    if said == "everywhere":
        return "every solution tends to the point"
    starts = f"every start with V < {said['below']} within {_cube(said, system)}"
    return f"{starts} tends to the point, {_function(said, system)}"


def _rate(said: Any, system: System) -> str:
    fall = f"{said['kappa']} V" if said["kind"] == "exponential" else said["kappa"]
    where = "the whole space" if said["within"] is None else _cube(said, system)
    below = f" where V < {said['below']}" if "below" in said else ""
    rise = f" + {said['gamma']} |d|" if "gamma" in said else ""
    return f"V' <= -{fall}{rise} on {where}{below}, {_function(said, system)}"


def _gain(said: Any, system: System) -> str:
    return f"with x' in F + d: {_rate(said, system)}"


def _cube(said: Any, system: System) -> str:
    away = (name if not at else f"{name} - {at}" for name, at in zip(system.coordinates, system.origin, strict=True))
    return f"{', '.join(f'abs({own})' for own in away)} <= {said['within']}"


def _function(said: Any, system: System) -> str:
    own = said["function"]
    words = f"V = {own}" if type(own) is str else f"V in {len(own)} pieces"
    return f"{words} of the displacement" if any(system.origin) else words


_DESCRIBED: dict[str, Callable[[Any, System], str]] = {
    "stability": _stability,
    "equilibrium": _equilibrium,
    "attracts": _attracts,
    "rate": _rate,
    "gain": _gain,
}
