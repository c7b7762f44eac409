"""Scenes from the objects of other libraries, and fields, functions and verdicts as texts for other programs."""
