"""Stability by energies with sines and cosines: the system on circles (:mod:`nonsmooth.proofs.checker.circles`).

In the coordinates ``sin x`` and ``cos x - 1`` of its angles a system with sines is one with polynomials, in more
states.  Energies are searched there as in any such system (:mod:`.weak_functions`); the checker shows what is found.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from nonsmooth.proofs.checker.roots import read_subject
from nonsmooth.proofs.kernel.cells import BeyondReachError, stated_cells, surfaces_of
from nonsmooth.proofs.kernel.search import NotShownError, Search
from nonsmooth.proofs.kernel.subject import NoCertificateError, about
from nonsmooth.proofs.many_states.weak_functions import find_weak_lyapunov
from nonsmooth.proofs.systems.domain import cube_text
from nonsmooth.symbolic.formulas.expression import ExpressionError
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression, parse_piecewise
from nonsmooth.symbolic.formulas.sine_enclosures import Wave, in_place_of_names
from nonsmooth.symbolic.messages.scene_error import SceneError, one_line
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem


def find_energy_on_circles(system: SwitchedSystem) -> tuple[dict[str, Any], str, str, bool] | None:
    """The entry of a certificate that shows stability, its V and its domain for people, and whether V is kept.

    None where none is found.

    Args:
        system: in any number of states, with sines or cosines of some.
    """
    angles = _angles(system)
    if not angles:
        return None
    try:
        seen = on_circles(system, angles)
        found = None if seen is None else find_weak_lyapunov(seen)
        if seen is None or found is None:
            return None
        cells = stated_cells(seen, found.radius, surfaces_of(seen, found.formula)).record
        hypotheses = {"angles": list(angles), "cells": cells, "function": found.formula.text}
        entry, _ = Search().entry(read_subject(about(system)), "circles", hypotheses)
    except (BeyondReachError, NoCertificateError, NotShownError, SceneError):
        return None
    function, domain = found.formula.text, cube_text(found.radius, seen.states)
    for name in angles:
        sine, cosine = f"sin({name})", f"cos({name}) - 1"
        function = function.replace(f"sin_{name}", sine).replace(f"cos_{name}", f"({cosine})")
        domain = domain.replace(f"sin_{name}", sine).replace(f"cos_{name}", cosine)
    return entry, function, domain, found.is_kept


def _angles(system: SwitchedSystem) -> tuple[str, ...]:
    """The states of which there are sines and cosines; none unless all of these are 0 at the point."""
    found = set()
    for wave in system.names:
        for exponents in system.argument_of(wave).terms:
            found |= {name for name, exponent in zip(system.states, exponents, strict=True) if exponent}
    at = dict(zip(system.states, system.check.equilibrium, strict=True))
    return () if any(at[name] for name in found) else tuple(name for name in system.states if name in found)


def on_circles(system: SwitchedSystem, angles: Sequence[str]) -> SwitchedSystem | None:
    """The system in the coordinates; None where an angle stands outside sines and cosines, or not in whole multiples.

    Raises:
        SceneError: for formulas that cannot be used.
    """
    pairs = [(f"sin_{name}", f"cos_{name}") if name in angles else (name,) for name in system.states]
    coordinates = tuple(own for pair in pairs for own in pair)
    if len(set(coordinates)) < len(coordinates):
        return None
    values = {name: Polynomial.variable(system.field, coordinates, name) for name in coordinates}
    try:
        known = {wave.name: _turned(wave, system, angles, values) for wave in system.names}
        stated = [
            _text(side, known, [name for name in system.states if name not in angles]) for side in system.named_rhs
        ]
    except ExpressionError:
        return None
    rhs = []
    for name, text in zip(system.states, stated, strict=True):
        rhs += [f"(1 + cos_{name})*({text})", f"-sin_{name}*({text})"] if name in angles else [text]
    at = dict(zip(system.states, system.check.equilibrium, strict=True))
    squares = parse_piecewise(" + ".join(f"{name}**2" for name in coordinates), coordinates)
    zero = system.field.zero
    check = replace(
        system.check, equilibrium=tuple(at.get(name, zero) for name in coordinates), lyapunov=squares, is_default=True
    )
    sides = tuple(parse_piecewise(text, coordinates) for text in rhs)
    plain: dict[str, Any] = {"others": (), "written": (), "waves": (), "named_rhs": (), "names": ()}
    return replace(system, states=coordinates, rhs=sides, check=check, **plain)


def _turned(wave: Wave, system: SwitchedSystem, angles: Sequence[str], values: Mapping[str, Polynomial]) -> Polynomial:
    """A sine or cosine of a sum of whole multiples of angles.

    Raises:
        ExpressionError: for another one.
    """
    one = next(iter(values.values())) * 0 + 1
    sine, cosine = one * 0, one
    for exponents, value in system.argument_of(wave).terms.items():
        turns = value.as_rational()
        if sum(exponents) != 1 or turns is None or turns.q != 1:
            raise ExpressionError("required sums of whole multiples of angles")
        name = system.states[exponents.index(1)]
        own, across = values[f"sin_{name}"], values[f"cos_{name}"] + 1
        own = own if turns > 0 else -own
        for _ in range(abs(int(turns.p))):
            sine, cosine = sine * across + cosine * own, cosine * across - sine * own
    return sine if wave.kind == "sin" else cosine


def _text(side: PiecewiseExpression, waves: Mapping[str, Polynomial], others: Sequence[str]) -> str:
    """A formula with polynomials in place of its sines and cosines.

    Raises:
        ExpressionError: where it names another state than these.
    """
    text = one_line(side.text)
    left = parse_piecewise(in_place_of_names(text, dict.fromkeys(waves, "0")), side.states)
    states = {name for name in side.states if name not in waves}
    used = set(re.findall(r"[A-Za-z_][A-Za-z0-9_]*", left.text)) & states
    if not used <= set(others):
        raise ExpressionError("required angles under sines and cosines alone")
    return in_place_of_names(text, {name: f"({value})" for name, value in waves.items()})
