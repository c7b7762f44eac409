"""Vehicles on their own wheels, exactly: the frame of the array reversed, the mathematics the same."""
