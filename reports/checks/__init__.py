"""Checks of scenes and what they print: answers, clauses, cells, other rules, measurements, vehicles."""
