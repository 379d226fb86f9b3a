"""Forces between two bodies: a wrench on one of them and its negative on the other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from engines.tree import Closure
from mechanism import Pose
from spatial import Array, moved_wrench, rotation_vector


@dataclass(frozen=True)
class Pair:
    """The `wrench` on the body `on` is about `origin`, world axes; `joint` is the joint that it belongs to."""

    joint: str
    on: str
    against: str
    wrench: Array
    origin: Array

    def about(self, point: Array) -> Array:
        """The wrench about another point."""
        return moved_wrench(self.wrench, self.origin - point)

    def column(self, poses: dict[str, Pose], jacobians: dict[str, Array]) -> Array:
        """Generalised forces, by the Jacobians of the bodies' origins."""
        on, against = (jacobians[body].T @ self.about(poses[body].position) for body in (self.on, self.against))
        return on - against

    def add_to(self, loads: dict[str, Array], size: float, poses: dict[str, Pose]) -> None:
        """Adds `size` times the pair to loads about the bodies' origins."""
        loads[self.on] += size * self.about(poses[self.on].position)
        loads[self.against] -= size * self.about(poses[self.against].position)


def closure_pairs(closure: Closure, poses: dict[str, Pose]) -> list[Pair]:
    """Unit forces (and moments of a weld) on body b at the closure's point, and back on body a."""
    point = poses[closure.body_b].point(closure.point_b)
    count = 3 if closure.rotation is None else 6
    return [Pair(closure.joint, closure.body_b, closure.body_a, unit, point) for unit in np.eye(6)[:count]]


def closure_gap(closure: Closure, poses: dict[str, Pose]) -> float:
    """How far apart the two points are that the closure holds together, m, or what a weld is turned, rad."""
    a, b = poses[closure.body_a], poses[closure.body_b]
    gap = float(np.linalg.norm(a.point(closure.point_a) - b.point(closure.point_b)))
    if closure.rotation is None:
        return gap
    return max(gap, float(np.linalg.norm(rotation_vector((a.rotation @ closure.rotation).T @ b.rotation))))
