"""Switched fields (cells or switching functions, one smooth field each), Filippov sets and upper derivatives."""
