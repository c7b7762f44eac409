"""The Python interface: arrays, plain systems and their results as a script or a notebook holds them."""
