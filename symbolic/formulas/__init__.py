"""Formulas in states and parameters: parsed, split into polynomial pieces, enclosed, written."""
