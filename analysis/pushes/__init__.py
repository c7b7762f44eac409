"""Pushed objects: contacts carried by the body, a pusher with a velocity, and 400 measured pushes."""
