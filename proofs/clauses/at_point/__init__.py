"""The motion at the checked point: exact and to first order without cells, or under every load of a set."""
