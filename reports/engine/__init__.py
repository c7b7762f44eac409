"""Scenes as files of the physics engine MuJoCo."""
