"""Clause 2: stability of the position (x, y)."""
