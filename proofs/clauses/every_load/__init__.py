"""The clauses where loads are unknown: what holds for every load of a set, or a load for which it fails."""
