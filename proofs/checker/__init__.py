"""Stand-alone checker of certificates: the standard library alone, and nothing of the workbench."""
