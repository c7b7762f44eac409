"""Exact cells of a contact rule: the polygons that it cuts the checked square into, and the equilibria in them."""
