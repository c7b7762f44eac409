"""Plain switched systems: the derivation report of one system, section by section."""
