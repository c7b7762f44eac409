"""Theorem 4 of Murphey and Burdick for one array: what its clauses say of the checked point, and what each rests on.

The cells, the velocities at the point, the fan of cones and all signs are derived from the wheels and looked at here.
Evidence are the weights of a mixture at rest, or a separating direction; barriers of the disc; and what shows that
feedback serves, or that none does.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import combinations
from typing import Any

from .contact import Cell, Cells, Motion
from .fan import Cone, Fan
from .plane import convex_hull, holds_disc
from .positivity import Proofs
from .theorems import ASYMPTOTICALLY_STABLE, STABLE, UNSTABLE, Statement
from .tower import Number, Vector, dot, has_rank_three, is_zero, negative, normal_to, signs
from .wheels import BOX, Array, edge_slopes, friction_limits
from .work import items, require, take

CLAUSES = ("equilibrium", "translation", "rotation", "feedback", "theorem 4")  # kinds of claims
HOLDS, FAILS, HYPOTHESES_NOT_MET = "holds", "fails", "hypotheses not met"
NEUTRAL = "stable, not attractive"
STABILIZABLE, NO_CERTIFICATE, NOT_APPLICABLE = "stabilizable", "no certificate", "not applicable"


def show_theorem4(array: Array, hypotheses: Any, proofs: Proofs) -> list[Statement]:
    """The clauses that are decided, and the conclusion.

    The theorem says of an equilibrium: (x, y) is stable, theta unstable, and both are stabilized by feedback.  So a
    clause that shows the opposite refutes it, one left open leaves it open, and where the point is no equilibrium its
    hypotheses are not met.
    """
    points, cells, disc, rate = take(hypotheses, "points cells disc", "rate")
    own = Clauses(array, Cells(array, points, cells), proofs)
    equilibrium = own.show_equilibrium()
    translation = own.show_translation()
    rotation = own.show_rotation(translation)
    feedback, plane = own.show_feedback()
    words = {"translation": translation, "rotation": rotation, "feedback": feedback}
    shown: list[Statement] = [{"equilibrium": equilibrium}]
    shown += [{clause: word} for clause, word in words.items() if word is not None]
    if plane is not None:
        shown.append({"obstruction": plane})
    if disc is not None:
        shown.append({"disc": {"squared_radius": disc, "decreases": own.show_disc(array.field.parse(disc))}})
    if rate is not None:
        require(disc is not None, "a disc of starts that arrive")
        own.show_arrival(array.field.parse(rate))
        shown.append({"arrival": {"squared_radius": disc, "rate": rate}})
    if not equilibrium:
        shown.append({"theorem 4": HYPOTHESES_NOT_MET})
    elif translation == UNSTABLE or rotation == NEUTRAL or plane is not None:
        shown.append({"theorem 4": FAILS})
    elif not {None, NO_CERTIFICATE} & set(words.values()):
        shown.append({"theorem 4": HOLDS})
    return shown


class Clauses:
    """One array with its cells; each method is a claim that it shows, or leaves open with None."""

    def __init__(self, array: Array, cells: Cells, proofs: Proofs) -> None:
        self.array, self.cells, self.proofs = array, cells, proofs
        self.zero, self.one = array.field.constant(0), array.field.constant(1)
        self.here = cells.here
        self.highest = max(max(motion.rates) for motion in self.here)
        self.drift: list[int] | None = None
        self.fan = self._fan(lambda motion: motion.twist) if self.highest >= 0 else ASYMPTOTICALLY_STABLE

    def _fan(self, velocity: Callable[[Motion], Vector]) -> str | None:
        """What the fan of cones at the point says where each motion there moves the body with a velocity."""
        cones = [
            Cone(*cell.rays, tuple(map(velocity, cell.motions))) for cell in self.cells.listed if cell.rays is not None
        ]
        return Fan(cones, self.cells.points).verdict()

    # ---- clause 1

    def show_equilibrium(self) -> bool:
        """The claim: 0 lies in F(c*), the convex hull of the velocities at the checked point; or it does not.

        Convex weights of velocities that cancel show the first (:meth:`_end_of_drift`).  A direction along which every
        velocity has a positive part shows the second: then so has every convex combination.
        """
        separator = self.proofs.evidence_if_any("separator")
        if separator is None:
            self.drift = [self._end_of_drift(side, name) for side, name in ((-1, "lowest"), (1, "highest"))]
            return True
        direction = self.array.field.vector(separator, 2)
        sound = all(dot(direction, motion.twist).sign() > 0 for motion in self.here)
        require(sound, "a direction in which all velocities at the point lead")
        return False

    def _end_of_drift(self, side: int, name: str) -> int:
        """The claim: one end of the range of omega over the members of F(c*) with zero velocity; here its sign.

        The weights (not negative, not all zero) mix the velocities to zero, and omega to an end ``w``.  Multipliers
        ``(a, b, t, q)``, q > 0, with ``a vx + b vy - side q omega + t >= 0`` at every twist show that no mixture with
        zero velocity passes ``side omega = t/q``, and the mixture attains it.
        """
        weights, multipliers = take(self.proofs.evidence(name), "weights multipliers")
        a, b, shift, scale = self.array.field.vector(multipliers, 4)
        shares = self.array.field.vector(weights, len(self.here))
        twists = [motion.twist for motion in self.here]
        x, y, omega, whole = (dot(shares, [twist[k] for twist in twists]) for k in range(4))
        outward = omega if side > 0 else -omega
        attained = is_zero((x, y, shift * whole - scale * outward))
        form = (a, b, -scale if side > 0 else scale, shift)
        above = [dot(form, twist) for twist in twists]
        convex = min(signs([*shares, *above])) >= 0 and min(signs((whole, scale))) > 0
        require(attained and convex, f"weights and multipliers of the {name} rate at rest")
        return omega.sign()

    # ---- clause 2

    def show_translation(self) -> str | None:
        """The claim: the point is (asymptotically) stable or unstable in (x, y).

        ``V = |c|^2`` changes by ``V* = 2 c . v``, linear on each closed cell, so its sign at the corners of the cells
        at the point is that near the point.  Negative: asymptotically stable.  Not positive: stable (Lyapunov for
        differential inclusions), and asymptotically where the fan of cones shows that all paths come home.  Positive
        somewhere: V shows nothing and the fan decides alone.
        """
        if self.highest > 0:
            return self.fan
        require(self.fan != UNSTABLE, "a fan of cones that agrees with V*")
        return self.fan if self.fan == ASYMPTOTICALLY_STABLE else STABLE

    def show_disc(self, squared_radius: Number) -> str:
        """The claim: V* keeps its sign on a disc about the point, on which the body does not tip; here its sign.

        The disc lies in the square and in the support polygon, the convex hull of all wheels.  Cells away from the
        point where V* grows have their growing part outside the disc: a barrier ``(m, t)``, t >= 0, with
        ``m . c >= 1`` at all corners shows ``(m + t v) . c >= 1`` wherever ``v . c >= 0`` in the cell, so there
        ``|c| >= 1/|m + t v|``, which is at least the radius of the disc.
        """
        radius = self.array.radius
        inside = squared_radius.sign() > 0 and (radius * radius - squared_radius).sign() >= 0
        require(inside and self.highest <= 0, "a disc in the square where V* shows one")
        hull = convex_hull([wheel.place[:2] for wheel in self.array.wheels.values()])
        require(holds_disc(hull, squared_radius), "a disc in the support polygon")
        for k, cell in enumerate(self.cells.listed):
            for j, motion in enumerate(cell.motions):
                if cell.rays is None and max(motion.rates) > self.highest:
                    self._show_barrier(f"barrier {k} {j}", cell, motion.twist, squared_radius)
        return "strictly" if self.highest < 0 else "weakly"

    def show_arrival(self, rate: Number) -> None:
        """The claim: ``|c|`` falls at least at a rate in the square: a start in the disc is home within ``|c0|/rate``.

        ``c . v + rate |c|`` is convex on a closed cell: not positive at its corners, it is so in all of it.
        """
        require(rate.sign() > 0, "a positive rate")
        margins = []
        for cell in self.cells.listed:
            for x, y, _ in cell.corners:
                for motion in cell.motions:
                    inward = -dot((x, y), motion.twist)
                    margins += [inward, inward * inward - rate * rate * (x * x + y * y)]
        require(min(signs(margins)) >= 0, "a rate at which the distance falls in the square")

    def _show_barrier(self, name: str, cell: Cell, v: Vector, squared_radius: Number) -> None:
        a, b, t = self.array.field.vector(self.proofs.evidence(name), 3)
        margins = [t, *(dot((a, b, -self.one), corner) for corner in cell.corners)]
        n = (a + t * v[0], b + t * v[1])
        margins.append(self.one - squared_radius * dot(n, n))
        require(min(signs(margins)) >= 0, f"the {name}")

    # ---- clause 3

    def show_rotation(self, translation: str | None) -> str | None:
        """The claim: theta is unstable, or stable and not attractive (it never attracts: no twist depends on it).

        Unstable: the drift holds a rate other than zero, so the body may stay at the point and turn for ever.  With a
        drift of {0} theta is stable where the rotation along a path tends to zero with the distance of its start:
        ``|omega| <= K |v|`` on the polytope F(c*) (Hoffman 1952), so it is enough that paths near the point have
        lengths that do, as where all lead inward, or to rest without ties (tied motions might run to and fro).  It is
        also stable where the translation is and no motion at the point turns the body.
        """
        if self.drift is None:
            return None
        if any(self.drift):
            return UNSTABLE
        tied = any(len(cell.motions) > 1 for cell in self.cells.listed if cell.rays is not None)
        short = self.fan == ASYMPTOTICALLY_STABLE or (self.fan == STABLE and not tied)
        turning = any(motion.twist[2].sign() for motion in self.here)
        stable = translation in (ASYMPTOTICALLY_STABLE, STABLE)
        return NEUTRAL if short or (stable and not turning) else None

    # ---- clause 4

    def show_feedback(self) -> tuple[str | None, Any]:
        """The claim: some law brings pose and heading home; or no static law does, and why; or it does not apply.

        It speaks of wheels with less friction across the rim than along it: those whose rows act at the point under
        rule nearest, all of them under rule box.  Wheels with a friction axis are followed under rule box only, and
        only where nothing but the speed along the axis counts, and the drive can choose that: then the axis is the rim.
        """
        evidence = self.proofs.evidence_if_any("feedback")
        acting = {k for motion in self.here for _, k in motion.rows}
        wheels = [own for k, own in self.array.wheels.items() if self.array.rule == BOX or k in acting]
        if max((across - along).sign() for along, across in (own.friction for own in wheels)) >= 0:
            require(evidence is None, "no evidence of a clause that does not apply")
            return NOT_APPLICABLE, None
        drives = [own.drive for own in wheels if own.drive is not None]
        pairs = all(row[1] == motion.rows[0][1] for motion in self.here for row in motion.rows[:2])
        followed = all(drives) if self.array.rule == BOX else not drives and pairs
        if not followed or evidence is None:
            require(evidence is None, "feedback of wheels that are followed")
            return (NO_CERTIFICATE if followed and self.array.rule != BOX else None), None
        kinds = {"signs": self._show_signs, "twists": self._show_twists, "plane": self._show_plane}
        kind = next((name for name in kinds if name in evidence), "plane")
        (data,) = take(evidence, kind)
        kinds[kind](data)
        return (NO_CERTIFICATE, data) if kind == "plane" else (STABILIZABLE, None)

    def _show_plane(self, data: Any) -> None:
        """The claim: all motions that any speeds give near the point lie in one plane ``m . xi = 0``.

        Then no static feedback stabilizes (Brockett's condition).  Under rule nearest the motions are those of the
        control fields: along both rims where a roll row stands third, along the nearest one's where a side row does.
        Under rule box every imposed motion lies in the hull of twists along which no rim slips at the edges of the
        arrangement of side rows.
        """
        normal = self.array.field.vector(data, 3)
        require(not is_zero(normal), "a plane of all motions")
        for a, b in self._pairs_of_edges():
            twist = normal_to(a, b)
            off = dot(normal, twist).sign()
            held = not off or (self.array.rule == BOX and not self._is_imposed(twist, strictly=False))
            require(held, "a plane of all motions")

    def _pairs_of_edges(self) -> Iterator[tuple[Vector, Vector]]:
        rows = self.array.rows
        if self.array.rule != BOX:
            for motion in self.here:
                rolling, side, third = motion.rows
                yield rows[side], rows[third]
                if third[0] == "R":
                    yield rows[side], rows[rolling]
            return
        sides = [row[:3] for (kind, _), row in rows.items() if kind == "S"]
        axes = []
        if not has_rank_three(sides):
            axes = [tuple(self.one if j == k else self.zero for j in range(3)) for k in range(3)]
        yield from combinations([*sides, *axes], 2)

    def _show_twists(self, data: Any) -> None:
        """Rule box: three independent twists, each imposed as the only minimizer by speeds along the rims.

        Then so is any multiple of either sign, and ``-k (g . xi) xi``, g the state, with the largest ``|g . xi|`` of
        the three makes ``|g|^2`` fall.
        """
        require(self.array.rule == BOX, "signs of translations, under rule nearest")
        three = [self.array.field.vector(twist, 3) for twist in items(data, 3)]
        independent = dot(normal_to(three[0], three[1]), three[2]).sign() != 0
        imposed = independent and all(self._is_imposed(twist, strictly=True) for twist in three)
        require(imposed, "three independent twists that speeds impose")

    def _is_imposed(self, twist: Vector, *, strictly: bool) -> bool:
        """Whether a twist minimizes D at the point when all rims move with it, strictly or not."""
        rows = self.array.rows
        slips = {(kind, k): 0 if kind == "R" else dot(row[:3], twist).sign() for (kind, k), row in rows.items()}
        tight = [rows[row] for row, side in slips.items() if not side]
        if strictly:
            require(has_rank_three(tight), "tight rows of rank three")
        acting = self.cells.listed[self.here[0].cell].acting
        limits = friction_limits(self.array, acting, [(self.zero, self.zero, self.one)])
        least = 1 if strictly else 0
        return all(min(slopes) >= least for _, slopes in edge_slopes(rows, slips, limits))

    def _show_signs(self, data: Any) -> None:
        """Rule nearest: theta is brought home first; then the body moves along the nearest rims, ``+-|c| d_i``.

        That planar field is a fan of cones; if all its paths lead inward, so do those of the law.  If all rims are
        tangential, full turns of gain one serve too: turning the body to and fro then brings it home.  Without
        turning every crossing is of order one, so nothing else is left open by the fan.
        """
        require(self.array.rule != BOX, "three twists, under rule box")
        listed = items(data, len(self.here))
        require(all(type(s) is int and s in (1, -1) for s in listed), "a sign, 1 or -1, of each motion at the point")
        by_motion = dict(zip(map(id, self.here), listed, strict=True))

        def along(motion: Motion) -> Vector:
            rim = self.array.rows[motion.rows[0]]
            x, y, *_ = rim if by_motion[id(motion)] > 0 else negative(rim)
            return x, y, self.zero

        rolling = all(motion.rows[2][0] == "R" for motion in self.here)
        descent = self._fan(along)
        home = descent == ASYMPTOTICALLY_STABLE or (descent is None and self._has_tangential_rims())
        require(rolling and home, "signs of translations that all lead inward")

    def _has_tangential_rims(self) -> bool:
        nearest = {motion.rows[0] for motion in self.here}
        return is_zero(dot(self.array.rows[row][:2], self.array.wheels[row[1]].place) for row in nearest)
