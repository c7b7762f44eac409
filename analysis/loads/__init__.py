"""Floats that propose which wheels carry, and how much; exact conditions confirm what verdicts need of them."""
