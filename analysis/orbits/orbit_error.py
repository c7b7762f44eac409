"""What is said where no periodic orbit is found, or nothing can be said of one."""

from __future__ import annotations


class OrbitError(ValueError):
    """No periodic orbit, or one whose derivative does not exist; the message says where and why."""
