"""Measurements against references: studies of error against run time, and stiff and extreme cases."""
