"""Paths from starts and maps of where they end, of arrays and of plain systems."""
