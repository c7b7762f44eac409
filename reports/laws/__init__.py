"""Feedback laws: as they act in a loop, as tables, and as programs."""
