"""An array under another contact rule."""

from __future__ import annotations

from dataclasses import replace

from nonsmooth.symbolic.mechanics.scene import Scene


def ruled(scene: Scene, rule: str) -> Scene:
    """The same array, loads and square."""
    return replace(scene, contact=replace(scene.contact, rule=rule))


def centred(scene: Scene, rule: str) -> Scene:
    """The same with the checked point for its origin."""
    return ruled(scene, rule).recentred()
