"""What a path shows at a time: the twist of the body, the slip at every wheel, which wheels carry it."""
