"""A study of a scene, its result, and the command that runs it."""
