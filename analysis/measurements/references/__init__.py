"""References of the measurements: exact paths and twists, and the same at 60 digits or more."""
