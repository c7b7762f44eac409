"""What a valid certificate states, in words: one line for each claim.  Nothing is shown here."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from decimal import Decimal
from fractions import Fraction
from typing import Any

from .basin import NAMES
from .cells import System
from .outside import is_counterclockwise, place_of
from .roots import RootedSystem, read_subject
from .statements import is_of_array
from .theorem4 import CLAUSES
from .tower import Field, Number
from .work import rational

SHORT = 20  # characters of a number that is printed as it is written


def describe(statement: Any, notes: Any = None) -> list[str]:
    """What a valid certificate states, in lines; the name of an array is told by the notes, which show nothing."""
    if is_of_array(statement["subject"]):
        return _of_array(statement, notes.get("scene") if type(notes) is dict else None)
    return _of_system(statement)


# ---- arrays --------------------------------------------------------------------------------------


def _of_array(statement: Any, name: Any) -> list[str]:
    """The array, the verdicts of all clauses, and every further claim."""
    subject, field = statement["subject"], Field(statement["subject"]["field"])
    x, y, side = (_number(data, field) for data in (*subject["at"], subject["radius"]))
    head = f"array: {len(subject['wheels'])} wheels, rule {subject['rule']}, at ({x}, {y}), square of half side {side}"
    named = f", noted as {str(name)[:60]!r}" if name is not None else ""
    claims = [pair for claim in statement["claims"] for pair in claim.items()]
    words = dict.fromkeys(CLAUSES, "undecided") | {kind: claim for kind, claim in claims if kind in CLAUSES}
    if type(words["equilibrium"]) is bool:
        words["equilibrium"] = "holds" if words["equilibrium"] else "fails"
    further = [_further(kind, claim, field) for kind, claim in claims if kind not in CLAUSES]
    return [head + named, *(f"{clause}: {words[clause]}" for clause in CLAUSES), *further]


def _number(data: Any, field: Field) -> str:
    """A number as it is written, if that is short."""
    return data if type(data) is str and len(data) <= SHORT else f"about {_digits(field.parse(data).rounded)}"


def _digits(value: Fraction, count: int = 6) -> str:
    """So many digits of a number; those that are beyond the range of floats have others, too."""
    try:
        as_float = float(value)
    except OverflowError:
        as_float = 0.0
    if as_float or not value:
        return f"{as_float:.{count}g}"
    return f"{Decimal(value.numerator) / Decimal(value.denominator):.{count}g}"


def _further(kind: str, claim: Any, field: Field) -> str:
    """A claim beside the clauses: c is the centre of mass from the point, c0 a start."""
    if type(claim) is list:  # of three numbers
        a, b, c = (field.parse(data).rounded for data in claim)
        if kind == "obstruction":
            plane = f"{_digits(a)} v_x + {_digits(b)} v_y + {_digits(c)} omega = 0"
            return f"obstruction: no static law serves, near the point all motions obey {plane}, rounded"
        low, high = _digits(a / c), _digits(b / c)
        return f"drift: a body that rests at the point turns at rates from {low} to {high}, rounded"
    if "mesh" in claim:
        starts = f"from one of {len(claim['mesh']['triangles'])} triangles with W < {claim['below']} a body"
        if kind == "attracts":
            return f"attracts: {starts} comes to the point"
        squared = rational(claim["squared_radius"])
        distance = Fraction((Decimal(squared.numerator) / Decimal(squared.denominator)).sqrt())
        return f"ends: {starts} comes to within {_digits(distance, 4)} of the point, rounded, and stays there"
    texts = {key: _number(data, field) for key, data in claim.items() if data is not None and key != "form"}
    starts = f"from abs(c0)^2 <= {texts.get('squared_radius')} a body"
    match kind:
        case "disc":
            falls = "falls off the point" if claim["decreases"] == "strictly" else "does not grow"
            return f"disc: abs(c) {falls} where abs(c)^2 <= {texts['squared_radius']}"
        case "arrival":
            return f"arrival: {starts} is at the point after abs(c0)/{_factor(texts['rate'])} at the latest"
        case "swing":
            return f"swing: {starts} keeps to abs(c)^2 <= {texts['squared_swing']}"
        case "turning":
            return f"turning: {starts} turns by at most {_times(texts['per_distance'], 'abs(c0)')} in all"
        case "feedback rate":
            p, q, s = (_number(data, field) for data in claim["form"])
            where = f" where abs(c)^2 <= {texts['squared_reach']}" if "squared_reach" in texts else ""
            mixed = f" + 2 {_times(q, 'x y')}" if q != "0" else ""
            function = f"V = {_times(p, 'x^2')}{mixed} + {_times(s, 'y^2')} + {_times(texts['weight'], 'theta^2')}"
            return f"feedback rate: the law of gain K has V' <= -2 K {_factor(texts['kappa'])} V{where}, {function}"
    radius, start, rate = (_digits(rational(claim[key]), 4) for key in ("radius", "start", "rate"))
    words = f"bodies from within {start} end within {radius}, at a rate of at least {rate}, rounded"
    return f"within the tolerances: {words}"


def _factor(number: str) -> str:
    """A number as a factor, in brackets where it is not a single whole number."""
    return number if number.isdigit() else f"({number})"


def _times(number: str, name: str) -> str:
    """A number times something; one is left out."""
    return name if number == "1" else f"{_factor(number)} {name}"


# ---- plain systems -------------------------------------------------------------------------------


def _of_system(statement: Any) -> list[str]:
    """The system with its first claim, and every further claim on a line."""
    system = read_subject(statement["subject"])
    point = ", ".join(map(_coordinate, system.at))
    roots = f", {', '.join(system.meanings)}" if isinstance(system, RootedSystem) else ""
    sentences = [OF_SYSTEMS[kind](about, system) for claim in statement["claims"] for kind, about in claim.items()]
    numbers = [_generator(entry) for entry in statement["subject"].get("numbers", [])]
    return [f"system in {', '.join(system.states)} at ({point}){roots}: {sentences[0]}", *sentences[1:], *numbers]


def _coordinate(value: Any) -> str:
    """A fraction as it is, an irrational number rounded."""
    return f"({_digits(value.rounded)} rounded)" if type(value) is Number else str(value)


def _generator(entry: Any) -> str:
    """Which number a name of the formulas stands for; coefficients may be sums of products of earlier ones."""
    texts = [c if type(c) is str else json.dumps(c) for c in entry["polynomial"]]
    terms = [f"({c}) t^{k}" if k else f"({c})" for k, c in enumerate(texts) if c != "0"]
    return f"{entry['name']} is the root t > {entry['above']} of {' + '.join(terms)}"


def _stability(verdict: str, system: System) -> str:
    return verdict


def _equilibrium(claim: bool, system: System) -> str:
    return "0 is not in F at the point: every solution leaves it"


def _attracts(claim: Any, system: System) -> str:
    if claim == "everywhere":
        return "every solution tends to the point"
    if "mesh" in claim:
        kind = NAMES[system.count]
        return f"every start in one of {len(claim['mesh'][kind])} {kind} with W < {claim['below']} tends to the point"
    starts = f"every start with V < {claim['below']} within {_cube(claim, system)}"
    return f"{starts} tends to the point, {_function(claim, system)}"


def _approaches(claim: Any, system: System) -> str:
    if type(claim) is str:
        starts = "every solution" if claim == "everywhere" else "every solution from near the point"
        return f"{starts} approaches the set of equilibria"
    starts = f"every start with V < {claim['below']} within {_cube(claim, system)}"
    return f"{starts} approaches the set of equilibria, {_function(claim, system)}"


def _arrives(claim: Any, system: System) -> str:
    if type(claim) is str:
        return f"every solution arrives {claim}"
    away = _away(system.states, system.at)
    sizes = [f"abs({x})" + (f"^(1/{q})" if q > 1 else "") for x, q in zip(away, claim["orders"], strict=True)]
    size = " + ".join(map(_times, claim["size"], sizes))
    power = "" if claim["power"] == 1 else f"^{claim['power']}"
    whole = size if len(sizes) == 1 and not power else f"({size}){power}"
    return f"every solution is at the point after {_factor(claim['factor'])} {whole} at the latest"


def _outside(claim: Any, system: System) -> str:
    if "ends" in claim:
        return f"no start to the right of a line of {len(claim['corners']) + 1} sides, or on it, comes to the point"
    where = "outside of" if is_counterclockwise(list(map(place_of, claim["corners"]))) else "inside"
    return f"no start {where} a polygon of {len(claim['corners'])} sides, or on it, comes to the point"


def _rate(claim: Any, system: System) -> str:
    power = {"finite": "", "exponential": "V", "algebraic": "V**2"}[claim["kind"]]
    fall = power if power and claim["kappa"] == "1" else f"{claim['kappa']} {power}".rstrip()
    where = "the whole space" if claim["within"] is None else _cube(claim, system)
    below = f" where V < {claim['below']}" if "below" in claim else ""
    rise = f" + {claim['gamma']} |{_disturbance(system)}|" if "gamma" in claim else ""
    return f"V' <= -{fall}{rise} on {where}{below}, {_function(claim, system)}"


def _gain(claim: Any, system: System) -> str:
    return f"with x' in F + {_disturbance(system)}: {_rate(claim, system)}"


def _disturbance(system: System) -> str:
    """What a disturbance is called: d, unless a state is."""
    return next(letter for letter in "dwuvqprstabcefgh" if letter not in system.coordinates)


def _cube(claim: Any, system: System) -> str:
    away = _away(system.coordinates, system.origin)
    return f"{', '.join(f'abs({x})' for x in away)} <= {claim['within']}"


def _away(names: Sequence[str], point: Sequence[Any]) -> list[str]:
    """Coordinates from a point."""
    return [f"{name} - {_coordinate(at)}" if at else name for name, at in zip(names, point, strict=True)]


def _function(claim: Any, system: System) -> str:
    function, bottom = claim["function"], claim.get("denominator")
    words = f"V = {function}" if type(function) is str else f"V in {len(function)} pieces"
    if bottom is not None:
        words = f"V = ({function})/({bottom})" if type(function) is str else f"{words}, each over {bottom}"
    return f"{words} of the displacement" if any(system.origin) else words


OF_SYSTEMS: dict[str, Callable[[Any, System], str]] = {
    "stability": _stability,
    "equilibrium": _equilibrium,
    "attracts": _attracts,
    "approaches": _approaches,
    "arrives": _arrives,
    "outside": _outside,
    "rate": _rate,
    "gain": _gain,
}
