from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from typing import TypeAlias

import numpy as np
import pytest

from nonsmooth.analysis.cells.fan import Cone, build_fan, ray_speeds, slide_speed
from nonsmooth.proofs.clauses.translation.fan_stability import FanResult, Move, MoveEvidence, decide_cones
from nonsmooth.proofs.findings import Translation
from nonsmooth.symbolic.mechanics.contact_states import Twist
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_field import NumberField
from tests.conftest import Arrays
from tests.oracles.clause_evidence import evidence_holds
from tests.thorough import keep, thorough

Vector: TypeAlias = tuple[int | Fraction, int | Fraction]
FIELD = NumberField()


def fan_of(rays: list[Vector], motions: list[tuple[int | Fraction, ...]]) -> list[Cone]:
    """Cones between consecutive rays (counterclockwise) with one motion (vx, vy[, omega]) each."""
    exact = [(FIELD(x), FIELD(y)) for x, y in rays]
    cones = []
    for k, motion in enumerate(motions):
        start, end = exact[k], exact[(k + 1) % len(exact)]
        twist = Twist(*(FIELD(x) for x in (*motion, 0)[:3]))
        cones.append(Cone(start, end, (twist,)))
    return cones


def decide(rays: list[Vector], motions: list[tuple[int | Fraction, ...]]) -> FanResult:
    result = decide_cones(fan_of(rays, motions))
    assert evidence_holds(result)
    return result


def test_a_forged_verdict_is_refused() -> None:
    result = decide([(1, 0), (-1, 0)], [(0, -1), (0, 1)])
    assert not evidence_holds(replace(result, verdict=Translation.ASYMPTOTICALLY_STABLE))


AXES: list[Vector] = [(1, 0), (0, 1), (-1, 0), (0, -1)]


def test_a_line_of_equilibria_is_stable_but_does_not_attract() -> None:
    """Trap: y > 0 moves down, y < 0 moves up, whatever the field says on y = 0."""
    result = decide([(1, 0), (-1, 0)], [(0, -1), (0, 1)])
    assert result.verdict is Translation.STABLE
    assert {e.move for e in result.evidence} == {Move.REST}


@pytest.mark.parametrize(
    ("rays", "motions", "bounded"),
    [
        ([(0, 1), (0, -1)], [(1, 1), (-1, 1)], False),  # slides outward
        ([(1, 0), (-1, 0)], [(0, -1), (0, 1)], True),  # rests
        ([(1, 0), (0, 1), (-1, 0), (0, -1)], [(-1, 1), (-1, -1), (1, -1), (1, 1)], False),  # turns with gain one
    ],
)
def test_no_growth_is_bounded_where_stability_is_not_proved(
    rays: list[Vector], motions: list[tuple[int | Fraction, ...]], bounded: bool
) -> None:
    result = decide(rays, motions)
    assert (result.squared_overshoot is not None) == bounded
    assert bounded == (result.verdict in (Translation.STABLE, Translation.ASYMPTOTICALLY_STABLE))


def test_an_escaping_slide_is_unstable() -> None:
    """Trap: f = (-+1, 1) on either side of x = 0 slides up the y axis."""
    result = decide([(0, 1), (0, -1)], [(1, 1), (-1, 1)])
    assert result.verdict is Translation.UNSTABLE
    assert [(e.move, e.ray) for e in result.evidence] == [(Move.SLIDE, (FIELD(0), FIELD(1)))]


def test_a_repelling_ray_with_outward_slide_is_unstable_though_both_sides_lead_home() -> None:
    """One solution is enough: on the positive x axis the hull of (1, 1) and (1, -1) holds an outward vector."""
    assert speed_along((FIELD(1), FIELD(0)), twist(1, 1), twist(1, -1)) == 2
    assert speed_along((FIELD(1), FIELD(0)), twist(1, -1), twist(1, 1)) is None


def test_slide_speed_falls_back_on_the_linear_term() -> None:
    """Opposed tangential velocities: the constant term vanishes and the rotation decides."""
    ray = (FIELD(1), FIELD(0))
    assert speed_along(ray, twist(0, 1), twist(0, -1)) == 0  # equilibria
    inward = speed_along(ray, twist(0, 1, 0), twist(-1, -1, 0))
    assert inward is not None
    assert inward < 0
    # n = +-1, rho_1 = 0, rho_2 = 0 but omega differs: numerator (omega_1 rho_2 - omega_2 rho_1) = 0 as well
    assert speed_along(ray, twist(0, 1, 1), twist(0, -1, 1)) == 0


def speed_along(ray: tuple[Number, Number], first: Twist, second: Twist) -> Number | None:
    speed: Number | None = slide_speed(ray_speeds(ray, first), ray_speeds(ray, second))
    return speed


def twist(x: int, y: int, omega: int = 0) -> Twist:
    return Twist(FIELD(x), FIELD(y), FIELD(omega))


@pytest.mark.parametrize(
    ("motions", "verdict"),
    [
        ([(-1, 1), (-1, -1), (1, -1), (1, 1)], Translation.UNDECIDED),  # relay oscillator: gain exactly one
        ([(-2, 1), (-1, -2), (2, -1), (1, 2)], Translation.ASYMPTOTICALLY_STABLE),  # gain 1/16
        ([(-1, 2), (-2, -1), (1, -2), (2, 1)], Translation.UNSTABLE),  # gain 16
    ],
)
def test_full_turns(motions: list[tuple[int, ...]], verdict: Translation) -> None:
    result = decide(AXES, motions)  # type: ignore[arg-type]
    assert result.verdict is verdict
    assert set(result.gains) == {1}
    expected = math.prod(
        Fraction(abs(y if k % 2 == 0 else x), abs(x if k % 2 == 0 else y)) for k, (x, y) in enumerate(motions)
    )
    assert result.gains[1] == expected


def test_overshoot_of_a_stable_fan() -> None:
    """Three quarters of a turn grow tenfold each, and the last pushes back: a slide on the ray through (0, -1).

    The slide leads outward under (-1, -1), inward under (-1, 1000).  From (x, y) on the unit circle the first quarter
    ends at y + 10 x, at most sqrt(101), and two more make it a hundredfold: 101 * 100^2.
    """
    assert decide(AXES, [(-1, 10), (-10, -1), (1, -10), (-1, -1)]).verdict is Translation.UNSTABLE
    home = decide(AXES, [(-1, 10), (-10, -1), (1, -10), (-1, 1000)])
    assert home.verdict is Translation.ASYMPTOTICALLY_STABLE
    assert home.squared_overshoot == 1_010_000


def test_rest_and_rotation_in_place() -> None:
    assert decide(AXES, [(0, 0)] * 4).verdict is Translation.STABLE
    turning = decide(AXES, [(0, 0, 1)] * 4)
    assert turning.verdict is Translation.UNDECIDED
    assert turning.evidence[0].move is Move.TIE


def test_rotation_bends_a_path_along_a_side_back_into_its_cone_or_out_of_it() -> None:
    """The velocity lies along a ray: whether the body stays in the cone is decided by omega."""
    below: tuple[int, ...] = (0, -1)
    escaping = decide(AXES, [(1, 0, 1), (0, -1), (0, -1), below])
    assert escaping.verdict is Translation.UNSTABLE
    # bent out of its cone, into one that pushes it back: a slide at speed one
    pushed_back = decide(AXES, [(1, 0, -1), (0, -1), (0, -1), (-1, 1)])
    assert pushed_back.verdict is Translation.UNSTABLE
    assert Move.SLIDE in {e.move for e in pushed_back.evidence}


# ---- velocities along rays: omega decides ------------------------------------------------------------


def test_a_start_may_leave_at_a_root_and_come_home() -> None:
    """The first quarter's velocity lies along its last ray and is bent out: eps leaves at about sqrt(2 eps)."""
    result = decide(AXES, [(0, 1, 1), (-1, -1), (2, 1), (-1, 1)])
    assert result.verdict is Translation.ASYMPTOTICALLY_STABLE
    assert result.grows_to_a_root
    assert result.squared_overshoot is None
    assert "eps^(1/2)" in result.reason


@pytest.mark.parametrize(
    ("motions", "order", "verdict"),
    [
        ([(0, 1, 1), (-1, -1), (1, -1), (1, 1)], Fraction(1, 2), Translation.UNSTABLE),
        ([(-1, 0, 1), (-1, -1), (1, -1), (1, 1)], Fraction(2), Translation.ASYMPTOTICALLY_STABLE),
        ([(0, 1, 1), (0, -1, 1), (1, -1), (1, 1)], Fraction(1), Translation.UNDECIDED),
    ],
)
def test_orders_of_full_turns(motions: list[tuple[int, ...]], order: Fraction, verdict: Translation) -> None:
    """Along the exit ray outward: sqrt(eps). Along the entry ray inward: eps^2. Both in one turn: they cancel."""
    result = decide(AXES, motions)  # type: ignore[arg-type]
    assert [turn.order for turn in result.turns] == [order]
    assert result.verdict is verdict


@pytest.mark.parametrize(
    ("below", "verdict"),
    [((2, 1), Translation.ASYMPTOTICALLY_STABLE), ((1, 2), Translation.UNSTABLE), ((1, 1), Translation.UNDECIDED)],
)
def test_a_half_plane_keeps_the_distance_and_the_other_cones_decide(
    below: tuple[int, int], verdict: Translation
) -> None:
    """Above, the body moves along the line and is bent back onto it at the same distance; below, two quarters."""
    x, y = below
    result = decide([(1, 0), (-1, 0), (0, -1)], [(-1, 0, 1), (x, -y), (1, 1)])
    assert result.gains == {1: Fraction(y, x)}
    assert result.verdict is verdict


def random_fan(seed: int) -> tuple[list[Vector], list[tuple[int | Fraction, ...]]]:
    rng = np.random.default_rng(seed)
    angles = np.sort(rng.choice(24, size=int(rng.integers(3, 7)), replace=False)) * math.tau / 24
    rays: list[Vector] = [(round(40 * math.cos(a)), round(40 * math.sin(a))) for a in angles]
    motions: list[tuple[int | Fraction, ...]] = []
    for a in angles:
        inward = a + math.pi + rng.uniform(-1.6, 1.9)
        motions.append((round(30 * math.cos(inward)), round(30 * math.sin(inward))))
    return rays, motions


def gap_is_too_wide(rays: list[Vector]) -> bool:
    closed = [*rays, rays[0]]
    return any(p[0] * q[1] - p[1] * q[0] <= 0 for p, q in pairwise(closed))


def simulate(rays: list[Vector], motions: list[tuple[int | Fraction, ...]], start: float) -> float:
    """Largest distance reached by small Euler steps from the unit circle: they chatter where the field slides."""
    angles = np.array([math.atan2(float(y), float(x)) % math.tau for x, y in rays])
    order = np.argsort(angles)
    velocities = np.array([[float(m[0]), float(m[1])] for m in motions])
    velocities /= np.hypot(*velocities.T).max()
    point, far = np.array([math.cos(start), math.sin(start)]), 1.0
    for _ in range(6000):
        angle = math.atan2(point[1], point[0]) % math.tau
        k = order[np.searchsorted(angles[order], angle, side="right") - 1]
        distance = float(np.hypot(*point))
        if distance < 0.05:
            break
        if distance > 60:
            return distance
        point = point + 0.004 * max(distance, 0.3) * velocities[k]
        far = max(far, distance)
    return far


FANS = [seed for seed in range(150) if not gap_is_too_wide(random_fan(seed)[0])]


@pytest.mark.parametrize("seed", FANS)
def test_random_fans_against_simulation(seed: int) -> None:
    rays, motions = random_fan(seed)
    result = decide(rays, motions)
    if result.verdict is Translation.UNSTABLE:
        for evidence in result.evidence:
            if not repels(evidence, rays, motions):  # no simulation follows the slide on a repelling ray
                x, y = (float(v) for v in evidence.ray)
                # slow slides grow by a few per cent of the distance per time constant
                assert simulate(rays, motions, math.atan2(y, x)) > 1.2
    else:
        assert result.verdict is not Translation.UNDECIDED
        farthest = max(simulate(rays, motions, start) for start in np.linspace(0.1, 6.2, 7))
        # Euler steps of 0.4 % of the distance overshoot each ray a little
        assert farthest <= math.sqrt(float(result.squared_overshoot)) * 1.3 + 0.1


def repels(evidence: MoveEvidence, rays: list[Vector], motions: list[tuple[int | Fraction, ...]]) -> bool:
    """A slide on a ray that the motions on its two sides do not both push towards."""
    if evidence.move is not Move.SLIDE:
        return False
    k = next(k for k, (x, y) in enumerate(rays) if evidence.ray == (x, y))
    (x, y), before, after = rays[k], motions[k - 1], motions[k]
    return not (x * before[1] - y * before[0] > 0 > x * after[1] - y * after[0])


def test_random_fans_meet_every_verdict_and_every_escape_can_be_simulated() -> None:
    counts, escapes = Counter[Translation](), 0
    for seed in FANS:
        rays, motions = random_fan(seed)
        result = decide(rays, motions)
        counts[result.verdict] += 1
        if result.verdict is Translation.UNSTABLE:
            escapes += any(not repels(evidence, rays, motions) for evidence in result.evidence)
    assert counts == {Translation.UNSTABLE: 55, Translation.ASYMPTOTICALLY_STABLE: 23, Translation.STABLE: 3}
    assert escapes == 55


def test_the_fan_of_an_array_covers_every_direction(arrays: Arrays) -> None:
    from nonsmooth.analysis.cells.nearest import build_nearest_partition

    for scene in (arrays.four_wheel(), arrays.ring(5), arrays.grid(4, 4)):
        cones = build_fan(build_nearest_partition(scene))
        assert all(a.end == b.start for a, b in pairwise([*cones, cones[0]]))
        turn = sum(math.atan2(*_angle(cone)) for cone in cones)
        assert turn == pytest.approx(math.tau)


def _angle(cone: Cone) -> tuple[float, float]:
    (a, b), (c, d) = ((float(v[0]), float(v[1])) for v in (cone.start, cone.end))
    return a * d - b * c, a * c + b * d


# ---- several motions in one cone -----------------------------------------------------------------


def tied_cones(seed: int) -> list[Cone]:
    """A random fan with two motions in every cone."""
    rays, motions = random_fan(seed)
    _, others = random_fan(seed + 1000)
    cones = fan_of(rays, motions)
    tied = []
    for k, cone in enumerate(cones):
        second = others[k % len(others)]
        twist_of_second = Twist(FIELD(second[0]), FIELD(second[1]), FIELD.zero)
        tied.append(replace(cone, twists=(*cone.twists, twist_of_second)))
    return tied


def simulate_mixtures(cones: list[Cone], rng: np.random.Generator) -> tuple[float, float]:
    """Largest and final distance of Euler steps that follow random mixtures, for a random while each."""
    rays = np.array([[float(x) for x in cone.start] for cone in cones])
    angles = np.arctan2(rays[:, 1], rays[:, 0]) % math.tau
    order = np.argsort(angles)
    velocities = np.array([[[float(t.vx), float(t.vy)] for t in cone.twists] for cone in cones]) / 40
    start = rng.uniform(0, math.tau)
    point, far, weight = np.array([math.cos(start), math.sin(start)]), 1.0, 0.5
    for step in range(4000):
        if step % 25 == 0:
            weight = float(rng.choice([0.0, 1.0, rng.uniform()]))
        k = order[np.searchsorted(angles[order], math.atan2(point[1], point[0]) % math.tau, side="right") - 1]
        distance = float(np.hypot(*point))
        far = max(far, distance)
        if distance < 0.05 or distance > 60:
            break
        point = point + 0.004 * max(distance, 0.3) * (weight * velocities[k][0] + (1 - weight) * velocities[k][1])
    return far, float(np.hypot(*point))


@thorough  # the small one: test_random_fans_against_simulation
def test_mixtures_of_tied_motions_never_refute_a_verdict() -> None:
    """Where the fan says asymptotically stable, no random mixture runs away."""
    rng, stable = np.random.default_rng(0), 0
    for seed in range(900):
        if gap_is_too_wide(random_fan(seed)[0]):
            continue
        cones = tied_cones(seed)
        result = decide_cones(cones)
        assert result.squared_overshoot is None
        if result.verdict is Translation.ASYMPTOTICALLY_STABLE:
            stable += 1
            for _ in range(4):
                far, last = simulate_mixtures(cones, rng)
                assert far < 60
                assert last < max(1.0, far)
    assert stable >= 5


@pytest.mark.parametrize(
    ("tied", "verdict"),
    [
        ([(-1, Fraction(1, 8)), (-1, Fraction(1, 4))], Translation.ASYMPTOTICALLY_STABLE),
        ([(-1, 0, 1), (-1, Fraction(1, 8))], Translation.UNDECIDED),  # from s to the order of s^2, or to s/8
        ([(-1, 0, 1), (-1, 0, 2)], Translation.UNDECIDED),
    ],
)
def test_full_turns_with_a_tie_of_another_order_are_not_said_to_contract(
    tied: list[tuple[int | Fraction, ...]], verdict: Translation
) -> None:
    first, *others = fan_of(AXES, [(-1, 1), (-1, -1), (1, -1), (1, 1)])
    twists = tuple(Twist(*(FIELD(x) for x in (*motion, 0)[:3])) for motion in tied)
    result = decide_cones([replace(first, twists=twists), *others])
    assert result.verdict is verdict
    assert evidence_holds(result)


@pytest.mark.parametrize("count", keep(1, [10, 40]))
def test_tied_motions_of_an_array_are_decided(arrays: Arrays, count: int) -> None:
    from nonsmooth.analysis.cells.nearest import build_nearest_partition
    from nonsmooth.proofs.clauses.translation.on_cells import decide_translation

    verdicts = {decide_translation(build_nearest_partition(arrays.cocircular(s, (1, 1)))).verdict for s in range(count)}
    assert Translation.UNDECIDED not in verdicts
    assert len(verdicts) > 1
