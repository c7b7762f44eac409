"""Planar switched systems whose stability is known, from the literature or by a short argument, in families.

The truth is the strong stability of the checked point: asymptotically stable, stable but not asymptotically, unstable.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

ATTRACTS, STAYS, LEAVES = "asymptotically stable", "stable", "unstable"


@dataclass(frozen=True)
class Known:
    """A system with its truth.

    Attributes:
        name: of the family and the member.
        rhs: a formula for each state.
        truth: what is known of the checked point.
        source: where from.
        check: further keys of ``[check]``.
        states: their names.
        everywhere: whether every start is known to come to the point.
    """

    name: str
    rhs: tuple[str, ...]
    truth: str
    source: str
    check: Mapping[str, object] = field(default_factory=dict)
    states: tuple[str, ...] = ("x", "y")
    everywhere: bool = False


def saturated(formula: str, level: str = "1") -> str:
    return f"sat({formula}, -{level}, {level})"


def families() -> Iterator[Known]:
    """All of them."""
    yield from relays()
    yield from sliding_control()
    yield from second_order_sliding()
    yield from friction_and_saturation()
    yield from converters_and_genes()
    yield from bang_bang()
    yield from relu_loops()
    yield from conewise_linear()
    yield from smooth_with_higher_terms()
    yield from pendulums()
    yield from fractions()


def relays() -> Iterator[Known]:
    source = "energy y^2/2 + abs(x), LaSalle"
    for damping in ("1/4", "1", "3"):
        yield Known(f"relay, viscous {damping}", ("y", f"-sign(x) - {damping}*y"), ATTRACTS, source)
        yield Known(f"relay, anti-damped {damping}", ("y", f"-sign(x) + {damping}*y"), LEAVES, source)
    yield Known("relay and spring", ("y", "-x - sign(x) - y"), ATTRACTS, source)
    yield Known(
        "crossed relays, contracting", ("-sign(x) + 2*sign(y)", "-2*sign(x) - sign(y)"), ATTRACTS, "Filippov 16"
    )
    yield Known("crossed relays, expanding", ("sign(x) - 2*sign(y)", "2*sign(x) + sign(y)"), LEAVES, "Filippov 16")
    yield Known("two relays on skew lines", ("-sign(x + y) - x", "-sign(x - 2*y)*(-1) - 3*sign(y)"), ATTRACTS, "fan")
    yield Known("relays with a weak repeller", ("-sign(x) + x + y/2", "-sign(y) + y"), ATTRACTS, "abs(x) + abs(y)")


def sliding_control() -> Iterator[Known]:
    source = "equivalent control: Utkin 1992"
    yield Known("sliding on x + y", ("y", "-2*sign(x + y) + x/2"), ATTRACTS, source)
    yield Known("sliding on y - x", ("y", "-2*sign(y - x)"), LEAVES, source)
    yield Known("sliding on 2 x + y", ("y", "-3*sign(2*x + y) - x + y"), ATTRACTS, source)
    yield Known("sliding with cubic spring", ("y", "x**3 - 2*sign(x + y)"), ATTRACTS, source)
    yield Known("wrong sign of the relay", ("y", "2*sign(x + y)"), LEAVES, source)
    yield Known("unit control of an unstable plant", ("x/2 - sign(x)", "y/3 - sign(y)"), ATTRACTS, source)


def second_order_sliding() -> Iterator[Known]:
    source = "twisting: Levant 1993"
    for a, b in ((2, 1), (3, 2), (5, 1)):
        yield Known(f"twisting {a}, {b}", ("y", f"-{a}*sign(x) - {b}*sign(y)"), ATTRACTS, source)
        yield Known(f"anti-twisting {a}, {b}", ("y", f"-{a}*sign(x) + {b}*sign(y)"), LEAVES, source)
    yield Known("twisting with drift", ("y", "-3*sign(x) - sign(y) + x - y/2"), ATTRACTS, source)
    yield Known("twisting on skew lines", ("y - x", "-3*sign(x) - sign(y)"), ATTRACTS, source)


def friction_and_saturation() -> Iterator[Known]:
    yield Known("Coulomb friction", ("y", "-x - sign(y)"), STAYS, "an interval of rest")
    yield Known("Coulomb and viscous friction", ("y", "-x - y - sign(y)"), STAYS, "an interval of rest")
    yield Known("Coulomb friction, anti-viscous", ("y", "-x + y/2 - sign(y)"), STAYS, "an interval of rest")
    zone = "(Max(x - 1/4, 0) + Min(x + 1/4, 0))"
    yield Known("spring with dead zone added", ("y", f"-x - y - {zone}"), ATTRACTS, "linear near the point")
    yield Known("damping at one side only", ("y", "-x - Max(y, 0)"), ATTRACTS, "energy, LaSalle")
    yield Known("saturated double integrator", ("y", f"-{saturated('x + y')}"), ATTRACTS, "linear near the point")
    yield Known("saturation of low level", ("y", f"-{saturated('x + y', '1/10')}"), ATTRACTS, "linear near the point")
    yield Known("saturated, positive feedback", ("y", saturated("x + y")), LEAVES, "linear near the point")
    yield Known("cubic friction", ("y", "-x - y**3"), ATTRACTS, "energy, LaSalle")
    yield Known("relay and cubic friction", ("y", "-sign(x) - y**3"), ATTRACTS, "energy, LaSalle")
    yield Known("relay and drag", ("y", "-sign(x) - y*Abs(y)"), ATTRACTS, "energy, LaSalle")
    yield Known("hard spring and cubic friction", ("y", "-x**3 - y**3"), ATTRACTS, "energy, LaSalle")
    yield Known("cubic friction at one side", ("y", "-x - Max(y, 0)**3"), ATTRACTS, "energy, LaSalle")
    yield Known("friction beyond a dead zone", ("y", "-x - Max(y - 1/8, 0)"), STAYS, "closed orbits within")
    yield Known("weak Coulomb friction", ("y", "-x/2 - sign(y)/100"), STAYS, "an interval of rest")
    yield Known("anti-windup", (f"-x + {saturated('y')}", "-x"), ATTRACTS, "linear near the point")


def converters_and_genes() -> Iterator[Known]:
    at = {"equilibrium": [1, 1], "radius": "1/2"}
    source = "equivalent control: Sira-Ramirez and Silva-Ortigoza 2006"
    buck = ("-y + 1 - sign(x + y - 2)", "x - y")
    yield Known("buck converter", buck, ATTRACTS, source, at)
    yield Known("buck converter, reversed", (buck[0].replace("- sign", "+ sign"), buck[1]), LEAVES, source, at)
    boost = {"equilibrium": [4, 2], "radius": "1/2"}
    current = ("1 - y*(1 + sign(x - 4))/2", "x*(1 + sign(x - 4))/2 - y")
    voltage = ("1 - y*(1 - sign(y - 2))/2", "x*(1 - sign(y - 2))/2 - y")
    yield Known("boost converter, current control", current, ATTRACTS, source, boost)
    yield Known("boost converter, voltage control", voltage, LEAVES, source, boost)
    genes = "step functions: Gouze and Sari 2002"
    toggle = ("-x + 1 - sign(y - 1)", "-y + 1 - sign(x - 1)")
    loop = ("-x + 1 - sign(y - 1)", "-y + 1 + sign(x - 1)")
    yield Known("toggle switch", toggle, LEAVES, genes, at)
    yield Known("negative loop of two genes", loop, ATTRACTS, genes, at)
    autoregulation = ("-x + 1 - sign(x - 1)", "-y + 1 - sign(y - 1)")
    yield Known("two genes that repress themselves", autoregulation, ATTRACTS, genes, at)


def bang_bang() -> Iterator[Known]:
    source = "double integrator: Pontryagin et al. 1962"
    for factor in ("1/4", "1/2", "1"):
        law = f"-sign(x + {factor}*y*Abs(y))"
        yield Known(f"bang-bang, curved line {factor}", ("y", law), ATTRACTS, source)
    yield Known("bang-bang, turned curve", ("y", "-sign(x - y*Abs(y)/4)"), LEAVES, source)


def relu_loops() -> Iterator[Known]:
    relu = "eigenvectors and turns of the cones"
    yield Known("two units, negative loop", ("-x + relu(y)", "-y - relu(x)"), ATTRACTS, relu)
    yield Known("two units, strong positive loop", ("-x + 2*Max(y, 0)", "-y + 2*Max(x, 0)"), LEAVES, relu)
    yield Known("two units, weak positive loop", ("-x + Max(y, 0)/2", "-y + Max(x, 0)/2"), ATTRACTS, relu)
    four = ("-x + Max(x + y, 0)/2 - Max(y - x, 0)/2", "-y - Max(x + y, 0)/2 + Max(x - 2*y, 0)/4")
    yield Known("four units", four, ATTRACTS, "Abs-bounded gain, simulated")
    bias = ("-x + Max(y + 1, 0)/2 - 1/2", "-y - Max(x + 1, 0) + 1")
    yield Known("two units with bias", bias, ATTRACTS, "linear near the point")
    yield Known("leaky unit", ("y", "-x - y/10 - Max(x, 0)"), ATTRACTS, "energy, LaSalle")


def conewise_linear() -> Iterator[Known]:
    flower = ("-x/10 + 3*y - 2*y*sign(x**2 - y**2)", "-y/10 - 3*x - 2*x*sign(x**2 - y**2)")
    yield Known("flower", flower, ATTRACTS, "Johansson and Rantzer 1998")
    grows = ("-x/8 - y*(3 - sign(x*y))/2", "x*(3 + sign(x*y))/2 - y/8")
    falls = ("-x/8 - y*(3 + sign(x*y))/2", "x*(3 - sign(x*y))/2 - y/8")
    branicky = "half turns of ellipses: Branicky 1998"
    yield Known("two stable foci that grow", grows, LEAVES, branicky)
    yield Known("two stable foci that fall", falls, ATTRACTS, branicky)
    pieces = "half turns of a focus"
    yield Known("foci of unequal damping", ("y", "-x - y/2*(1 + 3*sign(x))"), ATTRACTS, pieces)
    yield Known("foci, one side anti-damped", ("y", "-x - y/2*(1 - 3*sign(x))"), ATTRACTS, pieces)
    yield Known("foci, mean anti-damped", ("y", "-x + y/4*(1 + 3*sign(x))"), LEAVES, pieces)
    yield Known("outward ray between stable foci", ("x/2 - y*sign(y)", "-y"), LEAVES, "the x axis")
    yield Known("node and focus", ("-x - y*(1 + sign(y))", "-y + x*(1 + sign(y))"), ATTRACTS, "abs(c)^2")


def smooth_with_higher_terms() -> Iterator[Known]:
    source = "linearization"
    yield Known("saddle", ("x + y**2", "-y"), LEAVES, source)
    yield Known("focus with quadratic terms", ("-x + y + y**2", "-x - y + x*y"), ATTRACTS, source)
    yield Known("node with a relay far away", ("-x + y**2", "-y*(2 + sign(x - 1))"), ATTRACTS, source)
    yield Known("parabola far away", ("y", "-x - y*sign(y + x**2 + 1)"), ATTRACTS, source)
    yield Known("guard that is negative near 0", ("-sign(x**3 - x**2 - y**2)", "-y"), LEAVES, "no equilibrium")
    lyapunov = "abs(c)^2"
    yield Known("weak focus, cubic damping", ("y - x**3", "-x - y**3"), ATTRACTS, lyapunov)
    yield Known("weak focus, cubic growth", ("y + x**3", "-x + y**3"), LEAVES, lyapunov)
    yield Known("van der Pol, reversed", ("-y", "x - y + x**2*y"), ATTRACTS, source)
    yield Known("van der Pol", ("y", "-x + y - x**2*y"), LEAVES, source)
    yield Known("pendulum, upper position", ("y", "x - x**3/6 - y"), LEAVES, source)


def pendulums() -> Iterator[Known]:
    """With sines of states; pi is added where the pendulum stands."""
    source = "linearization"
    yield Known("pendulum that hangs, viscous", ("y", "-sin(x) - y/2"), ATTRACTS, source)
    yield Known("pendulum that stands", ("y", "-sin(x + pi) - y/2"), LEAVES, source)
    yield Known("pendulum, anti-damped", ("y", "-sin(x) + y/4"), LEAVES, source)
    yield Known("standing pendulum, linear control", ("y", "-sin(x + pi) - 3*x - y"), ATTRACTS, source)
    yield Known("standing pendulum, too weak control", ("y", "-sin(x + pi) - x/2 - y"), LEAVES, source)
    yield Known("standing pendulum, sliding control", ("y", "-sin(x + pi) - 2*sign(x + y)"), ATTRACTS, "Utkin 1992")
    yield Known("pendulum, dry friction", ("y", "-sin(x) - sign(y)"), STAYS, "an interval of rest")
    yield Known("pendulum and relay", ("y", "-sin(x) - sign(x) - y"), ATTRACTS, "energy, LaSalle")
    yield Known("phase-locked loop", ("y", "-sin(x) - y*cos(x)"), ATTRACTS, source)
    yield Known("two coupled phases", ("-sin(x) + sin(y - x)/2", "-sin(y) + sin(x - y)/2"), ATTRACTS, source)
    yield Known("two repelling phases", ("sin(x)/4 + sin(y - x)", "-sin(y)/4 + sin(x - y)"), LEAVES, source)


def fractions() -> Iterator[Known]:
    """With states in denominators: Stribeck friction, and genes with Hill functions."""
    force = "(1 + 1/(1 + (y - 1)**2))"
    belt = {"equilibrium": ["3/2", 0], "radius": "1/2"}
    stribeck = "slope of the friction law: Armstrong, Dupont and Canudas de Wit 1994"
    yield Known("block on a belt, Stribeck friction", ("y", f"-x - sign(y - 1)*{force}"), LEAVES, stribeck, belt)
    yield Known("the same, viscous", ("y", f"-x - y - sign(y - 1)*{force}"), ATTRACTS, stribeck, belt)
    dry = "(1 + 1/(1 + 4*y**2))/2"
    yield Known("Stribeck friction at rest", ("y", f"-x - sign(y)*{dry}"), STAYS, "an interval of rest")
    at = {"equilibrium": [1, 1], "radius": "1/4"}
    genes = "linearization: Gardner, Cantor and Collins 2000"
    loop = ("1/(1 + y**2) - x/2", "x**2/(1 + x**2) - y/2")
    toggle = ("2/(1 + y**3) - x", "2/(1 + x**3) - y")
    yield Known("negative loop, Hill functions", loop, ATTRACTS, genes, at)
    yield Known("toggle switch, Hill functions", toggle, LEAVES, genes, at)
    soft = ("y", "-x/(1 + x**2) - y/(2 + x)")
    yield Known("softening spring", soft, ATTRACTS, "linearization")
    yield Known("softening spring and relay", ("y", "-x/(1 + x**2) - 2*sign(x + y)/(1 + y**2)"), ATTRACTS, "Utkin 1992")
    yield Known("pull of a magnet", ("y", "x/(1 - x**2) - y"), LEAVES, "linearization")
