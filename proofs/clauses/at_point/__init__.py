"""Rules without cells: the exact motion at the checked point and to first order near it."""
