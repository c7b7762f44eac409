"""A body with an outline under a rule with cells, as a switched field of poses.

A pose lies in a cell of two kinds of surfaces: the wheels that are under the body (``g_i = 0``, curved), and where c
lies between the lines of the cells on these wheels.  Which lines there are depends on the wheels.  So the faces at a
pose are those of the surfaces through it: for every pattern of signs whose tangent cone has poses, the wheels under the
body, and of their cells the one on the pattern's side of its lines.  A pattern whose wheels do not carry the body is
beyond the border of the field: there it tips.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import islice

import numpy as np

from nonsmooth.analysis.bodies.moving_outline import MovingOutline
from nonsmooth.analysis.bodies.supports import CarryingWheels, finite_start, tipped_start, tipping_edge, wheel_changes
from nonsmooth.analysis.bodies.switching import subsets_of
from nonsmooth.analysis.cells.contact_rule import CellRule
from nonsmooth.analysis.fields.constant_field import array_field
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.fields.switched_field import SURFACE_SLACK, Face, Member, Surface, affine_surface, sign_patterns
from nonsmooth.analysis.trajectories.faces import FaceChoice
from nonsmooth.analysis.trajectories.follow import Mode, Path
from nonsmooth.analysis.trajectories.result import EndReason, EventKind, Trajectory, TrajectoryError
from nonsmooth.analysis.trajectories.smooth_path import MAX_EVENTS, MAX_WORK, FilippovFaces, Weights, near_rounding
from nonsmooth.symbolic.mechanics.body import support_polygon
from nonsmooth.symbolic.mechanics.contact_set import require_springs, with_only
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.mechanics.similar_scenes import counted_in_own_length
from nonsmooth.symbolic.numbers.number_text import numbers_text
from nonsmooth.symbolic.numbers.plane import around, cross
from nonsmooth.symbolic.numbers.plane_arrays import Floats, max_norm, norm, places_of
from nonsmooth.symbolic.numbers.work_limit import WorkMeter

# ---- cells on one set of wheels ------------------------------------------------------------------
#
# The cells of a contact rule on one set of carrying wheels, in floats, wherever the body stands on them.
#
# A cell is bounded by lines of the plane. Cells of different sets may share lines (bisectors under rule ``nearest``,
# axes of symmetry), so all sets take them from one :class:`Lines`, where equal lines are one surface.


SAME_LINE = 1e-12  # unit normals, and offsets over the array's size, that differ by less are one line's

Side = tuple[Surface, int]  # a line and the side of it on which a cell lies


class Lines:
    """Lines of the plane of c, each of them one surface of poses."""

    def __init__(self, size: float) -> None:
        """For an array of that size (length)."""
        self._size = size
        self._known = np.zeros((0, 3))
        self._surfaces: list[Surface] = []

    def side(self, normal: Floats, offset: float) -> Side:
        """The line ``normal . c = offset`` and the side on which ``normal . c < offset``."""
        length = norm(normal)
        row = np.array([*normal / length, offset / length / self._size])
        for sign in (-1, 1):
            same = np.flatnonzero(np.abs(self._known + sign * row).max(axis=1, initial=0.0) <= SAME_LINE)
            if len(same):
                return self._surfaces[int(same[0])], sign
        surface = affine_surface("line", (row[0], row[1], 0.0), offset / length)
        self._known = np.vstack([self._known, row])
        self._surfaces.append(surface)
        return surface, -1


@dataclass(frozen=True, eq=False)
class SetCell:
    """One cell of one set.

    Attributes:
        number: its place among the cells of its set.
        name: what it is called among them.
        member: its motion, under a name among all cells of all sets.
        twist: ``(v_x, v_y, omega)``.
        sides: what bounds it.
        tied: whether several motions tie in it; the first is drawn.
    """

    number: int
    name: str
    member: Member
    twist: tuple[float, float, float]
    sides: tuple[Side, ...]
    tied: bool


class SetCells:
    """The cells on one set of wheels.

    Attributes:
        wheels: their numbers.
        borders: the sides of the wheels' hull, on the inside of which the body stands; none where it never does.
        cells: all of them.
    """

    def __init__(self, scene: Scene, rule: CellRule, lines: Lines) -> None:
        """For the wheels of a scene.

        Raises:
            RefusalError: where the motion on these wheels is not determined.
        """
        self.wheels = scene.numbers
        self._scene, self._rule, self._lines = scene, rule, lines
        hull = support_polygon(scene.positions)
        sides = around(hull) if len(hull) > 2 else ()
        self.borders = tuple(
            lines.side(np.array([float(b[1] - a[1]), float(a[0] - b[0])]), float(cross(a, b))) for a, b in sides
        )

    @cached_property
    def cells(self) -> tuple[SetCell, ...]:
        """Built where the body first stands on these wheels.

        Raises:
            RefusalError: where the motion on these wheels is not determined.
        """
        field = array_field(self._rule.build_standing_partition(self._scene), Kinematics.EXACT)
        found = []
        for k, polygon in enumerate(field.cells.polygons):
            name = f"{field.names[k]} of wheels {numbers_text(self.wheels)}"
            sides = tuple(self._lines.side(np.array(side.normal), float(side.offset)) for side in polygon.sides)
            flow, member = field.flows[k][0], Member(name, field.velocity(k))
            twist = (float(flow.vx), float(flow.vy), float(flow.omega))
            found.append(SetCell(k, field.names[k], member, twist, sides, field.tied(k)))
        return tuple(found)

    def stands(self, pose: Floats, slack: float) -> bool:
        """Whether the centre of mass is inside the hull of the wheels, or within the slack of it."""
        return bool(self.borders) and all(sign * line.value(pose) >= -slack for line, sign in self.borders)

    def holding(self, pose: Floats, slack: float) -> list[SetCell]:
        """The cells whose closure holds a place."""
        return [cell for cell in self.cells if all(sign * line.value(pose) >= -slack for line, sign in cell.sides)]


class CellsBySet:
    """The cells by set of carrying wheels; along a path few sets are met, each many times."""

    def __init__(self, scene: Scene, rule: CellRule) -> None:
        """For an array with all its wheels."""
        if not rule.needs_loads:
            scene = replace(scene, contact=replace(scene.contact, loads=None))
        self._scene, self._rule = scene, rule
        places = places_of(scene.wheels)
        self.size = max_norm(places)
        self._lines = Lines(self.size)
        self._known: dict[frozenset[int], SetCells] = {}

    def of(self, wheels: frozenset[int]) -> SetCells:
        """The cells of the wheels at these places in the scene's list."""
        if wheels not in self._known:
            chosen = [self._scene.wheels[k] for k in sorted(wheels)]
            self._known[wheels] = SetCells(with_only(self._scene, chosen), self._rule, self._lines)
        return self._known[wheels]


def agrees(sides: tuple[Side, ...], pattern: Mapping[Surface, int]) -> bool:
    """Whether a pattern of signs of the lines through a place lies on the inner side of all of them it names."""
    return all(pattern.get(line, sign) == sign for line, sign in sides)


# ---- the field -----------------------------------------------------------------------------------


Wheels = frozenset[int]  # places in the scene's list of wheels
Pattern = tuple[int, ...]  # -1, 0 or 1 for each surface through a pose

MOST_AT_ONCE = 16  # surfaces through one pose


@dataclass(frozen=True)
class _Cell:
    """A cell of poses: wheels under the body, and one of their cells."""

    wheels: Wheels
    cell: SetCell


@dataclass
class _PoseNeighbourhood:
    """What lies around a pose: its faces, and whether the body may tip there."""

    faces: list[Face]
    border: bool


class OutlineField:
    """The field that :func:`nonsmooth.analysis.trajectories.trajectory.follow_smooth` follows.

    Attributes:
        states, kinematics, unit, heading, size: see :class:`nonsmooth.analysis.fields.switched_field.FacedField`.
        wheels_of: the wheels under the body by the name of a member.
    """

    states: tuple[str, ...] = ("x", "y", "theta")
    kinematics: str = Kinematics.EXACT.value
    heading: int | None = 2

    def __init__(self, sets: CellsBySet, outline: MovingOutline, names: Sequence[str], unit: float) -> None:
        """For an array and a body; ``names`` are those of the wheels, and the unit of length is that of a scene's."""
        self.unit = unit
        self._sets, self._outline, self._names = sets, outline, names
        self.size = sets.size + outline.size
        self._slack = SURFACE_SLACK * self.size
        self._edges = [self._edge(k) for k in range(outline.count)]
        self._depths: tuple[bytes, Floats] = (b"", np.zeros(0))
        self._known: dict[object, _PoseNeighbourhood] = {}
        self._of_lines: dict[tuple[int, ...], tuple[Pattern, ...]] = {}
        self._tied: set[str] = set()
        self.wheels_of: dict[str, Wheels] = {}

    @property
    def tied_members(self) -> frozenset[str]:
        """Members met so far in whose cells several motions tie."""
        return frozenset(self._tied)

    def faces_at(self, x: Floats) -> list[Face]:
        """Every face whose closure holds a pose, those that hold most surfaces first; none where the body tips.

        Raises:
            TrajectoryError: where too many surfaces meet.
        """
        return self._around(x).faces

    def has_contact(self, x: Floats) -> bool:
        """Edges over two wheels do not touch, but for wheels at equal places."""
        return False

    def on_border(self, x: Floats) -> bool:
        """Whether the body tips at a pose, or just beside it."""
        return self._around(x).border

    def under(self, x: Floats) -> Wheels:
        """The wheels strictly under the body, beyond the slack of its edge."""
        return frozenset(int(k) for k in np.flatnonzero(self._depths_at(x) > self._slack))

    # ---- faces -----------------------------------------------------------------------------------

    def _around(self, x: Floats) -> _PoseNeighbourhood:
        depths = self._depths_at(x)
        edge = [int(k) for k in np.flatnonzero(np.abs(depths) <= self._slack)]
        place = _Place(self.under(x), tuple(edge))
        for wheels in subsets_of(place.edge):
            self._add_set(place, wheels, x)
        surfaces = [*(self._edges[k] for k in edge), *place.lines]
        if len(surfaces) > MOST_AT_ONCE:
            raise TrajectoryError(
                f"required at most {MOST_AT_ONCE} edges and borders of cells at one pose, received {len(surfaces)}"
            )
        patterns = self._patterns_at(surfaces, x)
        cells = tuple((wheels, tuple(id(cell) for cell in found)) for wheels, found in place.holding.items())
        key = place.inside, place.edge, cells, tuple(map(id, surfaces)), patterns
        if key not in self._known:
            self._known[key] = self._build(place, surfaces, patterns)
        return self._known[key]

    def _patterns_at(self, surfaces: Sequence[Surface], x: Floats) -> tuple[Pattern, ...]:
        """Patterns of signs that have poses; those of lines alone are the same at every pose."""
        key = tuple(map(id, surfaces)) if all(surface.flat for surface in surfaces) else None
        if key is None:
            return sign_patterns([surface.normal(x) for surface in surfaces])
        if key not in self._of_lines:
            self._of_lines[key] = sign_patterns([surface.normal(x) for surface in surfaces])
        return self._of_lines[key]

    def _add_set(self, place: _Place, wheels: Wheels, x: Floats) -> None:
        """The cells at a pose on the wheels inside and some of those under the edge, and the lines through it."""
        chosen = place.inside | wheels
        if len(chosen) < 3:
            return
        cells = self._sets.of(chosen)
        if not cells.stands(x, self._slack):
            return
        place.holding[wheels] = cells.holding(x, self._slack)
        for line, _ in (*cells.borders, *(side for cell in place.holding[wheels] for side in cell.sides)):
            if abs(line.value(x)) <= self._slack and line not in place.lines:
                place.lines.append(line)

    def _build(self, place: _Place, surfaces: Sequence[Surface], patterns: Sequence[Pattern]) -> _PoseNeighbourhood:
        """The faces of the patterns that have poses."""
        full = {p: self._cells(place, surfaces, p) for p in patterns if 0 not in p}
        faces: dict[object, Face] = {}
        for pattern in patterns:
            around = [full[p] for p in full if _refines(p, pattern)]
            if not any(around) or None in around or not _divides(pattern, full):
                continue
            members = {cell for cells in around for cell in cells or ()}
            face = self._face(surfaces, pattern, sorted(members, key=lambda one: (sorted(one.wheels), one.cell.number)))
            faces.setdefault((face.keep, face.members, frozenset(face.bounds)), face)
        return _PoseNeighbourhood(list(faces.values()), None in full.values())

    def _cells(self, place: _Place, surfaces: Sequence[Surface], pattern: Pattern) -> tuple[_Cell, ...] | None:
        """The cell on the sides of a full pattern, none where it is too small; None where the body tips."""
        signs = dict(zip(surfaces, pattern, strict=True))
        wheels = frozenset(k for k in place.edge if signs[self._edges[k]] > 0)
        chosen = place.inside | wheels
        if wheels not in place.holding or not agrees(self._sets.of(chosen).borders, signs):
            return None
        found = (cell for cell in place.holding[wheels] if agrees(cell.sides, signs))
        return tuple(_Cell(chosen, cell) for cell in islice(found, 1))

    def _face(self, surfaces: Sequence[Surface], pattern: Pattern, cells: Sequence[_Cell]) -> Face:
        keep = tuple(surface for surface, side in zip(surfaces, pattern, strict=True) if not side)
        for one in cells:
            self.wheels_of[one.cell.member.name] = one.wheels
            if one.cell.tied:
                self._tied.add(one.cell.member.name)
        bounds = tuple(side for side in self._bounds(cells) if side[0] not in keep)
        return Face(self._name(keep, cells), keep, bounds, tuple(one.cell.member for one in cells))

    def _name(self, keep: Sequence[Surface], cells: Sequence[_Cell]) -> str:
        """The wheels that stay under the edge, and the cells between which c stays."""
        held = [f"wheel {self._names[k]} under the edge" for k, edge in enumerate(self._edges) if edge in keep]
        if held and len(held) == len(keep):
            return ", ".join(held)
        by_wheels: dict[Wheels, list[str]] = {}
        for one in cells:
            by_wheels.setdefault(one.wheels, []).append(one.cell.name)
        names = (f"{' | '.join(cells)} of wheels {self._text(wheels)}" for wheels, cells in by_wheels.items())
        return ", ".join([*held, *names])

    def _text(self, wheels: Wheels) -> str:
        return ", ".join(self._names[k] for k in sorted(wheels))

    def _bounds(self, cells: Sequence[_Cell]) -> Iterator[Side]:
        """The sides of all cells of a face, the hulls of their wheels, and the edge over every wheel."""
        lines = [side for one in cells for side in (*one.cell.sides, *self._sets.of(one.wheels).borders)]
        yield from dict.fromkeys(lines)
        for k, edge in enumerate(self._edges):
            yield edge, 1 if k in cells[0].wheels else -1

    # ---- edges -----------------------------------------------------------------------------------

    def _depths_at(self, x: Floats) -> Floats:
        """All depths at a pose; those of the last pose are kept, as every edge asks for them."""
        key = x.tobytes()
        if self._depths[0] != key:
            self._depths = key, self._outline.depths(x)
        return self._depths[1]

    def _edge(self, wheel: int) -> Surface:
        """The poses at which a wheel lies under the edge of the body; positive where it carries."""

        def value(x: Floats) -> float:
            return float(self._depths_at(x)[wheel])

        return Surface(f"wheel {self._names[wheel]}", value, lambda x: self._outline.gradient(x, wheel))


@dataclass
class _Place:
    """A pose: the wheels well under the body and under its edge, the cells it lies in, the lines through it.

    Attributes:
        inside: well under the body.
        edge: under the edge.
        holding: by the wheels of the edge that carry too, where the body stands.
        lines: borders of cells, and of hulls.
    """

    inside: Wheels
    edge: tuple[int, ...]
    holding: dict[Wheels, list[SetCell]] = field(default_factory=dict)
    lines: list[Surface] = field(default_factory=list)


def _refines(full: Pattern, pattern: Pattern) -> bool:
    return all(side in (0, sign) for sign, side in zip(full, pattern, strict=True))


def _divides(pattern: Pattern, full: Mapping[Pattern, tuple[_Cell, ...] | None]) -> bool:
    """Whether the cells on both sides of every surface that a pattern holds differ."""
    for k in (k for k, side in enumerate(pattern) if not side):
        sides = [{full[p] for p in full if _refines(p, pattern) and p[k] == sign} for sign in (-1, 1)]
        if sides[0] == sides[1]:
            return False
    return True


# ---- paths of the field --------------------------------------------------------------------------
#
# It is a solution of the switched field of poses above, and is followed as every other one
# (:mod:`nonsmooth.analysis.trajectories.smooth_path`): through the cells of the wheels that carry,
# along borders of cells and along edges over wheels, where Filippov's construction mixes motions.  Here its switches
# are told apart: wheels that ``enter`` and ``leave``, wheels under the edge that the body slides along (``slide``), and
# where it ``tips``.  All is counted in the scene's length l, so that a path is the same in every unit of length.


class CellPath:
    """Follows one body."""

    def __init__(self, scene: Scene, rule: CellRule) -> None:
        """For a scene with a body, all its wheels in ``scene.wheels``.

        Raises:
            ValueError: for a scene without a body.
            SceneError: for loads that are known for one set of wheels only, under a rule that needs them.
        """
        if scene.body is None:
            raise ValueError("required a scene with a body")
        if rule.needs_loads:
            require_springs(scene)
        self._length = float(scene.check.length)
        self._scene = scaled = counted_in_own_length(scene)
        names = [str(wheel.index) for wheel in scaled.wheels]
        places = places_of(scaled.wheels)
        outline = MovingOutline(scaled.body or scene.body, places)
        self._field = OutlineField(CellsBySet(scaled, rule), outline, names, self._length)

    def stands(self, pose: Sequence[float]) -> bool:
        """Whether the body stands at a pose ``(x, y, theta)``."""
        return bool(self._field.faces_at(self._own(pose)))

    def follow(self, start: Sequence[float], until: float) -> Trajectory:
        """The path from ``(x, y, theta)``, theta measured from the checked heading.

        Raises:
            ValueError: for a last time that is not positive, numbers that are not finite, and a start where the body
                tips.
            RefusalError: where the motion is not determined.
            TrajectoryError: where the path cannot be followed.
        """
        pose = finite_start(start, until)
        if not self.stands(start):
            raise tipped_start(self._scene, self._field.under(self._own(pose)), self._own(pose))
        path = _OnWheels(self._field, self._scene).path(self._own(pose).tolist(), until, near_rounding(self._field))
        return path.in_lengths(self._length)

    def _own(self, pose: Sequence[float] | Floats) -> Floats:
        """A pose with the scene's length l for the unit."""
        return np.array(pose, float) / [self._length, self._length, 1.0]


class _OnWheels(FilippovFaces):
    """The solutions of the field, with the wheels that come and go told apart from other switches."""

    keeps_beginnings = True

    def __init__(self, field: OutlineField, scene: Scene) -> None:
        super().__init__(field, None, WorkMeter(MAX_WORK), MAX_EVENTS)
        self._outlined, self._scene = field, scene

    def next_mode(self, path: Path) -> Mode | EndReason:
        """The next face; beyond the border of the field the body tips."""
        mode = super().next_mode(path)
        if mode is not EndReason.OUTSIDE:
            return mode
        path.tell(EventKind.TIPS, tipping_edge(self._scene, self._outlined.under(path.state), path.state))
        return EndReason.TIPS

    def tell_switch(self, path: Path, choice: FaceChoice, weights: Weights) -> None:
        """Where wheels come or go, one event for each kind of change."""
        face, before = choice.motion.face, self.before
        told = False
        if before is not None:
            for kind, words in wheel_changes(self._scene, self._wheels(before), self._wheels(face)):
                mixed = {"weights": weights, "rates": choice.rates} if face.keep else {}
                path.tell(kind, words, **mixed)
                told = True
        if not told:
            super().tell_switch(path, choice, weights)

    def _wheels(self, face: Face) -> CarryingWheels:
        """The wheels that carry in all cells of a face, and those that carry in some."""
        sets = [self._outlined.wheels_of[member.name] for member in face.members]
        carrying = frozenset.intersection(*sets)
        return CarryingWheels(carrying, tuple(sorted(frozenset.union(*sets) - carrying)))
