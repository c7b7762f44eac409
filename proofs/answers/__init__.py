"""Answers to the questions of a builder, in words and numbers, from the verdicts of a check."""
