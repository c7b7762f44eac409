"""Systems of the literature in two to six states, with what their authors say of them.

"(m)" stands behind a source that was not looked up.  The truth of each is by a short argument beside it, or by the
linearization: it does not rest on the source.
"""

from __future__ import annotations

from collections.abc import Iterator

from tests.proofs.system_families import ATTRACTS, Known

NAMES = ("x", "y", "z", "u", "v", "w")
EVERYWHERE = True


def literature() -> Iterator[Known]:
    """All of them."""
    yield from with_regions()
    yield from that_attract_everywhere()
    yield from with_powers()
    yield from in_more_states()


def with_regions() -> Iterator[Known]:
    """In two states, from a region that is known."""
    wide = {"radius": "1"}
    for mu, published in (("1/3", ""), ("1", "; LyZNet: 0.948 of it"), ("3", "; LyZNet: 0.852 of it")):
        source = f"inside the limit cycle (Khalil 2002){published}"
        yield Known(f"van der Pol, reversed, mu {mu}", ("-y", f"x - {mu}*(1 - x**2)*y"), ATTRACTS, source, wide)
    machines = ("y", "-y/2 - (sin(x + pi/3) - sin(pi/3))")
    yield Known("two machines", machines, ATTRACTS, "Vannelli and Vidyasagar 1985; LyZNet: 0.823")
    yield Known("x y below one", ("-x + 2*x**2*y", "-y"), ATTRACTS, "exactly x y < 1: Hahn 1967", wide)
    yield Known("two products", ("-2*x + x*y", "-y + x*y"), ATTRACTS, "Davison and Kurak 1971 (m)", wide)
    soft = ("y", "-x - y + x**3/3")
    yield Known("softening cubic spring", soft, ATTRACTS, "saddles at abs(x) = sqrt(3): Khalil 2002", wide)
    yield Known("softening spring 2", ("y", "-2*x + x**3/3 - y"), ATTRACTS, "LyZNet's polynomial example (m)", wide)
    yield Known("softening spring 3", ("y", "-(1 - x**2)*x - y"), ATTRACTS, "Tan and Packard 2008 (m)", wide)
    disc = ("x*(x**2 + y**2 - 2) - 4*x*y**2", "4*x**2*y + y*(x**2 + y**2 - 2)")
    yield Known("inside a disc of squared radius 2", disc, ATTRACTS, "exactly: Slotine and Li 1991", wide)
    circle = ("-y - x*(1 - x**2 - y**2)", "x - y*(1 - x**2 - y**2)")
    yield Known("inside the unit circle", circle, ATTRACTS, "exactly: Hafstein 2005, Giesl 2007 (m)")
    family = "exactly x' B x < 1: Tan 2006 (m)"
    for name, square in (("ellipse", "2*x**2 + y**2"), ("narrow ellipse", "5*x**2 + 4*x*y + y**2")):
        rhs = (f"-x + ({square})*x", f"-y + ({square})*y")
        yield Known(f"inside a {name}", rhs, ATTRACTS, family, wide)
    wells = {"equilibrium": [1, 0], "radius": "1/2"}
    yield Known("Duffing, one well", ("y", "x - x**3 - y/2"), ATTRACTS, "Guckenheimer and Holmes 1983", wells)
    competition = ("x*(1 - x - y/2)", "y*(1 - y - x/2)")
    both = {"equilibrium": ["2/3", "2/3"], "radius": "1/2"}
    yield Known("competition of two species", competition, ATTRACTS, "x, y > 0, exactly: Goh 1977", both)
    prey = ("x*(1 - x - y)", "y*(x - 1/2)")
    half = {"equilibrium": ["1/2", "1/2"], "radius": "1/4"}
    yield Known("predator and prey", prey, ATTRACTS, "x, y > 0, exactly: Goh 1977", half)
    yield Known("pendulum", ("y", "-sin(x) - y"), ATTRACTS, "saddles at abs(x) = pi: Khalil 2002")
    yield Known("sliding beside a cubic", ("-x + x**3", "-sign(y) + y*x**2/4 + y**3/4 - x/4"), ATTRACTS, "abs(x) < 1")
    wide_relay = ("y", "x**3 - 2*sign(x + y)")
    yield Known("relay against a cubic", wide_relay, ATTRACTS, "equivalent control: Utkin 1992")


def that_attract_everywhere() -> Iterator[Known]:
    """In two states, from everywhere."""

    def known(name: str, rhs: tuple[str, str], source: str) -> Known:
        return Known(name, rhs, ATTRACTS, source, everywhere=EVERYWHERE)

    yield known("no polynomial V in the plane", ("-x + x*y", "-y"), "Ahmadi, Krstic and Parrilo 2011 (also in Lean)")
    yield known("FOSSIL, Poly2", ("-x**3 + y", "-x - y"), "x^2 + y^2")
    yield known("FOSSIL, Poly3", ("-x**3 - y**2", "x*y - y**3"), "x^2 + y^2")
    yield known("FOSSIL, Poly4", ("-x - 3*x**2*y**3/2", "-y**3 + x**3*y**2/2"), "x^2 + 3 y^2")
    yield known("hard spring", ("y", "-x**3 - y"), "energy: Barbashin and Krasovskii 1952")
    yield known("jet engine", ("-y - 3*x**2/2 - x**3/2", "3*x - y"), "Moore and Greitzer; V of degree 4: SOSTOOLS (m)")
    form = "(x**4 + 2*x**2*y**2 - y**4)"
    other = "(-x**4 + 2*x**2*y**2 + y**4)"
    rational = f"-2*y*{other} - 2*x*(x**2 + y**2)*{form}", f"2*x*{form} - 2*y*(x**2 + y**2)*{other}"
    yield known("no polynomial V at all", rational, "(x^4 + y^4)/(x^2 + y^2): Ahmadi and El Khadir 2018")
    yield known("cascade", ("-x + y**2", "-y"), "input-to-state stable: Sontag 1989")
    yield known("focus", ("y", "-x - y"), "linear")


def with_powers() -> Iterator[Known]:
    """In two states, with rational powers of these, from everywhere."""

    def known(name: str, rhs: tuple[str, str], source: str) -> Known:
        return Known(f"powers: {name}", rhs, ATTRACTS, source, everywhere=EVERYWHERE)

    root, third = "sqrt(Abs(x))*sign(x)", "Abs(x)**(1/3)*sign(x)"
    damping = "sqrt(Abs(y))*sign(y)"
    yield known("super-twisting", (f"-3/2*{root} + y", "-11/10*sign(x)"), "Levant 1993")
    linear = (f"-3/2*{root} + y - x", "-11/10*sign(x) - x")
    yield known("super-twisting, linear terms", linear, "Moreno 2009")
    general = (f"y - {root} - Abs(x)**(3/2)*sign(x)", "-sign(x)/2 - 2*x - 3*x*Abs(x)/2")
    yield known("super-twisting, generalized", general, "Moreno 2009 (m)")
    yield known("double integrator", ("y", f"-{third} - {damping}"), "Bhat and Bernstein 1998")
    fifth = ("y", "-Abs(x)**(1/5)*sign(x) - Abs(y)**(1/3)*sign(y)")
    yield known("double integrator, 1/5", fifth, "Bhat and Bernstein 1998")
    observer = ("y - 2*Abs(x)**(2/3)*sign(x)", f"-2*{third}")
    yield known("observer", observer, "energy: Perruquetti, Floquet and Moulay 2008 (m)")
    yield known("a law of convergence", ("y", f"-2*sign(y + {root})"), "Levant 1993")
    fixed = ("y", f"-{third} - x**3 - {damping} - y**3")
    yield known("in a time without bound by the start", fixed, "energy; Polyakov 2012 (m)")


def in_more_states() -> Iterator[Known]:
    """In three states and more."""

    def known(name: str, rhs: tuple[str, ...], source: str, *, everywhere: bool = False) -> Known:
        return Known(name, rhs, ATTRACTS, source, states=NAMES[: len(rhs)], everywhere=everywhere)

    gains = ("-2*Abs(x)**(2/3)*sign(x) + y", "-53/25*Abs(x)**(1/3)*sign(x) + z", "-11/10*sign(x)")
    yield known("differentiator of second order", gains, "Levant 2003", everywhere=EVERYWHERE)
    guide = ("-x**3 - x*z**2", "-y - x**2*y", "-z - 3*z/(z**2 + 1) + 3*x**2*z")
    yield known("SOSTOOLS guide, section 4.2", guide, "5.55 x^2 + 4.11 y^2 + 1.79 z^2", everywhere=EVERYWHERE)
    second = ("-x", "-2*y + x*y**2/10 + z", "-z - 3*y/2")
    yield known("FOSSIL, NonPoly2", second, "V in a ball (m)")
    third = ("-3*x - x*y**3/10", "-y + z", "-z")
    yield known("FOSSIL, NonPoly3", third, "V in a ball (m)")
    yield known("Tibken", ("-x + y*z**2", "-y + x*y", "-z"), "Tibken 2000 (m)")
    lorenz = ("10*(y - x)", "x/2 - y - x*z", "x*y - 8*z/3")
    yield known("Lorenz, rho 1/2", lorenz, "x^2/10 + y^2 + z^2: Sparrow 1982", everywhere=EVERYWHERE)
    body = ("y*z - x", "-2*x*z - y", "x*y - z")
    yield known("spinning body with friction", body, "x^2 + y^2 + z^2", everywhere=EVERYWHERE)
    yield known("three integrators, linear", ("y", "z", "-x - 2*y - 2*z"), "Hurwitz", everywhere=EVERYWHERE)
    yield known("van der Pol in three states", ("-y", "-z", "-x/2 + (1 - x**2/2)*y - z"), "Hurwitz near the point")
    yield known("pendulum with an actuator", ("y", "-sin(x) - y/2 + z", "-z + x*z"), "Hurwitz near the point")
    for count in (3, 4, 6):
        names = NAMES[:count]
        square = " + ".join([f"{k}*{a}**2" for k, a in enumerate(names, 1)] + [f"{a}*{b}" for a, b in [names[:2]]])
        rhs = tuple(f"-{a} + ({square})*{a}" for a in names)
        yield known(f"x' B x in {count} states", rhs, "exactly x' B x < 1: Tan 2006 (m)")
