"""Products of square roots of a field as bit masks: bit i stands for ``sqrt(g_i)``."""

from __future__ import annotations


def bits(mask: int) -> list[int]:
    """Indices of the set bits of a mask, ascending."""
    return [i for i in range(mask.bit_length()) if mask >> i & 1]
