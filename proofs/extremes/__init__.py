"""Verdicts on extreme scenes, compared with what invariance demands."""
