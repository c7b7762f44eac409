"""Polynomials that are positive where others are not negative, proved by sums of squares in rational arithmetic."""
