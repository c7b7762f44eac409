"""The basin of an array as triangles: from where bodies come to a polygon about the checked point, and stay in it.

Under a rule with cells the centre of mass moves as ``c' = v + omega J c`` with one twist, or a mixture of several, in
each cell.  Rings are proposed in floats and grow backward (:mod:`nonsmooth.proofs.systems.basin_rings`), from a circle
over which all velocities lead inward; triangles between them (:mod:`nonsmooth.proofs.systems.basin_mesh`) are shown by
theorem ``basin`` of arrays (:mod:`nonsmooth.proofs.checker.array_basin`), which derives cells and velocities from the
wheels.  How much of the square comes home is sampled.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, partial
from itertools import product

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.nearest import float_vertices
from nonsmooth.analysis.cells.partition import Partition, RefusalError
from nonsmooth.proofs.certificate import cells_record, subject_record
from nonsmooth.proofs.checker.array_basin import ArrayPlane, Core
from nonsmooth.proofs.checker.basin import Mesh
from nonsmooth.proofs.checker.contact import Cells
from nonsmooth.proofs.checker.statements import show_entry
from nonsmooth.proofs.checker.wheels import read_array
from nonsmooth.proofs.checker.work import RejectedError
from nonsmooth.proofs.findings import Record, encode
from nonsmooth.proofs.system_facts import basin_record
from nonsmooth.proofs.systems.basin import NEARLY_ALL, CertifiedBasin
from nonsmooth.proofs.systems.basin_mesh import Announce, BasinEffort, BuiltMesh, grown_mesh, last_ring, mesh_corners
from nonsmooth.proofs.systems.basin_rings import (
    Bernstein,
    RingGrowth,
    area,
    bernstein,
    followed_home,
    inside_ring,
    sines,
)
from nonsmooth.symbolic.mechanics.body import widest_square
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.number_text import float_text, percent_text
from nonsmooth.symbolic.numbers.plane_arrays import (
    Floats,
    Mask,
    max_norm,
    point_velocities,
    polygon_sides,
    row_norms,
    unit_vectors,
)

COARSE = BasinEffort(RingGrowth(0.12, 0.03, 0.02), 41, every=8)
FINE = BasinEffort(RingGrowth(0.04, 0.012, 0.02), 101, every=8)
EFFORTS = {"fast": (COARSE,), "best": (FINE, COARSE)}  # tried in turn, until triangles fill the last ring
PIXELS = 96  # of a raster of the square, in each direction, by which cells are looked up
CIRCLE = 48  # points of the first ring
INWARD = 0.02  # sine of the angle at which velocities lead inward over it, at least
RESTING = (1.01, 1.03, 1.1)  # factors by which the convex hull of cells in which bodies rest is made wider
CIRCLES = 3  # that are tried about one place
SMALLEST, WIDER = 2.0**-10, 1.06  # radii that are tried: of the square's half-width, and each of the one before
NEAR = 2.0**-30  # of the square's half-width: what is as near to a line may lie on either side
SQUARE = 2.0**-20  # by which the square in which the mesh lies is smaller than that of the cells
FOLLOWED = ("nearest", "box")  # contact rules


class FloatCells:
    """The cells of an array in floats, about the checked point.

    Attributes:
        half: of the square that they cover.
        resting: the convex hull of the cells in which bodies may rest; None without any.
    """

    surfaces = ()  # no line is worth having corners on it: triangles lie across borders of cells
    scale = np.inf  # velocities are affine

    def __init__(self, partition: Partition) -> None:
        self.half = float(partition.domain.vertices[0][0].__abs__())
        self.outlines = [np.array(float_vertices(cell.polygon)) for cell in partition.cells]
        self._motions = [np.array(cell.twists, dtype=float) for cell in partition.cells]
        most, longest = max(map(len, self._motions)), max(map(len, self.outlines))
        self._padded = np.stack([velocities[np.arange(most) % len(velocities)] for velocities in self._motions])
        sides = [half_planes(outline) for outline in self.outlines]
        self._sides = np.stack([planes[np.arange(longest) % len(planes)] for planes in sides])  # (cells, sides, 3)
        corners = [outline for cell, outline in zip(partition.cells, self.outlines, strict=True) if cell.rests]
        self.resting = convex_outline(np.concatenate(corners)) if corners else None
        self._boxes = [(outline.min(axis=0), outline.max(axis=0)) for outline in self.outlines]

    @cached_property
    def _raster(self) -> NDArray[np.int64]:
        """The cells that each pixel of the square may meet, shape (pixels, most); repeated where there are fewer."""
        width = 2 * self.half / PIXELS
        middles = (np.arange(PIXELS) + 0.5) * width - self.half
        places = np.stack(np.meshgrid(middles, middles, indexing="ij"), axis=-1).reshape(-1, 2)
        homogeneous = np.column_stack([places, np.ones(len(places))])
        meets = np.stack([(homogeneous @ planes.T).min(axis=1) >= -width for planes in self._sides], axis=1)
        most = int(meets.sum(axis=1).max())
        order = np.argsort(~meets, axis=1, kind="stable")[:, :most]
        return np.where(np.take_along_axis(meets, order, axis=1), order, order[:, :1])

    def which(self, x: Floats) -> NDArray[np.int64]:
        """The cells of places: those of the nearest ones for places outside the square."""
        pixels = np.clip(((x + self.half) / (2 * self.half) * PIXELS).astype(int), 0, PIXELS - 1)
        listed = self._raster[pixels[:, 0] * PIXELS + pixels[:, 1]]
        homogeneous = np.column_stack([x, np.ones(len(x))])
        inside = np.einsum("pcsk,pk->pcs", self._sides[listed], homogeneous).min(axis=2)
        return listed[np.arange(len(x)), inside.argmax(axis=1)]

    def at(self, x: Floats) -> Floats:
        """The velocities at places: shape (motions, places, 2)."""
        return point_velocities(self._padded[self.which(x)].transpose(1, 0, 2), x)

    def _on(self, cell: int, x: Floats) -> Floats:
        """The velocities that a cell has, wherever the places are: shape (motions, places, 2)."""
        return point_velocities(self._motions[cell][:, None], x)

    def velocities(self, cell: int, triangles: Floats) -> Iterator[tuple[Floats, Bernstein]]:
        """The affine velocities of a cell at the nodes of triangles, one motion after the other."""
        points = bernstein(1)
        at = points.places(triangles)
        for velocity in self._on(cell, at.reshape(-1, 2)):
            yield velocity.reshape(at.shape), points

    def slides(self, ring: Floats) -> tuple[NDArray[np.int64], Floats, Floats]:
        """None: triangles lie across borders of cells, and so do tips of rings."""
        return np.zeros(0, dtype=np.int64), np.zeros((0, 2)), np.zeros((0, 2))

    def meeting(self, triangles: Floats, exact: Mapping[int, Floats]) -> Iterator[tuple[int, Mask]]:
        """Each cell with the triangles that no line of a side, of its own or of theirs, parts from it."""
        low, high, near = triangles.min(axis=1), triangles.max(axis=1), NEAR * self.half
        turns = np.stack([half_planes(triangle) for triangle in triangles]) if len(triangles) else np.zeros((0, 3, 3))
        for cell, (own_low, own_high) in enumerate(self._boxes):
            near_box = ((low <= own_high + near) & (high >= own_low - near)).all(axis=1)
            todo = np.nonzero(near_box)[0]
            if not len(todo):
                continue
            corners = np.concatenate([triangles[todo], np.ones((len(todo), 3, 1))], axis=2)
            beyond = np.einsum("sk,tck->tsc", half_planes(self.outlines[cell]), corners).max(axis=2).min(axis=1)
            outline = np.column_stack([self.outlines[cell], np.ones(len(self.outlines[cell]))])
            behind = np.einsum("tsk,ck->tsc", turns[todo], outline).max(axis=2).min(axis=1)
            met = np.zeros(len(triangles), dtype=bool)
            met[todo] = (beyond > -near) & (behind > -near)
            if met.any():
                yield cell, met


def convex_outline(places: Floats) -> Floats:
    """The corners of the convex hull of places, counterclockwise."""
    from scipy.spatial import ConvexHull  # under rule box only

    return places[ConvexHull(places).vertices]


def half_planes(outline: Floats) -> Floats:
    """Of a convex polygon, counterclockwise: a, b, c with ``a x + b y + c`` the distance inward from each side."""
    return -polygon_sides(outline)


@dataclass(frozen=True)
class ArrayBasin:
    """Triangles from which a body comes to the checked point, or to a polygon about it that it does not leave.

    Attributes:
        triangles: with their hypotheses, of theorem ``basin`` of arrays.
        entry: of a certificate, with numbers of the scene's field.
        claim: what the checker has shown by it.
        half: of the square of which starts are sampled: the largest in the support polygon.
        within: of the point, bodies end; None where they come to the point itself.
        coming: sampled starts that come there in floats, measured from the point, certified or not: shape (starts, 2).
    """

    triangles: CertifiedBasin
    entry: Record
    claim: Record
    half: float
    within: float | None
    coming: Floats

    @property
    def area(self) -> float:
        """Of the region, with the polygon inside."""
        return area(self.triangles.border)

    def words(self, length: str) -> str:
        """What is certified, how much that is of what is sampled, and where; lengths have a unit, or none."""
        certified, coming = self.triangles.sampled
        unit = f" {length}" if length else ""
        ends = "comes home" if self.within is None else f"ends within {float_text(self.within)}{unit} of the point"
        size = f"{float_text(self.area)}{unit}{'^2' if unit else ''}"
        region = f"from anywhere in a region of area {size} a body {ends} ({len(self.triangles.simplices)} triangles)"
        square = f"the square of half-width {float_text(self.half)}{unit}, the largest on the wheels"
        share = f"{percent_text(self.triangles.share)} of those that do ({certified} of {coming})"
        return f"{region}; of the starts sampled in {square}, it holds {share}"

    def record(self, unit: str) -> dict[str, object]:
        """As JSON, with the area, where bodies end, and the square of which starts are sampled."""
        further = {"area": self.area, "ends_within": self.within, "square": self.half}
        return basin_record(self.triangles, self.words(unit)) | further


@dataclass(frozen=True)
class NoBasin:
    """No triangles were certified.

    Attributes:
        why: in half a sentence.
    """

    why: str


def find_array_basin(scene: Scene, asked: str, announce: Announce) -> ArrayBasin | NoBasin:
    """A basin of triangles about the checked point that the checker has accepted, or why there is none.

    Args:
        scene: an array.
        asked: how much may be done for it, of EFFORTS.
        announce: told what is done, how much of it, and of how much.
    """
    if scene.contact.rule not in FOLLOWED:
        return NoBasin(f"rule {scene.contact.rule} has no cells")
    if scene.body is not None:
        return NoBasin("the wheels under a body with an outline change")
    about = scene.recentred()
    half = widest_square(about.positions, about.check.equilibrium)
    if half is None:
        return NoBasin("the point is not inside the support polygon")
    announce("cells of the support polygon", 0, 1)
    try:
        partition = build_partition(replace(about, check=replace(about.check, radius=half)), prune=False)
    except RefusalError as error:
        return NoBasin(str(error))
    return _around(scene, partition, EFFORTS[asked], announce)


def _around(
    scene: Scene, partition: Partition, efforts: Sequence[BasinEffort], announce: Announce
) -> ArrayBasin | NoBasin:
    """The search on the cells of a square."""
    field = FloatCells(partition)
    exact = {"within": partition.scene.check.radius, **cells_record(partition)}
    document = encode({"subject": subject_record(scene), "record": exact})
    array, record = read_array(document["subject"]), document["record"]
    cells = Cells(replace(array, radius=array.field.parse(record["within"])), record["points"], record["cells"])
    meshes, why = _meshes(field, cells, efforts, announce)
    announce("the checker", 0, 1)
    for built, first, starts in meshes:
        mesh, below = built.record, built.below
        stated: Record = {"mesh": mesh, "below": below, "squared_radius": _squared_radius(mesh, below)}
        try:
            (claim,) = show_entry(array, {"theorem": "basin", "hypotheses": {**record, **stated}, "proofs": {}})
        except RejectedError as error:
            why = f"the checker asks for {error}"
            continue
        sampled, coming = _sampled(field, first, last_ring(mesh_corners(mesh)), starts)
        within = float(Fraction(stated["squared_radius"])) ** 0.5 if "ends" in claim else None
        hypotheses: Record = {**exact, **stated}
        entry = {"theorem": "basin", "hypotheses": hypotheses, "proofs": {}}
        return ArrayBasin(CertifiedBasin(hypotheses, sampled), entry, claim, field.half, within, coming)
    return NoBasin(why)


def _meshes(
    field: FloatCells, cells: Cells, efforts: Sequence[BasinEffort], announce: Announce
) -> tuple[list[tuple[BuiltMesh, Floats, int]], str]:
    """Meshes that floats propose, the largest first, and why there is none.

    With each stand the ring from which it begins, and how many starts in a row are sampled.  The first mesh that fills
    its rings is the last one that is made.
    """
    meshes, why = [], _why_none(field)
    for first, effort in product(_first_rings(field), efforts):
        limit = field.half * (1 - SQUARE)
        exact = partial(ArrayPlane, cells)
        built, last = grown_mesh(field, exact, first, effort, limit, announce, is_first_whole=True)
        if built is not None:
            meshes.append((built, first, effort.starts))
            if built.area > NEARLY_ALL * area(last):
                break
        elif last is not first:  # there is a ring around the first one
            why = "W is not seen to fall beside the first ring"
    return sorted(meshes, key=lambda mesh: -mesh[0].area), why


def _circle(centre: Floats, radius: float) -> Floats:
    angles = np.linspace(0, 2 * np.pi, CIRCLE, endpoint=False)
    return centre + radius * unit_vectors(angles)


def _first_rings(field: FloatCells) -> Iterator[Floats]:
    """Convex polygons over which velocities are seen to lead inward, small ones first.

    Where bodies rest in cells, polygons about these; else circles about the point, and about where bodies from it end.
    """
    if field.resting is not None:
        middle = field.resting.mean(axis=0)
        for wider in RESTING:
            ring = middle + wider * (field.resting - middle)
            if max_norm(ring) < field.half and _leads_inward(field, ring):
                yield ring
        return
    for centre in (np.zeros(2), _end(field)):
        radius, leading = SMALLEST * field.half, 0
        while radius < field.half - np.abs(centre).max() and leading < CIRCLES:
            if _leads_inward(field, _circle(centre, radius)):
                leading += 1
                radius *= WIDER**leading
                yield _circle(centre, radius)
            radius *= WIDER


def _why_none(field: FloatCells) -> str:
    if field.resting is None:
        return "no circle is seen over which all velocities lead inward"
    if np.abs(field.resting).max() * RESTING[0] >= field.half:
        return "the area in which bodies rest reaches the border of the largest square on the wheels"
    return "velocities do not lead inward around the area in which bodies rest"


def _leads_inward(field: FloatCells, ring: Floats) -> bool:
    """Whether all velocities are seen to lead inward over the sides of a polygon that is counterclockwise."""
    return bool(sines(field, ring[::-1]).min() > INWARD)


def _end(field: FloatCells) -> Floats:
    """The middle of where bodies end that start about the point, by steps that become smaller."""
    x = _circle(np.zeros(2), field.half / 2)
    for step in np.geomspace(field.half / 50, field.half / 10_000, 400):
        v = field.at(x)[0]
        x = x + step * v / (row_norms(v)[:, None] + np.finfo(float).tiny)
    return x.mean(axis=0)


def _squared_radius(mesh: Record, below: int) -> str:
    """Of the smallest disc about the point that holds the first ring, exactly."""
    core = Core(Mesh(mesh), below)
    return str(max(x * x + y * y for x, y in core.places) * Fraction(mesh["unit"]) ** 2)


def _sampled(field: FloatCells, first: Floats, border: Floats, count: int) -> tuple[tuple[int, int], Floats]:
    """Of a grid of the square: how many starts are certified, and how many come to the first ring in floats; these."""
    line = np.linspace(-field.half, field.half, count + 2)[1:-1]
    starts = np.array([(x, y) for y in line for x in line])
    came = followed_home(field, starts, lambda x: inside_ring(first, x), 2 * field.half)
    certified = inside_ring(border, starts)
    return (int(np.sum(certified)), int(np.sum(came | certified))), starts[came | certified]
