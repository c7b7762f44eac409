"""The audit of the paper: each item with the computation that shows it."""
