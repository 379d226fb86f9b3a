"""Loops for engines that know open trees.

From an engine come its kinematics, its open-tree inverse dynamics and its Jacobians. The balance of the closed
mechanism is then linear in the drives and in the forces at the points where loops are closed:

    open tree(q, v, a) = loads + springs + friction + drives + closures

There is a row for each freedom of the tree, no fewer than unknowns unless constraints are redundant, and the solution
has to satisfy all of them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from engines.tree import Closure, TreeEngine
from mechanism import Joint, Mechanism, Pose
from pairs import Pair, closure_gap, closure_pairs
from solution import Solution
from spatial import Array, moved_wrench, rotation_vector
from springs import spring_wrenches
from tables import Sample


@dataclass(frozen=True)
class State:
    """An engine at an instant: coordinates, velocities and accelerations; poses and Jacobians of its bodies.

    `place` and `motion` say how well it reproduces the motion, see `Solution`.
    """

    q: Array
    v: Array
    a: Array
    poses: dict[str, Pose]
    jacobians: dict[str, Array]
    place: float
    motion: float

    def generalised(self, loads: dict[str, Array]) -> Array:
        """Of loads about the origins of bodies."""
        return sum((self.jacobians[body].T @ wrench for body, wrench in loads.items()), np.zeros_like(self.v))


class ClosedLoop:
    """An engine with a mechanism whose loops are closed here.

    The exported file may hold a body in several parts, welded together by equalities, where a joint closes a loop:
    `B@J` is the part of the body B that hangs by the joint J. Each part moves as its body does.
    """

    def __init__(self, engine: TreeEngine, mechanism: Mechanism) -> None:
        self.engine = engine
        self.mechanism = mechanism
        self.q = engine.neutral()
        #: our body for each of the engine's
        self.owner = {name: name.split("@")[0] for name in engine.parents}
        joints = [joint for joint in mechanism.joints.values() if joint.kind != "free"]
        #: the engine's body that hangs by a joint of its tree; all other joints are cut
        self.child = {j.name: child for j in joints if (child := tree_child(j, engine.parents, engine.closures))}
        self.cut = {joint.name for joint in joints} - set(self.child)
        #: joints of which the engine says no reaction
        self.silent = {name for name, child in self.child.items() if child in engine.merged}
        closed = {closure.joint for closure in engine.closures}
        lost = (self.cut - closed) | (closed - set(mechanism.joints))
        lost |= set(mechanism.bodies) - set(self.owner.values())
        if lost:
            raise RuntimeError(f"{engine.name} has not what the mechanism has: {lost}")

    def solve(self, sample: Sample, friction: dict[str, Array]) -> Solution:
        """`friction` has for each joint the efforts on its freedoms, in their order."""
        engine, mechanism = self.engine, self.mechanism
        state = self.reproduce(sample)
        efforts = {name: [*friction.get(name, [0.0] * len(j.freedoms))] for name, j in mechanism.joints.items()}
        pairs = {name: self.freedom_pairs(joint, state.poses) for name, joint in mechanism.joints.items()}

        needed = engine.inverse_dynamics(state.q, state.v, state.a)
        size = float(np.max(np.abs(needed)))
        loads = self.loads(sample)
        own_springs = engine.springs(state.q, state.v)
        if own_springs is None:
            for body, wrench in spring_wrenches(mechanism, sample).items():
                loads[body] += wrench
        else:
            needed = needed - own_springs
        needed = needed - state.generalised(loads)
        for name, values in efforts.items():
            for pair, effort in zip(pairs[name], values):
                needed = needed - effort * pair.column(state.poses, state.jacobians)
        size = max(size, float(np.max(np.abs(needed)))) or 1.0

        driven = [self.drive_column(joint, k, pairs[joint.name][k], state) for joint, k in mechanism.actuated()]
        closing = [pair for closure in engine.closures for pair in closure_pairs(closure, state.poses)]
        columns = np.array([*driven, *(pair.column(state.poses, state.jacobians) for pair in closing)]).T
        # Columns of forces and moments differ by lengths; unit columns make their ranks comparable.
        norms = np.linalg.norm(columns, axis=0)
        norms[norms == 0.0] = 1.0
        unknowns = np.linalg.lstsq(columns / norms, needed, rcond=1e-11)[0] / norms
        balance = float(np.max(np.abs(columns @ unknowns - needed))) / size
        drives, forces = unknowns[: len(driven)], unknowns[len(driven) :]

        for (joint, k), drive in zip(mechanism.actuated(), drives):
            efforts[joint.name][k] += drive
        reactions = self.reactions(state, loads, pairs, efforts, list(zip(closing, forces)))
        return Solution(drives, reactions, state.place, state.motion, balance)

    def reproduce(self, sample: Sample) -> State:
        """Coordinates, velocities and accelerations of the engine from those of all bodies."""
        error = self.place(sample)
        poses, jacobians = self.engine.kinematics(self.q)
        v, slip = self.rates(jacobians, {name: sample.motions[body] for name, body in self.owner.items()})
        bias = self.engine.bias(self.q, v)
        a, lag = self.rates(
            jacobians, {name: sample.accelerations[body] - bias[name] for name, body in self.owner.items()}
        )
        gap = max((closure_gap(closure, poses) for closure in self.engine.closures), default=0.0)
        return State(self.q, v, a, poses, jacobians, max(error, gap), max(slip, lag))

    def place(self, sample: Sample) -> float:
        """Finds the engine's coordinates from the poses of all bodies, by Newton's method; the error in m."""
        length = self.mechanism.length
        error = np.inf
        for _ in range(40):
            poses, jacobians = self.engine.kinematics(self.q)
            rows, residuals = [], []
            for name, body in self.owner.items():
                target, now = sample.poses[body], poses[name]
                residuals += [
                    target.position - now.position,
                    length * rotation_vector(target.rotation @ now.rotation.T),
                ]
                rows += [jacobians[name][:3], length * jacobians[name][3:]]
            residual = np.concatenate(residuals)
            before, error = error, float(np.max(np.abs(residual)))
            # Quadratic convergence ends in rounding: stop when a step no longer helps.
            if error < 1e-15 or (error < 1e-9 and error > 0.5 * before):
                break
            self.q = self.engine.integrate(self.q, np.linalg.lstsq(np.vstack(rows), residual, rcond=None)[0])
        return error

    def rates(self, jacobians: dict[str, Array], motions: dict[str, Array]) -> tuple[Array, float]:
        """Velocities (or accelerations) of the engine's coordinates from those of its bodies, and what is left."""
        weights = np.repeat([1.0, self.mechanism.length], 3)
        matrix = np.vstack([weights[:, None] * jacobians[name] for name in self.owner])
        target = np.concatenate([weights * motions[name] for name in self.owner])
        rates = np.linalg.lstsq(matrix, target, rcond=None)[0]
        # At rest there is nothing to be relative to: 0.1 m/s, or a hundredth of gravity, stands in.
        size = max(float(np.max(np.abs(target))), 0.1)
        return rates, float(np.max(np.abs(matrix @ rates - target))) / size

    def loads(self, sample: Sample) -> dict[str, Array]:
        """Loads on the engine's bodies: of a body in parts all is on its first, which has the body's name."""
        return {
            name: sample.loads[body].copy() if name == body else np.zeros(6) for name, body in self.owner.items()
        }

    def freedom_pairs(self, joint: Joint, poses: dict[str, Pose]) -> list[Pair]:
        """Unit efforts on the freedoms as wrenches on `to` and `from`, or on the part that hangs by the joint."""
        ends = {joint.successor: joint.successor, joint.predecessor: joint.predecessor}
        if joint.name in self.child:
            child = self.child[joint.name]
            ends[self.owner[child]] = child
        origin = joint.frames(poses)[0].position
        return [
            Pair(joint.name, ends[joint.successor], ends[joint.predecessor], effort, origin)
            for effort in joint.efforts(poses).T
        ]

    def drive_column(self, joint: Joint, k: int, pair: Pair, state: State) -> Array:
        """Generalised forces of a unit drive: by the engine's own actuator, if it reads those of the file."""
        own = self.engine.drive(state.q, (f"{joint.name}.{joint.freedoms[k].name}", joint.name))
        return own if own is not None else pair.column(state.poses, state.jacobians)

    def reactions(
        self,
        state: State,
        loads: dict[str, Array],
        pairs: dict[str, list[Pair]],
        efforts: dict[str, list[float]],
        closing: list[tuple[Pair, float]],
    ) -> dict[str, Array]:
        """The engine's reactions in the tree under all forces, and the forces at the cuts.

        Of efforts of drives and friction, those at cuts are loads for the engine.
        """
        loads = {name: wrench.copy() for name, wrench in loads.items()}
        tau = np.zeros(self.engine.nv)
        at_cut = {name: np.zeros(6) for name in self.cut}
        acting = list(closing)
        for name, joint_pairs in pairs.items():
            for pair, effort in zip(joint_pairs, efforts[name]):
                if name in self.cut:
                    acting.append((pair, effort))
                else:
                    tau += effort * pair.column(state.poses, state.jacobians)
        for pair, size in acting:
            pair.add_to(loads, size, state.poses)
            if pair.joint in self.cut:  # else it holds the parts of a body together
                joint = self.mechanism.joints[pair.joint]
                sign = 1.0 if self.owner[pair.on] == joint.successor else -1.0
                at_cut[joint.name] += sign * size * pair.about(joint.frames(state.poses)[0].position)
        in_tree = self.engine.reactions(state.q, state.v, state.a, tau, loads)
        result = dict(at_cut)
        for name, child in self.child.items():
            if child in in_tree:
                joint = self.mechanism.joints[name]
                lever = state.poses[child].position - joint.frames(state.poses)[0].position
                sign = 1.0 if self.owner[child] == joint.successor else -1.0
                result[name] = sign * moved_wrench(in_tree[child], lever)
        return result


def tree_child(joint: Joint, parents: dict[str, str], closures: list[Closure]) -> str | None:
    """The body, or part of a body, that hangs by a joint in the exported tree; none if the joint is cut."""
    ends = ((joint.successor, joint.predecessor), (joint.predecessor, joint.successor))
    for child, parent in ends:
        if parents.get(f"{child}@{joint.name}") == parent:
            return f"{child}@{joint.name}"
    if joint.name in {closure.joint for closure in closures}:
        return None
    return next((child for child, parent in ends if parents.get(child) == parent), None)
