"""Periodic orbits of planar systems, proved: return maps enclosed by balls."""
