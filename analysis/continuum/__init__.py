"""The continuous idealization: force and moment of a force field on a footprint, and where it comes to rest."""
