"""Systems whose certificates are kept as a corpus: small ones by theorem and kind of evidence, of one to eight states.

A case is a subject, a theorem and its hypotheses.  Evidence is searched when the corpus is written; what a case claims
was made up here, and is not taken from a verdict of the program.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise, product
from typing import Any, TypeAlias

from nonsmooth.proofs.checker.roots import read_subject
from nonsmooth.proofs.checker.statements import VERSION
from nonsmooth.proofs.kernel.search import WORK, Search
from nonsmooth.proofs.kernel.second_function import Survey, find_second

Record: TypeAlias = dict[str, Any]

NAMES = ("x", "y", "z", "u", "v", "w", "p", "q")
ATTRACTS, STAYS = "asymptotically stable", "stable"


@dataclass(frozen=True)
class Case:
    """A certificate to be.

    Attributes:
        name: of its file.
        subject: states, right-hand sides and point.
        theorem: its name.
        hypotheses: of the theorem, without proofs.
    """

    name: str
    subject: Record
    theorem: str
    hypotheses: Record

    def certificate(self, work: int = WORK) -> Record:
        """The certificate, with evidence that is searched now.

        Args:
            work: coefficients that the search for simplices may look at, for one claim.

        Raises:
            NotShownError: where a hypothesis is not shown.
        """
        entry, shown = Search(work).entry(read_subject(self.subject), self.theorem, self.hypotheses)
        return {
            "version": VERSION,
            "statement": {"subject": self.subject, "claims": shown},
            "evidence": [entry],
        }


def subject(rhs: Sequence[Any], at: Sequence[str] | None = None) -> Record:
    """A system in as many states as a right-hand side has formulas; with lists of formulas it switches arbitrarily."""
    sides = [list(side) for side in rhs] if isinstance(rhs[0], list) else [list(rhs)]
    count = len(sides[0])
    return {"states": list(NAMES[:count]), "rhs": sides, "at": list(at or ["0"] * count)}


def cells(*surfaces: str, within: str | None = "1", empty: Sequence[str] = (), **more: Any) -> Record:
    """Hypotheses about cells."""
    return {"within": within, "surfaces": list(surfaces), "empty": list(empty), **more}


def lyapunov(function: Any, where: Record, verdict: str = ATTRACTS, **more: Any) -> Record:
    """Hypotheses of theorem ``lyapunov``."""
    bare = {"everywhere": False, "level": None, "below": False, "rate": None, "second": None}
    return {"cells": where, "function": function, "verdict": verdict, **bare, **more}


def instability(function: Any, where: Record, direction: Sequence[str]) -> Record:
    """Hypotheses of theorem ``instability``."""
    return {"cells": where, "function": function, "second": None, "direction": list(direction)}


def rate(kind: str, kappa: str) -> Record:
    """A rate of theorem ``lyapunov``."""
    return {"kind": kind, "kappa": kappa}


def squares_of(names: Sequence[str]) -> str:
    """The sum of the squares of some states."""
    return " + ".join(f"{name}**2" for name in names)


def distances_of(names: Sequence[str]) -> str:
    """The sum of their absolute values."""
    return " + ".join(f"Abs({name})" for name in names)


# ---- theorem lyapunov --------------------------------------------------------------------------


def in_one_state() -> Iterator[Case]:
    """Decay that is linear, of higher order, or by a relay, to points of any kind."""
    sides = {
        "linear": ("-2*x", "x**2", rate("exponential", "4")),
        "cubic": ("-x**3", "x**2", None),
        "linear-and-square": ("-x + x**2/2", "x**2", rate("exponential", "1")),
        "relay": ("-sign(x)", "x**2", None),
        "relay-and-drift": ("-2*sign(x) + x", "Abs(x)", rate("finite", "1")),
        "cubic-friction": ("-x**3", "x**2", rate("algebraic", "2")),
        "steep-side": ("-x - relu(x)", "x**2 + x*Abs(x)/2", rate("exponential", "2")),
        "saturated": ("-sat(2*x, -1, 1)", "x**2", None),
    }
    surfaces = {"relay": ["x"], "relay-and-drift": ["x"], "steep-side": ["x"], "saturated": ["2*x - 1", "2*x + 1"]}
    for name, (side, function, speed) in sides.items():
        for within in ("1", "1/2"):
            where = cells(*surfaces.get(name, []), within=within)
            text = f"one-{name}-{within.replace('/', 'of')}"
            yield Case(text, subject([side]), "lyapunov", lyapunov(function, where))
            if speed is not None:
                yield Case(f"{text}-rate", subject([side]), "lyapunov", lyapunov(function, where, rate=speed))
        yield Case(
            f"one-{name}-region",
            subject([side]),
            "lyapunov",
            lyapunov(function, cells(*surfaces.get(name, [])), level="1/2"),
        )
    moved = subject(["-sign(x - 3/4)"], at=["3/4"])
    yield Case("one-moved", moved, "lyapunov", lyapunov("Abs(x)", cells("x"), rate=rate("finite", "1"), level="1/2"))
    yield Case("one-rests", subject(["-relu(x)"]), "lyapunov", lyapunov("x**2", cells("x"), STAYS))


def slow_rates() -> Iterator[Case]:
    """``V' <= -kappa V**2`` on a cube, and in the whole space."""
    own = {"rate": rate("algebraic", "1/2")}
    for count in (2, 3):
        names = NAMES[:count]
        rhs = ["-y - x**3", "x - y**3", "-z**3"][:count]
        function = " + ".join(f"{name}**2" for name in names)
        for where in ("1/2", None):
            about = {**lyapunov(function, cells(within=where)), **own}
            yield Case(f"slow-{count}-{'space' if where is None else 'cube'}", subject(rhs), "lyapunov", about)


def slow_growth() -> Iterator[Case]:
    """Functions of the whole plane that grow like the distance, or like its logarithm: every start comes."""
    saturated = "-1/2 + Abs(x + 1)*(x + 1)/4 - Abs(x - 1)*(x - 1)/4 + y**2/2"
    for name, side, function, surfaces in (
        ("relay", "-sign(x) - y", "Abs(x) + y**2/2", ["x"]),
        ("saturated", "-sat(x, -1, 1) - y", saturated, ["x - 1", "x + 1"]),
    ):
        about, where = subject(["y", side]), cells(*surfaces, within=None)
        if name == "saturated":
            where["empty"] = ["+-"]
        second = find_second(read_subject(about), where, function)
        hypotheses = {**lyapunov(function, where, everywhere=True), "second": second, "growth": "1/4"}
        yield Case(f"growth-{name}", about, "lyapunov", hypotheses)
    hypotheses = {**lyapunov("y**2", cells(within=None), everywhere=True), "logarithm": "x**2", "proper": "1/4"}
    yield Case("growth-logarithm", subject(["-x + x*y", "-y"]), "lyapunov", hypotheses)


def linear_systems() -> Iterator[Case]:
    """Chains of states, each fed by the one before: sums of squares, or simplices in the plane."""
    for count in range(2, 9):
        names = NAMES[:count]
        sides = ["-x"] + [f"-{own} + {before}/{2 + count % 3}" for before, own in pairwise(names)]
        for name, where, more in (
            ("cube", cells(), {}),
            ("rate", cells(), {"rate": rate("exponential", "1/4")}),
            ("region", cells(within="2"), {"level": "3"}),
            ("everywhere", cells(), {"everywhere": True}),
            ("space", cells(within=None), {"everywhere": True}),
        ):
            if count > 6 and name in ("rate", "region"):
                continue
            chain = subject(sides)
            yield Case(f"chain-{count}-{name}", chain, "lyapunov", lyapunov(squares_of(names), where, **more))
        keeps = [f"{after}" if k % 2 == 0 else f"-{before}" for k, (before, after) in enumerate(_neighbours(names))]
        if count % 2 == 0:
            yield Case(f"centre-{count}", subject(keeps), "lyapunov", lyapunov(squares_of(names), cells(), STAYS))


def _neighbours(names: Sequence[str]) -> list[tuple[str, str]]:
    """Of each state the one before it and the one after it in its pair."""
    return [(names[k - k % 2], names[k - k % 2 + 1]) for k in range(len(names))] if len(names) % 2 == 0 else []


def relays() -> Iterator[Case]:
    """Relays: V that bends on their surfaces, and V that is smooth; faces of all codimensions."""
    for count in (2, 3):
        names = NAMES[:count]
        gains = [str(1 + k) for k in range(count)]
        sides = [f"-{gain}*sign({own})" for gain, own in zip(gains, names, strict=True)]
        where, bent = cells(*names), distances_of(names)
        yield Case(f"relays-{count}", subject(sides), "lyapunov", lyapunov(bent, where))
        yield Case(f"relays-{count}-smooth", subject(sides), "lyapunov", lyapunov(squares_of(names), where))
        yield Case(f"relays-{count}-region", subject(sides), "lyapunov", lyapunov(bent, where, level="1"))
        yield Case(f"relays-{count}-everywhere", subject(sides), "lyapunov", lyapunov(bent, where, everywhere=True))
    for speed in ("1/2", "3/4", "1"):
        sides = ["-sign(x)", "-2*sign(y)"]
        name = f"relays-rate-{speed}".replace("/", "of")
        hypotheses = lyapunov("Abs(x) + Abs(y)", cells("x", "y"), rate=rate("finite", speed))
        yield Case(name, subject(sides), "lyapunov", hypotheses)
    for slope, drift in product(("0", "1/4", "1/2", "3/4"), repeat=2):
        sides = [f"-sign(x) + {slope}*y", f"-sign(y) - {drift}*x"]
        name = f"relays-{slope}-{drift}".replace("/", "of")
        yield Case(name, subject(sides), "lyapunov", lyapunov("Abs(x) + Abs(y)", cells("x", "y"), level="1/2"))
    for a, b in ((2, 1), (3, 1), (1, 2), (3, 2)):
        lines = (f"{a}*x + {b}*y", f"{a}*y - {b}*x")
        sides = [
            f"-{a}*sign({lines[0]}) + {b}*sign({lines[1]})",
            f"-{b}*sign({lines[0]}) - {a}*sign({lines[1]})",
        ]
        bent = f"Abs({lines[0]}) + Abs({lines[1]})"
        yield Case(f"relays-on-{a}-{b}", subject(sides), "lyapunov", lyapunov(bent, cells(*lines)))


def nonlinear_systems() -> Iterator[Case]:
    """Polynomial fields, and sums and products of states as surfaces."""
    cubes = ["-x**3 - x", "-y - y**3 + x*y/4", "-z - x*y/4", "-u - u*z/4"]
    for count in range(2, 5):
        names = NAMES[:count]
        yield Case(f"cubic-{count}", subject(cubes[:count]), "lyapunov", lyapunov(squares_of(names), cells()))
        below = lyapunov(squares_of(names), cells(), level="1/2", below=True)
        yield Case(f"cubic-{count}-below", subject(cubes[:count]), "lyapunov", below)
        fast: Record = {"rate": rate("exponential", "1"), "level": "1/2", "below": True}
        hypotheses = lyapunov(squares_of(names), cells(), **fast)
        yield Case(f"cubic-{count}-below-rate", subject(cubes[:count]), "lyapunov", hypotheses)
    lorenz = subject(["10*(y - x)", "x/2 - y - x*z", "x*y - 8*z/3"])
    yield Case("lorenz", lorenz, "lyapunov", lyapunov("x**2/10 + y**2 + z**2", cells(), level="1/20"))
    curved = subject(["-x", "-y", "-z + Abs(x*y - z)/2"])
    yield Case("curved-surface", curved, "lyapunov", lyapunov(squares_of("xyz"), cells("x*y - z")))
    parabola = subject(["-x", "-y + Abs(y - x**2)/4"])
    yield Case("parabola", parabola, "lyapunov", lyapunov(squares_of("xy"), cells("y - x**2")))
    circle = subject(["-x*(3 + sign(1 - x**2 - y**2))", "-y"])
    yield Case("circle", circle, "lyapunov", lyapunov(squares_of("xy"), cells("1 - x**2 - y**2", within="2")))
    frame = [[["2", "1"], ["1", "-1"]], [["1/3", "1/3"], ["1/3", "-2/3"]]]  # of u = (x + y)/3 and w = (x - 2 y)/3
    skew = cells(within="1/4", frame=frame)
    yield Case("frame", subject(["2*y - x - x**3", "x - 2*y"]), "lyapunov", lyapunov("(x + y)**2 + (x - 2*y)**2", skew))
    away = instability("(x - 2*y)**2 - x - y", skew, ["1", "0"])
    yield Case("frame-away", subject(["2*y - x + x**2", "x - 2*y"]), "instability", away)
    bent = cells(within="1/8", coordinates=[["x", "y + x**2"], ["x", "y - x**2"]])  # of u = x and w = y - x**2
    yield Case("bent", subject(["-x*y**2", "-y + x**2"]), "lyapunov", lyapunov("x**2/2 + (y - x**2)**2", bent))
    away = instability("(y - x**2)**2 - x**2/2", bent, ["1", "0"])
    yield Case("bent-away", subject(["x*y**2", "-y + x**2"]), "instability", away)
    squared = lyapunov(squares_of("xy"), cells(within="1/2"))
    yield Case("tanh", subject(["-tanh(x) + y/4", "-atan(y) - y*exp(-x**2 - (2*y)**4/3)"]), "lyapunov", squared)
    folded = ["-tanh(Abs(x) + 2*relu(x))*sign(x) + y/4", "-y*exp(-Abs(y - x)/2) - sin(Max(y, -x))/8"]
    on_cells = lyapunov(squares_of("xy"), cells("x", "x - y", "x + y", within="1/2"))
    yield Case("waves-of-what-switches", subject(folded), "lyapunov", on_cells)
    rows = subject(["-x + relu(y - 1/8)/4", "-y + relu(x - 1/4)/4"])
    yield Case("rectifiers", rows, "lyapunov", lyapunov(squares_of("xy"), cells("y - 1/8", "x - 1/4")))


def switched_systems() -> Iterator[Case]:
    """Arbitrary switching, and functions in pieces."""
    for count in range(1, 7):
        names = NAMES[:count]
        fields = [
            [f"-{own}" for own in names],
            [f"-2*{own} + {NAMES[(k + 1) % count]}/2" for k, own in enumerate(names)],
            [f"-{own} - {NAMES[(k + 1) % count]}/4" for k, own in enumerate(names)],
        ]
        for number in (2, 3):
            name = f"switched-{count}-{number}"
            yield Case(name, subject(fields[:number]), "lyapunov", lyapunov(squares_of(names), cells()))
    for weight in ("2", "3", "4"):
        pieces: Any = [["+", f"x**2 + {weight}*y**2"], ["-", "x**2 + y**2"]]
        sides = ["-x", "-y"]
        name = f"pieces-{weight}"
        yield Case(name, subject(sides), "lyapunov", lyapunov(pieces, cells("y"), level="1/2"))
        corner: list[Any] = [
            ["++", f"{weight}*x + {weight}*y"],
            ["+-", f"{weight}*x - y"],
            ["-+", f"{weight}*y - x"],
            ["--", "-x - y"],
        ]
        yield Case(f"pieces-bent-{weight}", subject(sides), "lyapunov", lyapunov(corner, cells("x", "y")))
        largest = f"Max({weight}*Abs(x), Abs(y))"
        lines = ("x", "y", f"{weight}*x - y", f"{weight}*x + y")
        yield Case(f"largest-{weight}", subject(sides), "lyapunov", lyapunov(largest, cells(*lines, empty=CONES)))


CONES = ("+--.", "-++.", "++.-", "--.+")  # signs of x, y, a x - y and a x + y that contradict each other


def by_a_second_function() -> Iterator[Case]:
    """A V that stands still on a line, and W: the principle of LaSalle."""
    for damping in ("1/2", "1", "2"):
        oscillator = subject(["y", f"-x - {damping}*y"])
        name = damping.replace("/", "of")
        hypotheses = with_second(oscillator, lyapunov("x**2 + y**2", cells()))
        yield Case(f"second-{name}", oscillator, "lyapunov", hypotheses)
        cubic = subject(["y", f"-x - {damping}*y - x**3"])
        hypotheses = with_second(cubic, lyapunov("x**2 + x**4/2 + y**2", cells()))
        yield Case(f"second-{name}-cubic", cubic, "lyapunov", hypotheses)
        region = with_second(oscillator, lyapunov("x**2 + y**2", cells(), level="1"))
        yield Case(f"second-{name}-region", oscillator, "lyapunov", region)
    friction = subject(["y", "-2*x - sign(y) - y"])
    hypotheses = lyapunov("2*x**2 + y**2", cells("y"), STAYS)
    yield Case("friction", friction, "lyapunov", hypotheses)
    twisting = subject(["y", "-2*sign(x) - sign(y)"])
    hypotheses = with_second(twisting, lyapunov("2*Abs(x) + y**2/2", cells("x", "y")))
    yield Case("twisting", twisting, "lyapunov", hypotheses)
    for factor in ("1/4", "1"):
        curve, other = f"x + {factor}*y**2", f"x - {factor}*y**2"
        line = f"x + {factor}*y*Abs(y)"
        bang_bang = subject(["y", f"-sign({line})"])
        where = cells("y", curve, other, within="1/8")
        hypotheses = with_second(bang_bang, lyapunov(f"Abs({line}) + y**2/2", where))
        yield Case(f"bang-bang-{factor.replace('/', 'of')}", bang_bang, "lyapunov", hypotheses)
    damped_at_an_end = subject(["y", "-x - z", "y - z**3"])
    hypotheses = with_second(damped_at_an_end, lyapunov("x**2 + y**2 + z**2", cells()))
    yield Case("chain", damped_at_an_end, "lyapunov", hypotheses)


def with_second(about: Record, hypotheses: Record) -> Record:
    """The hypotheses with functions that rise where V is kept."""
    found = find_second(read_subject(about), hypotheses["cells"], hypotheses["function"])
    assert found is not None
    return {**hypotheses, "second": found}


# ---- theorem approach --------------------------------------------------------------------------


def sets_of_equilibria() -> Iterator[Case]:
    """Dry friction on one mass and on one of two, an epidemic, and agents that agree, with signs too."""
    friction, chain = subject(["y", "-x - sign(y)"]), subject(["z", "u", "y - 2*x - z", "x - 2*y - 2*sign(u)"])
    epidemic, agree = subject(["-x*y", "x*y - y"]), subject(["y - x", "x - 2*y + z", "y - z"])
    signs = subject(["sign(y - x)", "sign(x - y) + sign(z - y)", "sign(y - z)"])
    yield approach("friction", friction, squares_of("xy"), cells("y", within=None), proper="1/4")
    form = "2*x**2 - 2*x*y + 2*y**2 + z**2 + u**2"
    yield approach("friction-on-one-of-two", chain, form, cells("u", within="1/4"), level="1/32")
    yield approach("epidemic", epidemic, "x**2 - 2/3*x**3 - 2*x**2*y + 16*y**2", cells(within="1/8"))
    yield approach("agree", agree, squares_of("xyz"), cells(within=None), proper="1")
    yield approach("agree-by-signs", signs, squares_of("xyz"), cells("x - y", "y - z"), level="1/2")


def approach(name: str, about: Record, function: str, where: Record, **more: str) -> Case:
    """A case of theorem ``approach``."""
    zeros = Survey(read_subject(about), where, function, [], Search(WORK), None).zeros
    own = {"cells": where, "function": function, "zeros": zeros, "level": None, "proper": None, **more}
    return Case(f"approach-{name}", about, "approach", own)


# ---- theorems instability and departure --------------------------------------------------------


def unstable_systems() -> Iterator[Case]:
    """Repellers, saddles and relays of the wrong sign."""
    for count in range(1, 9):
        names = NAMES[:count]
        sides = [f"{own} + {NAMES[(k + 1) % count]}/4" for k, own in enumerate(names)]
        function, axis = f"-({squares_of(names)})", ["1"] + ["0"] * (count - 1)
        yield Case(f"repeller-{count}", subject(sides), "instability", instability(function, cells(), axis))
        if count > 1:
            saddle = ["2*x"] + [f"-{own} + x/4" for own in names[1:]]
            function = f"{squares_of(names[1:])} - x**2"
            yield Case(f"saddle-{count}", subject(saddle), "instability", instability(function, cells(), axis))
        if count < 4:
            outward = [f"sign({own})" for own in names]
            slanted = [str(1 + k) for k in range(count)]
            bent = f"-({distances_of(names)})"
            yield Case(f"outward-{count}", subject(outward), "instability", instability(bent, cells(*names), slanted))
    for power in (2, 3, 4):
        side = f"x**{power}"
        function = "-x" if power % 2 == 0 else "-x**2"
        yield Case(f"power-{power}", subject([side]), "instability", instability(function, cells(), ["1"]))
        pair = subject([side, "-y"])
        function = "y**2 - x" if power % 2 == 0 else "y**2 - x**2"
        yield Case(f"power-{power}-and-decay", pair, "instability", instability(function, cells(), ["1", "0"]))
    for damping in ("1/2", "1", "2"):
        oscillator = subject(["y", f"-x + {damping}*y"])
        name = f"grows-{damping.replace('/', 'of')}"
        hypotheses = with_second(oscillator, instability("-(x**2 + y**2)", cells(), ["1", "0"]))
        yield Case(name, oscillator, "instability", hypotheses)
    moved = subject(["x - 1", "sign(y)"], at=["1", "0"])
    yield Case("repeller-moved", moved, "instability", instability("-x**2 - Abs(y)", cells("y"), ["0", "1"]))


def points_without_rest() -> Iterator[Case]:
    """Points at which 0 is not in F."""
    for count in range(1, 9):
        names = NAMES[:count]
        drift = subject(["1 + x**2"] + [f"-{own}" for own in names[1:]])
        axis = ["1"] + ["0"] * (count - 1)
        yield Case(f"drift-{count}", drift, "departure", {"cells": cells(), "direction": axis})
        if count < 6:
            relay = subject([f"2 + sign({names[-1]})"] + [f"-sign({own})" for own in names[1:]])
            hypotheses = {"cells": cells(*names), "direction": axis}
            yield Case(f"drift-{count}-relays", relay, "departure", hypotheses)
    for a, b in ((1, 1), (2, 1), (1, 3)):
        curve = f"y - {a}*x**2"
        sides = subject([f"{b} + sign({curve})/2", "-sign(y)"])
        hypotheses = {"cells": cells(curve, "y"), "direction": ["1", "0"]}
        yield Case(f"drift-curve-{a}-{b}", sides, "departure", hypotheses)
        space = {"cells": cells(curve, "y", within=None), "direction": ["2", "0"]}
        yield Case(f"drift-curve-{a}-{b}-space", sides, "departure", space)


def escape(where: Record, signs: str, mixture: Sequence[Any], function: str, **more: Any) -> Record:
    """Hypotheses of theorem ``escape``: in the direction of the first state, where none is given."""
    listed = {"within": where["within"], "surfaces": where["surfaces"], "signs": signs}
    bare: Record = {"along": [], "barriers": [], **more}
    return {**listed, "mixture": list(mixture), "function": function, **bare}


def solutions_that_leave() -> Iterator[Case]:
    """One solution inside a cell, along a surface, or along a mixture of right-hand sides."""
    for power in range(1, 5):
        hypotheses = escape(cells(), "", [["", 0, "1", ["1"]]], "x", direction=["1"])
        yield Case(f"leaves-power-{power}", subject([f"x**{power}"]), "escape", hypotheses)
        hypotheses = escape(cells("x"), "+", [["+", 0, "1", ["1"]]], "x", direction=["1"])
        yield Case(f"leaves-relay-{power}", subject([f"sign(x) - x**{power}/2"]), "escape", hypotheses)
    for count in range(2, 9):
        names, none = NAMES[:count], ["0"] * count
        axis = ["1", *none[1:]]
        saddle = subject([f"{own}" if k == 0 else f"-{own}" for k, own in enumerate(names)])
        hypotheses = escape(cells(), "", [["", 0, "1", none]], "x", along=list(names[1:]), direction=axis)
        yield Case(f"leaves-saddle-{count}", saddle, "escape", hypotheses)
        sides = ["x", *(f"-{own}" for own in names[1:-1]), f"-sign({names[-1]}) + 1/2"]
        beside = [[mark, 0, weight, [*none[1:], sign]] for mark, weight, sign in (("+", "3", "1"), ("-", "1", "-1"))]
        sliding = escape(cells(names[-1]), "0", beside, "x", along=list(names[1:-1]), direction=axis)
        yield Case(f"leaves-sliding-{count}", subject(sides), "escape", sliding)
    for fast in ("2", "3", "4"):
        barrier = [["x**2 - y**2", "2"]]
        hypotheses = escape(cells(), "", [["", 0, "1", ["0", "0"]]], "x", barriers=barrier, direction=["1", "0"])
        yield Case(f"leaves-cone-{fast}", subject([f"{fast}*x", "y"]), "escape", hypotheses)
        switched = subject([["x + y", f"-y + {fast}*x"], ["x - y", f"-y - {fast}*x"]])
        mixed = [["", 0, "1", ["0", "0"]], ["", 1, "1", ["0", "0"]]]
        hypotheses = escape(cells(), "", mixed, "x", along=["y"], direction=["1", "0"])
        yield Case(f"leaves-switched-{fast}", switched, "escape", hypotheses)
    for power in range(1, 5):
        hypotheses = escape(cells(), "", [["", 0, "1", ["0", "0"]]], "x*y", direction=["1", "1"], speed="1/4")
        yield Case(f"leaves-slowly-{power}", subject(["y", f"x**{2 * power + 1}"]), "escape", hypotheses)


def systems_with_roots() -> Iterator[Case]:
    """Square roots of a state, judged in its signed root."""
    root = "sign(x)*sqrt(Abs(x))"
    for name, side in (("plain", f"-{root}"), ("and-decay", f"-{root} - x"), ("and-growth", f"-2*{root} + x")):
        own = {**subject([side]), "roots": ["x"]}
        hypotheses = lyapunov("root_x**2", cells("root_x", within="1/2"))
        yield Case(f"root-{name}", own, "lyapunov", hypotheses)
    two = {"numbers": [{"name": "sqrt_2", "polynomial": ["-2", "0", "1"], "above": "0"}]}
    irrational = {**subject([f"-sqrt_2*{root} + x"]), "roots": ["x"], **two}
    yield Case("root-irrational", irrational, "lyapunov", lyapunov("root_x**2", cells("root_x", within="1/2")))
    grows = {**subject([root]), "roots": ["x"]}
    yield Case("root-grows", grows, "instability", instability("-root_x**2", cells("root_x"), ["1"]))
    third = {**subject(["-sign(x)*Abs(x)**(2/3) + 2*x"]), "roots": ["x"], "orders": [3]}
    yield Case("root-third", third, "lyapunov", lyapunov("root_x**2", cells("root_x", within="1/4")))
    drift = {**subject([f"1 + {root}"]), "roots": ["x"]}
    yield Case("root-drift", drift, "departure", {"cells": cells("root_x"), "direction": ["1"]})


def sines_beside_roots() -> Iterator[Case]:
    """The sine of a state that is judged in its root."""
    about = {**subject(["-sign(x)*sqrt(Abs(x)) + sin(x)"]), "roots": ["x"], "order": 0}
    yield Case("root-sines", about, "lyapunov", lyapunov("root_x**2", cells("root_x", within="1/2")))


def functions_of_roots() -> Iterator[Case]:
    """A V about roots of states in their own time: what slides along a zero of one, what leaves, and what arrives."""
    slides, root = subject(["-10*sign(x)", "-y"]), "sign(x)*Abs(x)**(1/3)"
    for order, function in ((2, "root_x**2 + y**2"), (3, "Abs(root_x)**3 + y**2"), (4, "root_x**4 + y**2")):
        hypotheses = {**lyapunov(function, cells("root_x")), "roots": {"x": order}}
        yield Case(f"roots-slide-{order}", slides, "lyapunov", hypotheses)
    third, rooted = {"roots": {"x": 3}}, {"roots": ["x"], "orders": [3]}
    falls = {**lyapunov("Abs(root_x)**3", cells("root_x"), everywhere=True), **third}
    yield Case("roots-third", {**subject([f"-{root}"]), **rooted}, "lyapunov", falls)
    rises = {**instability("-Abs(root_x)**3", cells("root_x"), ["1"]), **third}
    yield Case("roots-leave", {**subject([root]), **rooted}, "instability", rises)
    box = {**cells("root_x", "y"), "within": ["1/4", "2"]}
    twice = {**lyapunov("8*Abs(root_x)**3 + y**2", box), "roots": {"x": 3}}
    yield Case("roots-box", slides, "lyapunov", twice)
    at_once = {"size": ["1"], "above": "1", "speed": "1", "power": 1}
    arrives = {**lyapunov("root_x**2", cells("root_x"), everywhere=True), "roots": {"x": 2}, "arrival": at_once}
    tanks, both = subject(["-sign(x)*sqrt(Abs(x))", "-sign(y)*sqrt(Abs(y))"]), {"roots": {"x": 2, "y": 2}}
    falls = {**lyapunov("root_x**2 + root_y**2", cells("root_x", "root_y"), everywhere=True), **both}
    slowest = {"size": ["1", "1"], "above": "1", "speed": "1", "power": 1}
    yield Case("roots-arrive-both", {**tanks, "roots": ["x", "y"]}, "lyapunov", {**falls, "arrival": slowest})
    yield Case("roots-arrive", {**subject(["-sign(x)*sqrt(Abs(x))"]), "roots": ["x"]}, "lyapunov", arrives)


def jumps_with_what_is_continuous() -> Iterator[Case]:
    """A relay of a state and of what saturates another one, which drives it."""
    fall = entry_about("x", ["-x**3"], "lyapunov", lyapunov("x**2", cells()))
    relay = entry_about("y", ["-sign(y)"], "lyapunov", lyapunov("y**2", cells("y")))
    listed = [{"states": ["x"], "entry": fall}, {"states": ["y"], "entry": relay, "jumps": "continuous"}]
    yield Case("cascade-saturated", subject(["-x**3", "-sign(y + sat(x, -1, 1))"]), "cascade", {"parts": listed})


def homogeneous_systems() -> Iterator[Case]:
    """What holds near the point holds everywhere; of negative degree solutions arrive."""
    third = {"roots": ["x"], "orders": [3]}
    for name, side, surfaces, weights, more in (
        ("linear", ["-x + y**3", "-y"], [], ["3", "1"], {}),
        ("relays", ["-2*sign(x) + sign(y)", "-sign(y)"], ["x", "y"], ["1", "1"], {}),
        ("root", ["-sign(x)*Abs(x)**(2/3)"], ["root_x"], ["1/2"], third),
    ):
        about = {**subject(side), **more}
        function = "root_x**2" if more else "x**2 + y**2"
        local = Case("", about, "lyapunov", lyapunov(function, cells(*surfaces, within="1/2")))
        (entry,) = local.certificate()["evidence"]
        hypotheses = {"cells": cells(*surfaces, within=None), "weights": weights, "entry": entry}
        yield Case(f"homogeneous-{name}", about, "homogeneous", hypotheses)


def gains() -> Iterator[Case]:
    """What disturbances add to a rate."""
    for count, gamma in product((1, 2, 3), ("3", "4")):
        names = NAMES[:count]
        decay = subject([f"-{own}" for own in names])
        own: Record = {"rate": rate("exponential", "1"), "gain": gamma if count < 3 else str(2 * int(gamma))}
        yield Case(f"gain-{count}-{gamma}", decay, "lyapunov", lyapunov(squares_of(names), cells(), **own))
    relay = lyapunov("Abs(x)", cells("x"), rate=rate("finite", "1"), gain="1")
    yield Case("gain-relay", subject(["-sign(x)"]), "lyapunov", relay)


def diamonds(sizes: Sequence[int], unit: str = "1/4") -> Record:
    """A mesh between nested diamonds: W is 0 on the first, and one more on each."""
    corners, triangles = list[str](), list[str]()
    for k, size in enumerate(sizes):
        corners += [f"{size} 0 {k}", f"0 {size} {k}", f"-{size} 0 {k}", f"0 -{size} {k}"]
        for j in range(4 if k else 0):
            inner, outer, before = 4 * k - 4 + j, 4 * k + j, 4 * k + (j + 1) % 4
            triangles += [f"{inner} {outer} {before}", f"{inner} {before} {before - 4}"]
    return {"unit": unit, "corners": corners, "triangles": triangles}


def basins() -> Iterator[Case]:
    """Meshes about a level set: of one field, of two, and of relays on lines and a curve, on which W bends or not."""
    systems: dict[str, tuple[Any, list[str]]] = {
        "plain": (["-x", "-y"], []),
        "cubic": (["-x - x**3", "-y + x*y**2/64"], []),
        "switched": ([["-x", "-y"], ["-x - y/2", "-y + x/2"]], []),
        "relay": (["-x - sign(x)", "-y"], ["x"]),
        "beside": (["-x - sign(x - y)", "-y + sign(x - y)"], ["x - y"]),
        "valley": (["-x", "-y/8 - sign(y)"], ["y"]),
        "curve": (["-x - relu(x - y**2/16)/4", "-y"], ["x - y**2/16"]),
        "sines": (["-x - sin(x - y)/4", "-y + (cos(y) - 1)/8"], []),
        "sines-relay": (["-x - sign(x)", "-y + sin(x)/4"], ["x"]),
    }
    for name, (sides, surfaces) in systems.items():
        local = lyapunov("x**2 + y**2", cells(*surfaces), level="1/2")
        for sizes in ((2, 4), (2, 3, 4)) if name.startswith("sines") else ((2, 8), (2, 8, 24)):
            hypotheses = {"local": local, "surfaces": surfaces, "mesh": diamonds(sizes), "below": len(sizes) - 1}
            yield Case(f"basin-{name}-{len(sizes) - 1}", subject(sides), "basin", hypotheses)


def octahedra(sizes: Sequence[int], unit: str = "1/4") -> Record:
    """A mesh between nested octahedra: W is 0 on the first, and one more on each."""
    corners, tetrahedra = list[str](), list[str]()
    for k, size in enumerate(sizes):
        corners += [f"{size} 0 0 {k}", f"0 {size} 0 {k}", f"0 0 {size} {k}"]
        corners += [f"-{size} 0 0 {k}", f"0 -{size} 0 {k}", f"0 0 -{size} {k}"]
        for signs in product((0, 1), repeat=3) if k else ():
            a, b, c = (6 * k - 6 + axis + 3 * sign for axis, sign in enumerate(signs))
            for own in ((a, b, c, c + 6), (a, b, c + 6, b + 6), (a, a + 6, b + 6, c + 6)):
                first, second, *rest = own
                turned = (second, first, *rest) if sum(signs) % 2 else own
                tetrahedra.append(" ".join(map(str, turned)))
    return {"unit": unit, "corners": corners, "tetrahedra": tetrahedra}


def basins_in_space() -> Iterator[Case]:
    """Meshes of tetrahedra about a level set: of one field, of two, with a sine, and of relays on sides and across."""
    systems: dict[str, tuple[list[Any], list[str]]] = {
        "plain": (["-x", "-y", "-z"], []),
        "cubic": (["-x - x**3", "-y + x*y**2/64", "-z"], []),
        "switched": ([["-x", "-y", "-z"], ["-x - y/2", "-y + x/2", "-z"]], []),
        "sines": (["-x", "-y - sin(x - y)/4", "-z"], []),
        "relay": (["-x - 8*sign(x)", "-y + y**3/8", "-z"], ["x"]),
        "relays": (["-x - sign(x)", "-y - sign(y)", "-z"], ["x", "y"]),
        "beside": (["-x - sign(x - y)", "-y + sign(x - y)", "-z"], ["x - y"]),
        "saturated": (["-x", "-y", "-z - sat(x + z, -1, 1)/4"], ["x + z - 1", "x + z + 1"]),
    }
    for name, (sides, surfaces) in systems.items():
        local = lyapunov("x**2 + y**2 + z**2", cells(*surfaces), level="1/2")
        for sizes in ((2, 4), (2, 3, 4)) if name != "relay" else ((2, 8),):
            hypotheses = {"local": local, "surfaces": surfaces, "mesh": octahedra(sizes), "below": len(sizes) - 1}
            yield Case(f"space-{name}-{len(sizes) - 1}", subject(sides), "basin", hypotheses)


def energies_on_circles() -> Iterator[Case]:
    """Pendulums that swing for ever: with one potential, with a relay beside it, with a second one, and two coupled."""
    systems: dict[str, tuple[Any, list[str], list[str], str]] = {
        "pendulum": (["y", "-sin(x)"], ["x"], [], "y**2 + sin_x**2 + cos_x**2"),
        "faster": (["2*y", "-3*sin(x)"], ["x"], [], "2*y**2 + 3*sin_x**2 + 3*cos_x**2"),
        "dry": (["y", "-sin(x) - sign(y)"], ["x"], ["y"], "y**2 + sin_x**2 + cos_x**2"),
    }
    for name, (sides, angles, surfaces, function) in systems.items():
        hypotheses = {"angles": angles, "cells": cells(*surfaces), "function": function}
        yield Case(f"circles-{name}", subject(sides), "circles", hypotheses)
    own = ["z", "u", "-sin(x) - sin(x - y)", "-sin(y) + sin(x - y)"]
    coupling = "sin_x*sin_y + cos_x*cos_y"
    function = f"z**2 + u**2 + 2*(sin_x**2 + cos_x**2 + sin_y**2 + cos_y**2) - 2*({coupling})"
    hypotheses = {"angles": ["x", "y"], "cells": cells(), "function": function}
    yield Case("circles-coupled", subject(own), "circles", hypotheses)


def polygons() -> Iterator[Case]:
    """Polygons over which all velocities lead outward: of one field, of two, and with relays on a line and a curve."""
    systems: dict[str, tuple[Any, list[str]]] = {
        "plain": (["x", "y"], []),
        "cubic": (["-x + x**3", "-y + y**3"], []),
        "turning": ([["x - y/2", "x/2 + y"], ["x + y/2", "y - x/2"]], []),
        "relay": (["x + sign(x)", "y - x/4"], ["x"]),
        "curve": (["x + relu(x - y**2/16)/4", "y"], ["x - y**2/16"]),
    }
    shapes = {
        "square": ["8 -8", "8 8", "-8 8", "-8 -8"],
        "notched": ["8 -8", "8 8", "0 6", "-8 8", "-8 -8"],
    }
    for (name, (sides, surfaces)), (shape, corners) in product(systems.items(), shapes.items()):
        hypotheses = {"surfaces": surfaces, "unit": "1/4", "corners": corners}
        yield Case(f"outside-{name}-{shape}", subject(sides), "outside", hypotheses)
    trap = {"surfaces": ["x - 1"], "unit": "1/4", "corners": ["6 4", "14 4", "14 -4", "6 -4"]}
    yield Case("outside-trap", subject(["-x + 3*(1 + sign(x - 1))/2", "-y"]), "outside", trap)
    lines = {
        "saddle": (["-x + x**3", "-y"], [], ["9 -8", "9 8"], ["0 -1", "0 1"]),
        "spring": (["y", "-x + x**3 - y"], [], ["6 -1", "5 1"], ["1 0", "0 1"]),
        "cone": (["x + sign(x - 1)", "y + x/8"], ["x - 1"], ["8 8"], ["1 0", "0 1"]),
    }
    for name, (rhs, surfaces, corners, ends) in lines.items():
        about = {"surfaces": surfaces, "unit": "1/8" if name == "saddle" else "1/4", "corners": corners, "ends": ends}
        yield Case(f"outside-line-{name}", subject(rhs), "outside", about)


def quotients() -> Iterator[Case]:
    """V as a quotient of forms, or over a polynomial that is positive at the point."""
    over = "(x**4 + y**4)/(x**2 + y**2)"
    slopes = "x**4 + 2*x**2*y**2 - y**4", "-x**4 + 2*x**2*y**2 + y**4"
    square = "(x**2 + y**2)"
    rhs = [f"-2*y*({slopes[1]}) - 2*x*{square}*({slopes[0]})", f"2*x*({slopes[0]}) - 2*y*{square}*({slopes[1]})"]
    top, bottom = (part.strip("()") for part in over.split("/"))
    for within in ("1/2", None):
        own = lyapunov(top, cells(within=within), everywhere=True, denominator=bottom)
        yield Case(f"quotient-{'space' if within is None else 'cube'}", subject(rhs), "lyapunov", own)
    near = lyapunov("x**2 + y**2", cells("x"), level="1/4", denominator="1 + x**2")
    yield Case("quotient-relay", subject(["-sign(x) - x", "-y"]), "lyapunov", near)


def choices() -> Iterator[Case]:
    """One of several right-hand sides, their mean, or one on each side of a surface."""

    def case(name: str, sides: Any, choice: Any, theorem: str, hypotheses: Record) -> Case:
        own = {"choice": choice, "theorem": theorem, "hypotheses": hypotheses}
        return Case(f"choice-{name}", subject(sides), "choice", own)

    pushed = [["y", f"-2*sign(x) - sign(y) {sign} 4"] for sign in "+-"]
    for k, sign in enumerate(("1", "-1")):
        yield case(f"push-{k}", pushed, k, "departure", {"cells": cells("x", "y"), "direction": ["0", sign]})
    skew = [["-x + 4*y", "-y"], ["-x", "4*x - y"]]
    mean = {"surface": ["0"], "first": 0, "second": 1}
    yield case("mean", skew, mean, "instability", instability("-x*y", cells(), ["1", "1"]))
    outward = {"surface": "x", "first": 0, "second": 1}
    sides = [["1 - x"], ["-1 - x"]]
    yield case("sides", sides, outward, "instability", instability("-Abs(x)", cells("x", within="1/2"), ["1"]))


def centres() -> Iterator[Case]:
    """Centres by a reflection and by an integral: smooth, degenerate, with a relay, a wave; in both senses."""

    def case(name: str, theorem: str, rhs: Any, *surfaces: str, at: Any = None, **own: Any) -> Case:
        signs = [""]
        for _ in surfaces:
            signs = [f"{old}{sign}" for old in signs for sign in "-+"]
        weights = dict.fromkeys(signs, own["weights"])
        stated = {"cells": cells(*surfaces, within="1/4"), **own, "weights": weights}
        return Case(name, subject(rhs, at), theorem, stated)

    across, along, swapped = [["1", "0"], ["0", "-1"]], [["-1", "0"], ["0", "1"]], [["0", "1"], ["1", "0"]]
    same, steep, back = ["1", "1"], ["1", "2"], -1

    def mirrored(name: str, rhs: Any, mirror: Any, *surfaces: str, weights: Any = same, sense: int = back) -> Case:
        return case(f"reversible-{name}", "reversible", rhs, *surfaces, mirror=mirror, weights=weights, sense=sense)

    yield mirrored("spring", ["y", "-x + x**2"], across)
    yield mirrored("other-sense", ["-y + x**2", "x + x*y"], along, sense=1)
    yield mirrored("diagonal", ["y + x*y", "-x - x*y"], swapped)
    yield mirrored("relay", ["y - x**2/2", "-sign(x) + x*y**2/2"], along, "x", weights=["2", "1"])
    yield mirrored("pendulum", ["y", "-sin(x) - x"], across)
    yield mirrored("degenerate", ["y", "-x**3 + 2*x*y"], along, weights=steep)

    def kept(name: str, rhs: Any, factors: Any, *surfaces: str, exponent: str = "0", **own: Any) -> Case:
        stated = {"exponent": exponent, "factors": factors, "weights": same, "sense": back, **own}
        return case(f"integral-{name}", "integral", rhs, *surfaces, **stated)

    prey = [["x + 1", "-1"], ["y/2 + 1", "-1"]]
    yield kept("prey", ["x*(2 - y)", "3*y*(x - 1)"], prey, at=["1", "2"], sense=1)
    yield kept("spring", ["y + x*y", "-x - y**2/2 + x**2"], [])
    yield kept("exponential", ["y", "-x**3 - y**2/2"], [], exponent="x", weights=steep)
    yield kept("energy", ["y + y**2", "-relu(x) + 3*relu(-x) - x**2"], [], "x")
    lines = [["1 + x", "-1/2"], ["1 + y", "-2/3"], ["1 - 3*x/4 - y/2", "-1/3"]]
    yield kept("powers", ["6*(x + 1)*(x + 2*y)", "-3*(7*x + 2*y)*(y + 1)"], lines)


def entry_about(states: str, rhs: Sequence[str], theorem: str, hypotheses: Record, **more: Any) -> Record:
    """A theorem about some states, with evidence that is searched now."""
    own = {"states": states.split(), "rhs": [list(rhs)], "at": ["0"] * len(rhs), **more}
    return Search(WORK).entry(read_subject(own), theorem, hypotheses)[0]


def cascades() -> Iterator[Case]:
    """States that drive others: degenerate ones, one pair that turns, and one that leaves."""

    def case(name: str, rhs: Any, *parts: tuple[str, Record], **last: Any) -> Case:
        listed = [{"states": names.split(), "entry": entry} for names, entry in parts]
        listed[-1] |= last
        return Case(f"cascade-{name}", subject(rhs), "cascade", {"parts": listed})

    def falls(states: str, *rhs: str, verdict: str = ATTRACTS) -> tuple[str, Record]:
        function = " + ".join(f"{name}**2" for name in states.split())
        return states, entry_about(states, rhs, "lyapunov", lyapunov(function, cells(), verdict))

    yield case("cubic", ["-x**3", "-y**3 + x"], falls("x", "-x**3"), falls("y", "-y**3"))
    weak = falls("x y", "y", "-x", verdict=STAYS)
    yield case("turning", ["y", "-x", "-z + x*y"], weak, falls("z", "-z"))
    leaves = "x", entry_about("x", ["x"], "instability", instability("-x**2", cells(), ["1"]))
    yield case("leaves", ["x", "-y + x"], leaves)
    driven = "y", entry_about("y", ["y"], "instability", instability("-y**2", cells(), ["1"]))
    yield case("driven-leaves", ["-x", "y + x"], falls("x", "-x"), driven, leaves=True)
    relay = "y", entry_about("y", ["-sign(y)"], "lyapunov", lyapunov("y**2", cells("y")))
    yield case("jumping", ["-x**3", "-sign(y + x)"], falls("x", "-x**3"), relay, jumps=True)
    crossing = {"surfaces": ["y", "z"], "within": "1", "empty": []}
    coupled = entry_about(
        "y z", ["-2*sign(y) + sign(z)", "-sign(z)"], "lyapunov", lyapunov("Abs(y) + 2*Abs(z)", crossing)
    )
    jumping = ["-x", "-2*sign(y - x) + sign(z + 3*x + x*y)", "-sign(z + 3*x + x*y)"]
    yield case("jumping-twice", jumping, falls("x", "-x"), ("y z", coupled), jumps=True)
    both = [["-x", "-y + x"], ["-x", "-y - x"]]
    yield case("switching", both, falls("x", "-x"), falls("y", "-y"))
    for kind, rhs, function in (("exponential", "-x", "x**2"), ("finite", "-sign(x)", "Abs(x)")):
        hypotheses = lyapunov(function, cells("x"), ATTRACTS, rate={"kind": kind, "kappa": "1"})
        fast = {"states": ["x"], "entry": entry_about("x", [rhs], "lyapunov", hypotheses)}
        _, rests = falls("y z", "z", "-y", verdict=STAYS)
        listed = [fast, {"states": ["y", "z"], "entry": rests, "carried": True}]
        sides = subject([rhs, "z + x", "-y + x*y"])
        yield Case(f"cascade-carried-{kind}", sides, "cascade", {"parts": listed})
    root, about = "-sign(x)*sqrt(Abs(x))", {"roots": ["x"]}
    first = entry_about("x", [root], "lyapunov", lyapunov("root_x**2", cells("root_x", within="1/2")), **about)
    _, second = falls("y", "-y**3")
    listed = [{"states": ["x"], "entry": first, **about}, {"states": ["y"], "entry": second, "roots": []}]
    yield Case("cascade-roots", subject([root, "-y**3 + Abs(x)**(1/2)"]) | about, "cascade", {"parts": listed})


def slides() -> Iterator[Case]:
    """Surfaces on which solutions slide: to the point, away, off the origin, curved, and one after the other."""

    def case(name: str, rhs: Any, surface: str, state: str, entry: Record, at: Any = None) -> Case:
        own = {"cells": cells(surface), "surface": 0, "state": state, "entry": entry}
        return Case(f"sliding-{name}", subject(rhs, at), "sliding", own)

    home = entry_about("x", ["-x"], "lyapunov", lyapunov("x**2", cells()))
    away = entry_about("x", ["x"], "instability", instability("-x**2", cells(), ["1"]))
    yield case("home", ["y", "-sign(x + y)"], "x + y", "y", home)
    yield case("away", ["y", "-sign(y - x)"], "y - x", "y", away)
    yield case("elsewhere", ["y - 2", "1 - 3*sign(2*x + 2*y - 6)"], "x + y", "y", home, ["1", "2"])
    cubic = entry_about("x", ["-x**3"], "lyapunov", lyapunov("x**2", cells()))
    yield case("curved", ["y", "x**2 - sign(x**3 + y)"], "x**3 + y", "y", cubic)
    again = entry_about("y", ["-y**3"], "lyapunov", lyapunov("y**2", cells()))
    still = entry_about("z", ["-z"], "lyapunov", lyapunov("z**2", cells()))
    parts = {"parts": [{"states": ["y"], "entry": again}, {"states": ["z"], "entry": still}]}
    driven = {"theorem": "cascade", "hypotheses": parts, "proofs": {}}
    yield case("cascade", ["-sign(x) + z", "-y**3 + x", "y - z + x"], "x", "x", driven)


GROUPS = (
    in_one_state,
    slow_rates,
    slow_growth,
    linear_systems,
    relays,
    nonlinear_systems,
    switched_systems,
    by_a_second_function,
    unstable_systems,
    points_without_rest,
    solutions_that_leave,
    systems_with_roots,
    homogeneous_systems,
    gains,
    basins,
    energies_on_circles,
    polygons,
    quotients,
    choices,
    centres,
    cascades,
    slides,
    basins_in_space,
    sines_beside_roots,
    functions_of_roots,
    jumps_with_what_is_continuous,
    sets_of_equilibria,
)


def cases() -> Iterator[Case]:
    """All of them; a new theorem adds a group."""
    for group in GROUPS:
        yield from group()
