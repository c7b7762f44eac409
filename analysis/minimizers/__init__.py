"""The dissipation and its minimizers at a point: several numeric methods, one way to check them."""
