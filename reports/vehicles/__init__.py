"""Vehicles on their own wheels as people read them: tables, JSON, a picture, parameters of a controller."""
