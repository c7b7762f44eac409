"""Clause 1: whether the checked point is an equilibrium."""
