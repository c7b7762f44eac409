"""Clause 4: whether discontinuous feedback stabilizes position and heading."""
