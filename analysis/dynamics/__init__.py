"""Full dynamics of the body beside the quasi-static rules: Newton-Euler equations, paths, what mass changes."""
