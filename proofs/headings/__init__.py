"""Equilibrium headings of a body with an outline: where it rests for a range of headings, or for one."""
