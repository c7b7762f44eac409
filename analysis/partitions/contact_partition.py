"""The cells of an array under whichever contact rule its scene names."""

from __future__ import annotations

from nonsmooth.analysis.partitions.box import build_box_partition
from nonsmooth.analysis.partitions.nearest import build_nearest_partition
from nonsmooth.analysis.partitions.partition import Partition, RefusalError
from nonsmooth.symbolic.rule import Rule
from nonsmooth.symbolic.scene import Scene


def build_partition(scene: Scene, *, prune: bool = True) -> Partition:
    """Cells of the scene's contact rule in the checked square, in the scene's own coordinates.

    Raises:
        RefusalError: for rule ``ellipse``, which has no cells, and where the motion is not determined.
    """
    match scene.contact.rule:
        case Rule.NEAREST:
            return build_nearest_partition(scene, prune=prune)
        case Rule.BOX:
            return build_box_partition(scene)
        case _:
            raise RefusalError(
                'contact.rule: required "nearest" or "box" for cells, received "ellipse": its field is continuous'
            )
