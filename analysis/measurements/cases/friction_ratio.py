"""Minimizers of the dissipation at extreme ratios of frictions.

What is compared is the value, with the power of the forces that certify it, which no twist falls below: where friction
along or across the rims nearly vanishes, the twist is almost free in a direction, and no minimizer can know it better
than the square root of rounding.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from nonsmooth.analysis.cells.loads import LoadError
from nonsmooth.analysis.fields.contact_model import contact_model
from nonsmooth.analysis.measurements.harness import Case
from nonsmooth.analysis.measurements.rows import EPSILON, Rows, judged, refused
from nonsmooth.analysis.minimizers.box_minimizers import BoxHighs
from nonsmooth.analysis.minimizers.choice import Minimizer
from nonsmooth.analysis.minimizers.dissipation import dissipation
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseInterior
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.analysis.minimizers.minimum import GAP
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.similar_scenes import with_friction_ratio

TINY = Fraction(1, 10**12)
RATIOS: dict[str, Fraction] = {  # mu_S/mu_R
    "1e-12": TINY,
    "1e-6": Fraction(1, 10**6),
    "1 - 1e-12": 1 - TINY,
    "1": Fraction(1),
    "1 + 1e-12": 1 + TINY,
    "1e6": Fraction(10**6),
    "1e12": 1 / TINY,
}
MINIMIZERS: tuple[Minimizer, ...] = (BoxHighs(), EllipseInterior())
UNPROVEN = "its forces do not certify the minimum: they are so large that their rounding outweighs the gap"
PLACE = (0.3171, 0.2443)  # in half-widths of the square


def friction_rows(scene: Scene) -> Rows:
    """The least dissipation of both functionals at every ratio; a refusal where there are no loads."""
    (x, y), radius = scene.check.equilibrium, float(scene.check.radius)
    point = [[float(x) + PLACE[0] * radius, float(y) + PLACE[1] * radius]]
    for name, ratio in RATIOS.items():
        model = contact_model(with_friction_ratio(scene, ratio))
        try:
            loads = loads_at(model, point)
        except LoadError as refusal:
            yield refused("friction ratio", name, refusal, expected=True)
            return
        for minimizer in MINIMIZERS:
            found = minimizer.minimize(model, loads)
            rest = float(dissipation(minimizer.functional, model, loads[0], np.zeros(3)))
            case = f"friction ratio, {minimizer.functional} minimizer"
            if found.check()[0]:
                error, why = abs(float(found.gaps[0])) / (rest or 1.0), "the gap that certifies a minimum, of D at rest"
                yield judged(case, name, "certified by its forces", error, GAP, why=why)
            else:
                outweighed = float(max(ratio, 1 / ratio)) * EPSILON * rest > GAP * float(found.values[0])
                yield refused(case, name, UNPROVEN, expected=outweighed)


FRICTION = Case("minimizers", array=friction_rows)
