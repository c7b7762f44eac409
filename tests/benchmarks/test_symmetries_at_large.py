"""Two hundred random arrays through every symmetry of the fast tests."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from nonsmooth.symbolic.mechanics.scene import Scene
from tests.benchmarks.conftest import Stopwatch
from tests.conftest import Arrays
from tests.proofs import test_symmetries as symmetries

ARRAYS = 100  # of each kind: any wheels, and wheels on a circle
MAPS = (symmetries.TURN_3_4_5, 1), (symmetries.MIRROR, -1)
PLAIN = (
    symmetries.test_speeds,
    symmetries.test_time_reversal_swaps_the_ends_of_the_drift,
    symmetries.test_frictions,
    symmetries.test_reversed_rims_with_reversed_speeds_are_the_same_wheels,
    symmetries.test_the_length_of_a_rim_direction_does_not_matter,
    symmetries.test_numbering,
    symmetries.test_a_wheel_too_far_away_to_matter,
    symmetries.test_translation_of_the_array_with_its_equilibrium,
)


def test_every_symmetry(arrays: Arrays, stopwatch: Stopwatch) -> None:
    builders: tuple[Callable[[int], Scene], ...] = (
        lambda seed: arrays.random(seed, 3 + seed % 6).recentred(),
        arrays.cocircular,
    )
    for build in builders:
        for seed in range(1000, 1000 + ARRAYS):
            for matrix, sense in MAPS:
                symmetries.test_orthogonal_maps(build, seed, matrix, sense)
            symmetries.test_lengths(build, seed, Fraction(7, 3))
            for relation in PLAIN:
                relation(build, seed)
    stopwatch.report(f"{2 * ARRAYS} random arrays, {len(PLAIN) + 3} symmetries each: all hold")
