"""Stiff and extreme cases in floats, each with its error against exact or 60-digit arithmetic."""
