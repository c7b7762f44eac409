"""How a vehicle on its own wheels moves for commanded wheel speeds, under every contact rule."""
