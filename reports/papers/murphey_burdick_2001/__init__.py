"""Murphey and Burdick 2001, claim by claim, each with the computation that shows it; and what only its array needs."""
