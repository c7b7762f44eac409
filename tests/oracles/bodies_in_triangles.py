"""Bodies that start in the triangles of a certificate, by small steps along the literal words of rule ``nearest``.

Nothing here knows of cells: at each place wheels are taken by their distance, rows of larger friction first, while they
are independent.  Where a claim says that bodies come to the point, or end in a disc, they must do so but for a step.
"""

from __future__ import annotations

import random
from fractions import Fraction
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from tests.array_certificates import said, subject
from tests.oracles.floats import Floats
from tests.oracles.rebuilt_arrays import Decoder

Record: TypeAlias = dict[str, Any]

STARTS, STEPS = 8, 1_500
STEP = 1 / 200  # of the mesh
LEAST = 1e-9  # of a determinant


class Wheel(NamedTuple):
    """In floats, seen from the checked point."""

    place: Floats
    rows: tuple[tuple[Floats, float], ...]  # each with its speed, of larger friction first


def wheels_of(certificate: Record) -> list[Wheel]:
    """The wheels, without rows that have no friction; of rows with equal friction that along the grip comes first."""
    decode, own = Decoder(certificate), subject(certificate)
    at = np.array([float(decode.number(data)) for data in own["at"]])
    found = []
    for wheel in own["wheels"]:
        place, rim, friction = (
            np.array([float(decode.number(data)) for data in wheel[key]])
            for key in ("position", "direction", "friction")
        )
        grip = rim
        if "axis" in wheel:
            grip = np.array([float(decode.number(data)) for data in wheel["axis"]])
        p, speed = place - at, float(decode.number(wheel["speed"]))
        rows = []
        for direction, mu in ((grip, friction[0]), (np.array([-grip[1], grip[0]]), friction[1])):
            turned = direction[1] * p[0] - direction[0] * p[1]
            rows.append((mu, (np.array([*direction, turned]), speed * float(direction @ rim))))
        rows.sort(key=lambda row: -row[0])
        found.append(Wheel(p, tuple(row for mu, row in rows if mu > 0)))
    return found


def velocity(wheels: list[Wheel], c: Floats) -> Floats:
    """Of a body at a place: ``v + omega J c`` of the twist that obeys three rows."""
    taken: list[tuple[Floats, float]] = []
    for wheel in sorted(wheels, key=lambda own: float(np.sum((own.place - c) ** 2))):
        for row in wheel.rows:
            normals = np.array([own for own, _ in (*taken, row)])
            if len(taken) < 3 and np.linalg.det(normals @ normals.T) > LEAST:
                taken.append(row)
    twist = np.linalg.solve(np.array([own for own, _ in taken]), np.array([value for _, value in taken]))
    return np.array([twist[0] - twist[2] * c[1], twist[1] + twist[2] * c[0]])


def assert_bodies_end(certificate: Record, source: random.Random) -> None:
    """Bodies from random triangles below the level come as near to the point as is claimed, but for some steps."""
    claims = said(certificate)
    claim = claims.get("attracts") or claims.get("ends")
    if claim is None or subject(certificate)["rule"] != "nearest":
        return
    mesh, wheels = claim["mesh"], wheels_of(certificate)
    corners = np.array([own.split(" ") for own in mesh["corners"]], dtype=float)
    corners[:, :2] *= float(Fraction(mesh["unit"]))
    triangles = np.array([own.split(" ") for own in mesh["triangles"]], dtype=int)
    size = float(np.abs(corners[:, :2]).max())
    radius = float(Fraction(claim["squared_radius"])) ** 0.5 if "squared_radius" in claim else 0.0
    for _ in range(STARTS):
        weights = np.random.default_rng(source.randrange(2**32)).dirichlet(np.ones(3))
        x, y, level = weights @ corners[source.choice(triangles.tolist())]
        if level >= claim["below"]:
            continue
        c, nearest = np.array([x, y]), np.inf
        for _ in range(STEPS):
            v = velocity(wheels, c)
            c = c + STEP * size * v / (np.linalg.norm(v) + 1e-300)
            nearest = min(nearest, float(np.linalg.norm(c)))
            if nearest < radius + 3 * STEP * size:
                break
        assert nearest < radius + 3 * STEP * size, f"a body from ({x:.4g}, {y:.4g}) comes no nearer than {nearest:.4g}"
