"""Scene files: what a TOML or CSV may say, how it is validated, and the scenes that are built in."""
