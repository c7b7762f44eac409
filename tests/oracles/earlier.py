"""What a certificate of version 2 states, in the words of version 1: for checkers that share no code with the new one.

The checkers of version 1 (:mod:`.system_checker`, :mod:`.many_state_checker`) prove systems in one and two states anew,
so that only the statement and V are handed over.  In three states and more they derive inequalities by themselves and
take sums of squares.  Version 1 has no words for some theorems, for claims below a level alone, and for further
functions in three states and more; those certificates have no translation.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any, TypeAlias

from flint import Ordering, fmpq, fmpq_mpoly_ctx

from nonsmooth.proofs.checker import statements
from nonsmooth.proofs.checker.cells import Cell, Domain, Inclusion, System, no_switching, read_system
from nonsmooth.proofs.checker.formulas import Formula
from nonsmooth.proofs.checker.polynomials import Polynomial, constant, lie_derivative
from nonsmooth.proofs.checker.positivity import Claim, Proofs
from nonsmooth.proofs.kernel import squares
from tests.oracles import many_state_checker, system_checker

Record: TypeAlias = dict[str, Any]
Ray: TypeAlias = tuple[Fraction, Fraction]

SAMPLES, HALVINGS = 64, 30  # of an interval in which V stays below a level
SIDE = 8  # points on half a side of a square, at which the sign of V is looked at


class NoWordError(ValueError):
    """Something that version 1 cannot state, in a few words."""


def earlier(certificate: Record) -> Record | None:
    """A certificate of version 1 of the verdict of one of version 2; None where version 1 has no words for it.

    Args:
        certificate: accepted by the checker of version 2.  Its first theorem is the one of the verdict.
    """
    try:
        return translated(certificate)
    except NoWordError:
        return None


def translated(certificate: Record) -> Record:
    """The same.

    Raises:
        NoWordError: where version 1 has no words for it.
    """
    subject = certificate["statement"]["subject"]
    if "numbers" in subject:
        raise NoWordError("irrational numbers")
    if any(wave in formula for side in subject["rhs"] for formula in side for wave in ("sin(", "cos(")):
        raise NoWordError("sines and cosines")
    if any(entry["hypotheses"].get("roots") is not None for entry in certificate["evidence"]):
        raise NoWordError("functions of roots of states")
    if any("denominator" in entry["hypotheses"] for entry in certificate["evidence"]):
        raise NoWordError("a V with a denominator")
    if any(_is_about_space(entry["hypotheses"]) for entry in certificate["evidence"]):
        raise NoWordError("the whole space as the domain")
    rates = [entry["hypotheses"].get("rate") or {} for entry in certificate["evidence"]]
    if any(own.get("kind") == "algebraic" for own in rates):
        raise NoWordError("algebraic rates")
    states = len(subject["states"])
    return {1: _in_one_state, 2: _in_the_plane}.get(states, _in_many_states)(certificate)


def refusal(certificate: Record) -> str:
    """What the checkers of version 1 do not show of one of their certificates; empty where it is valid."""
    of_many = certificate["schema"] == many_state_checker.SCHEMA
    return (many_state_checker if of_many else system_checker).check_certificate(certificate)


class Believed(Proofs):
    """Proofs that show whatever is asked, and keep it: the claims that a theorem derives."""

    def __init__(self) -> None:
        super().__init__({})
        self.asked: dict[str, Claim] = {}

    def show(self, claim: Claim) -> None:
        self.asked[claim.name] = claim

    def shows(self, claim: Claim) -> bool:
        raise NoWordError("surfaces and pieces without a common point")


def _claims(certificate: Record, kind: str) -> list[Any]:
    return [claim[kind] for claim in certificate["statement"]["claims"] if kind in claim]


def _theorem(certificate: Record) -> tuple[str, Record, Record]:
    """The first theorem, its hypotheses and its proofs."""
    entry = certificate["evidence"][0]
    if entry["theorem"] not in ("lyapunov", "instability", "departure"):
        raise NoWordError(f"theorem {entry['theorem']}")
    if entry["hypotheses"].get("below") is True:
        raise NoWordError("claims below a level alone")
    return entry["theorem"], entry["hypotheses"], entry["proofs"]


def _is_about_space(hypotheses: Record) -> bool:
    """Whether a V on the whole space is one of those that version 1 did not know."""
    if {"growth", "logarithm"} & set(hypotheses):
        return True
    if "proper" not in hypotheses:
        return False
    # A surface with a constant term does not pass the point.
    return any(re.search(r"[+-] [0-9/]+$", surface) for surface in hypotheses["cells"]["surfaces"])


def _subject(certificate: Record) -> Record:
    subject = certificate["statement"]["subject"]
    return {key: subject[key] for key in ("states", "rhs", "at")}


def _system(certificate: Record) -> System:
    read: Any = vars(statements).get("read_subject", read_system)
    system: System = read(certificate["statement"]["subject"])
    return system


# ---- one state -----------------------------------------------------------------------------------


def _in_one_state(certificate: Record) -> Record:
    """The verdict, and an interval of starts in the region of V: the signs of the fields decide, without V."""
    if "roots" in certificate["statement"]["subject"]:
        raise NoWordError("roots in one state")
    (verdict,) = _claims(certificate, "stability")
    return {
        "schema": system_checker.SCALAR_SCHEMA,
        **_subject(certificate),
        "verdict": verdict,
        "starts": _starts(certificate),
        "notes": {},
    }


def _starts(certificate: Record) -> list[str] | None:
    """The ends of an interval in the first region that is stated, as far as V stays below the level."""
    (at,) = map(Fraction, certificate["statement"]["subject"]["at"])
    for entry in certificate["evidence"]:
        own = entry["hypotheses"]
        if entry["theorem"] == "lyapunov" and own["level"] is not None:
            level, within = Fraction(own["level"]), Fraction(own["cells"]["within"])
            left, right = (_reach(certificate, own, level, turn * within) for turn in (-1, 1))
            return [str(at - left), str(at + right)]
    return None


def _reach(certificate: Record, hypotheses: Record, level: Fraction, end: Fraction) -> Fraction:
    """The distance from the point up to which V stays below a level, looked at between the point and an end."""

    def is_below(share: Fraction) -> bool:
        return _value(certificate, hypotheses, [share * end]) < level

    first = next((k for k in range(1, SAMPLES + 1) if not is_below(Fraction(k, SAMPLES))), SAMPLES + 1)
    if first > SAMPLES:
        return abs(end)
    inside, outside = Fraction(first - 1, SAMPLES), Fraction(first, SAMPLES)
    for _ in range(HALVINGS):
        middle = (inside + outside) / 2
        inside, outside = (middle, outside) if is_below(middle) else (inside, middle)
    return abs(end) * inside


def _value(certificate: Record, hypotheses: Record, displacement: Sequence[Fraction]) -> Fraction:
    """V at a displacement from the point."""
    system = _system(certificate)
    names = getattr(system, "coordinates", system.states)
    place = {name: constant(1, z) for name, z in zip(names, displacement, strict=True)}

    def sign_of(value: Polynomial) -> int:
        return 1 if value.at_origin >= 0 else -1

    function, surfaces = hypotheses["function"], hypotheses["cells"]["surfaces"]
    if isinstance(function, str):
        return Formula(function, place).on(sign_of).at_origin
    signs = [sign_of(Formula(surface, place).on(no_switching)) for surface in surfaces]
    for mark, formula in function:
        if all(own == "." or own == "-+"[sign > 0] for own, sign in zip(mark, signs, strict=True)):
            return Formula(formula, place).on(sign_of).at_origin
    raise AssertionError(displacement)


# ---- two states ----------------------------------------------------------------------------------


def _in_the_plane(certificate: Record) -> Record:
    """The verdict with V, which the checker of version 1 proves anew on cells of its own."""
    theorem, hypotheses, _ = _theorem(certificate)
    if theorem == "departure":
        raise NoWordError("departure in two states")
    (verdict,) = _claims(certificate, "stability")
    grows = theorem == "instability"
    if grows and hypotheses["second"] is not None:
        raise NoWordError("instability by two functions")
    if grows and _is_positive_somewhere(certificate, hypotheses):
        raise NoWordError("instability by a V of both signs in two states")
    everywhere = "everywhere" in _claims(certificate, "attracts")
    found = {
        "schema": system_checker.SCHEMA,
        **_subject(certificate),
        "radius": None if everywhere else hypotheses["cells"]["within"],
        "lyapunov": _function(hypotheses, _system(certificate), "-({})" if grows else "{}"),
        "verdict": verdict,
        "level": None if everywhere else hypotheses.get("level"),
        "rate": hypotheses.get("rate"),
        "notes": {},
    }
    if "roots" in certificate["statement"]["subject"]:
        found["roots"] = certificate["statement"]["subject"]["roots"]
    if hypotheses["second"] is not None:
        found["curves"] = list(_curves(certificate, hypotheses))
    return found


def _is_positive_somewhere(certificate: Record, hypotheses: Record) -> bool:
    """Whether V is positive at a point of a grid on the border of a square."""
    within = Fraction(hypotheses["cells"]["within"])
    grid = [Fraction(k, SIDE) * within for k in range(-SIDE, SIDE + 1)]
    points = [(x, y) for x in grid for y in grid if max(abs(x), abs(y)) == within]
    return any(_value(certificate, hypotheses, own) > 0 for own in points)


def _function(hypotheses: Record, system: System, sense: str) -> str | list[Record]:
    """V by one formula, or on cones."""
    function = hypotheses["function"]
    if isinstance(function, str):
        return sense.format(function)
    domain = Domain(system, None)
    surfaces = [Formula(own, domain.displacement).on(no_switching) for own in hypotheses["cells"]["surfaces"]]
    found = []
    for mark, formula in function:
        sides = [own.times(1 if s == "+" else -1) for s, own in zip(mark, surfaces, strict=True) if s != "."]
        rays = _cone(sides)
        if rays is not None:
            start, end = ([str(x) for x in ray] for ray in rays)
            found.append({"from": start, "to": end, "V": sense.format(formula)})
    return found


def _cone(sides: Sequence[Polynomial]) -> tuple[Ray, Ray] | None:
    """The rays of a cone, counterclockwise, in which linear forms are positive; None where it has no inside.

    Raises:
        NoWordError: for forms with another zero than a line through the point, and for the whole plane.
    """
    if not sides or any(own.degree != 1 or own.at_origin for own in sides):
        raise NoWordError("pieces of V that are no cones")
    normals = [(own.slope(0), own.slope(1)) for own in sides]
    rays = [(turn * -b, turn * a) for a, b in normals for turn in (1, -1)]
    kept = [(x, y) for x, y in rays if all(a * x + b * y >= 0 for a, b in normals)]
    for start in kept:
        for end in kept:
            turn = start[0] * end[1] - start[1] * end[0]
            # Of a half plane both rays are opposite, and the normal is on the left of the first.
            a, b = normals[0]
            half = not turn and start[0] * end[0] + start[1] * end[1] < 0 and start[0] * b - start[1] * a > 0
            if turn > 0 or half:
                return start, end
    return None


def _curves(certificate: Record, hypotheses: Record) -> Iterator[str]:
    """The factors of V' on all cells, as hints on where it may vanish."""
    system = _system(certificate)
    names = getattr(system, "coordinates", system.states)
    inclusion = Inclusion(system, hypotheses["cells"], [hypotheses["function"]], Believed())
    context = fmpq_mpoly_ctx.get(("a", "b"), Ordering.lex)
    radius, seen = inclusion.domain.radius, set[str]()
    for cell in inclusion.cells:
        for _, field in cell.fields:
            rate = lie_derivative(cell.functions[0], field)
            terms = {e: fmpq(c.numerator, c.denominator) for e, c in rate.terms.items()}
            for factor, _ in context.from_dict(terms).factor()[1] if terms else ():
                text = _text({tuple(map(int, e)): c for e, c in factor.to_dict().items()}, names, radius)
                if text not in seen:
                    seen.add(text)
                    yield text


def _text(terms: Mapping[tuple[int, ...], fmpq], names: Sequence[str], radius: Fraction) -> str:
    """A polynomial of the displacement in units of a radius, as a formula in the displacement."""
    parts = []
    for exponents, coefficient in terms.items():
        own = Fraction(int(coefficient.p), int(coefficient.q)) / radius ** sum(exponents)
        parts.append("*".join([f"({own})", *(f"{name}**{k}" for name, k in zip(names, exponents, strict=True) if k)]))
    return " + ".join(parts)


# ---- three states and more -----------------------------------------------------------------------


def _in_many_states(certificate: Record) -> Record:
    """The statement, and for every inequality that the checker of version 1 derives its sum of squares."""
    theorem, hypotheses, proofs = _theorem(certificate)
    if hypotheses.get("second") is not None:
        raise NoWordError("further functions in three states and more")
    (verdict,) = _claims(certificate, "stability")
    within, function = hypotheses["cells"]["within"], hypotheses.get("function")
    if within is None:
        raise NoWordError("the whole space as the domain")
    if function is not None and not isinstance(function, str):
        raise NoWordError("V by pieces in three states and more")
    found = {
        "schema": many_state_checker.SCHEMA,
        **_subject(certificate),
        "radius": within,
        "verdict": verdict,
        "everywhere": hypotheses.get("everywhere", False),
        "lyapunov": function,
        "direction": hypotheses.get("direction"),
        "level": None if hypotheses.get("everywhere") else hypotheses.get("level"),
        "rate": hypotheses.get("rate"),
        "surfaces": hypotheses["cells"]["surfaces"],
        "empty": [_mixture(mark, proofs[f"empty {mark}"]) for mark in hypotheses["cells"]["empty"]],
        "faces": {},
        "proofs": {},
        "notes": {},
    }
    if function is not None:
        _add_proofs(found, _asked(certificate, theorem, hypotheses), proofs)
    return found


def _asked(certificate: Record, theorem: str, hypotheses: Record) -> dict[str, Claim]:
    """The claims that version 2 derives."""
    proofs = Believed()
    statements.THEOREMS[theorem](_system(certificate), hypotheses, proofs)
    return proofs.asked


def _mixture(mark: str, evidence: Record) -> list[list[Any]]:
    """Surfaces with signs and weights that add to no positive function."""
    if "mixture" not in evidence:
        raise NoWordError("empty patterns by other evidence than mixtures")
    (weights,) = evidence["mixture"]
    last = max(j for j, sign in enumerate(mark) if sign != ".")
    known = {last: "1", **{int(name[1:]): weight for name, weight in weights.items()}}
    return [[j, mark[j], weight] for j, weight in known.items()]


def _add_proofs(found: Record, asked: Mapping[str, Claim], proofs: Record) -> None:
    """Functions mu of faces, and sums of squares by the names of version 1, where every inequality has its own.

    A rate has no functions mu of its own there; it is left out where they differ.
    """
    faces: dict[str, Record] = {}
    shown = {name: _squares(asked[name], proofs[name]) for name in proofs if not name.startswith("empty")}
    for name in shown:
        kind, _, place = name.rpartition(" ")
        if kind in ("face", "rate face"):
            mu = {str(j): own for j, own in zip(_zero(place), shown[name][1], strict=True)}
            if faces.setdefault(place, {"cell": "", "mu": mu})["mu"] != mu:
                found["rate"] = None
    found["faces"] = faces
    for name in _names(found):
        claim, _, rest = name.partition(" cell ") if "face " in name else (name, "", "")
        if claim not in shown:
            raise NoWordError(f"no proof of {claim} in version 2")
        entries = shown[claim][0]
        own = [other for other in found["proofs"] if other.partition(" cell ")[0] == claim]
        found["proofs"][name] = entries[len(own)] if rest else entries[0]


def _zero(place: str) -> list[int]:
    """The numbers of the surfaces that vanish on a face."""
    return [j for j, sign in enumerate(place) if sign == "0"]


def _names(found: Record) -> list[str]:
    """The inequalities that the checker of version 1 derives, by name; the cell beside each face is put in here."""
    names: list[str] = []

    class Listed(many_state_checker.Proofs):
        def show(self, name: str, *_: Any, **__: Any) -> None:
            names.append(name)

    own = many_state_checker.Certificate({**found, "everywhere": False})
    for place, face in found["faces"].items():
        face["cell"] = next(many_state_checker.pattern(cell.signs) for cell in own.cells if _is_beside(cell, place))
    own.proofs = Listed({})
    own.check()
    return names


def _is_beside(cell: many_state_checker.Cell | Cell, place: str) -> bool:
    """Whether a cell has the signs of a face."""
    return all(mark in "0." or mark == "-+"[sign > 0] for mark, sign in zip(place, cell.signs, strict=True))


def _squares(claim: Claim, evidence: Record) -> tuple[list[list[Record]], list[Any]]:
    """Sums of squares for each inequality, and functions mu; searched anew where a certificate has other evidence."""
    if "mixture" in evidence and not claim.inequalities[0].pushes:
        pairs = zip(claim.inequalities, evidence["mixture"], strict=True)
        return [_sum_of_guards(own.value, own.guards, weights) for own, weights in pairs], []
    if "squares" not in evidence:
        searched = squares.search(claim)
        if searched is None:
            raise NoWordError(f"no squares for {claim.name}")
        evidence = searched
    if any("sl" in block["guards"] for blocks in evidence["squares"] for block in blocks):
        raise NoWordError("instability asked where V is not positive alone")
    count = len(claim.inequalities[0].pushes)
    return evidence["squares"], evidence.get("mu") or [[] for _ in range(count)]


def _sum_of_guards(value: Polynomial, guards: Mapping[str, Polynomial], weights: Mapping[str, str]) -> list[Record]:
    """``p = c + sum_g lambda_g g + sum_k |a_k| (1 +- z_k)`` with numbers that are not negative."""
    rest = value
    for name, weight in weights.items():
        rest -= guards[name].times(Fraction(weight))
    named = dict(weights)
    least = rest.at_origin
    for k in range(value.count):
        slope = rest.slope(k)
        side = f"{'d' if slope > 0 else 'u'}{k}"
        if slope:
            named[side] = str(Fraction(named.get(side, "0")) + abs(slope))
            least -= abs(slope)
    blocks = [([name], weight) for name, weight in named.items() if Fraction(weight)]
    blocks += [([], str(least))] if least else []
    return [{"guards": own, "monomials": [[0] * value.count], "gram": [[weight]]} for own, weight in blocks]
