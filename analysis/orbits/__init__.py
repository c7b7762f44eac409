"""Periodic orbits of switched fields in floats: found by shooting, with their Floquet multipliers."""
