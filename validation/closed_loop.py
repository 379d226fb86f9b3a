"""Loops for engines that know open trees.

From an engine come its kinematics, its open-tree inverse dynamics and its Jacobians. The balance of the closed
mechanism is then linear in the drives and in the forces at the points where loops are closed:

    open tree(q, v, a) = loads + springs + friction + drives + closures

The solution must satisfy *all* rows: there are as many as the tree has freedoms, and no less than unknowns unless
constraints are redundant.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from engines.tree import WORLD, Closure, TreeEngine
from mechanism import GROUND, Joint, Mechanism, Pose
from spatial import Array, motion_shift, moved_wrench, rotation_vector
from tables import Sample


@dataclass(frozen=True)
class Solution:
    """What an engine says about a sample.

    `drives` in the order of `Mechanism.actuated`; `reactions` of `from` on `to` about J, world axes. `pose` says how
    well the engine's own places of bodies and closures agree with the motion, m; `motion` the same for rates and
    accelerations, relative to the largest; `balance` what the engine's balance leaves, relative to its largest term.
    """

    drives: Array
    reactions: dict[str, Array]
    pose: float
    motion: float
    balance: float


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
        if set(mechanism.moving()) - set(self.owner.values()):
            raise RuntimeError(f"{engine.name} does not have all bodies")
        joints = [joint for joint in mechanism.joints.values() if joint.kind != "free"]
        #: the engine's body that hangs by a joint of its tree
        self.child = {joint.name: child for joint in joints if (child := tree_child(joint, engine.parents))}
        self.cut = {joint.name for joint in joints} - set(self.child)
        unknown = {closure.joint for closure in engine.closures} - set(mechanism.joints)
        open_loops = self.cut - {closure.joint for closure in engine.closures}
        if unknown or open_loops:
            raise RuntimeError(f"equalities without a joint: {unknown}; joints without an equality: {open_loops}")
        self.silent = {name for name, child in self.child.items() if child in engine.merged}

    def place(self, sample: Sample) -> float:
        """Finds the engine's coordinates from the poses of all bodies, by Newton's method; the error in m."""
        length = self.mechanism.length
        error = np.inf
        for _ in range(40):
            poses, jacobians = self.kinematics()
            rows, residuals = [], []
            for name, body in self.owner.items():
                target, now = sample.poses[body], poses[name]
                residuals.append(target.position - now.position)
                residuals.append(length * rotation_vector(target.rotation @ now.rotation.T))
                rows.append(jacobians[name][:3])
                rows.append(length * jacobians[name][3:])
            residual = np.concatenate(residuals)
            before, error = error, float(np.max(np.abs(residual)))
            # Quadratic convergence ends in rounding: stop when a step no longer helps.
            if error < 1e-15 or (error < 1e-9 and error > 0.5 * before):
                break
            self.q = self.engine.integrate(self.q, np.linalg.lstsq(np.vstack(rows), residual, rcond=None)[0])
        return error

    def kinematics(self) -> tuple[dict[str, Pose], dict[str, Array]]:
        """The engine's, with the world and the ground, which are no bodies to it."""
        poses, jacobians = self.engine.kinematics(self.q)
        poses[WORLD] = Pose(np.eye(3), np.zeros(3))
        poses.setdefault(GROUND, self.mechanism.bodies[GROUND].home)
        return poses, jacobians

    def rates(self, jacobians: dict[str, Array], motions: dict[str, Array]) -> tuple[Array, float]:
        """Velocities (or accelerations) of the engine's coordinates from those of its bodies."""
        weights = np.repeat([1.0, self.mechanism.length], 3)
        matrix = np.vstack([weights[:, None] * jacobians[name] for name in self.owner])
        target = np.concatenate([weights * motions[name] for name in self.owner])
        rates = np.linalg.lstsq(matrix, target, rcond=None)[0]
        # At rest there is nothing to be relative to: 0.1 m/s, or a hundredth of gravity, stands in.
        size = max(float(np.max(np.abs(target))), 0.1)
        return rates, float(np.max(np.abs(matrix @ rates - target))) / size

    def solve(self, sample: Sample, friction: dict[str, Array]) -> Solution:
        """`friction` has for each joint the efforts on its freedoms, in their order."""
        engine, mechanism = self.engine, self.mechanism
        pose_error = self.place(sample)
        q = self.q
        poses, jacobians = self.kinematics()
        v, velocity_error = self.rates(jacobians, {name: sample.motions[body] for name, body in self.owner.items()})
        bias = engine.bias(q, v)
        a, acceleration_error = self.rates(
            jacobians, {name: sample.accelerations[body] - bias[name] for name, body in self.owner.items()}
        )

        needed = engine.inverse_dynamics(q, v, a)
        terms = [np.abs(needed)]
        for name, wrench in self.outer_loads(sample).items():
            needed = needed - jacobians[name].T @ wrench
        spring_wrenches = self.spring_wrenches(sample)
        own_springs = engine.springs(q, v)
        if own_springs is None:
            own_springs = sum(
                (jacobians[name].T @ wrench for name, wrench in spring_wrenches.items()), np.zeros(engine.nv)
            )
        needed = needed - own_springs
        terms.append(np.abs(needed))
        pairs = {name: self.freedom_pairs(joint, poses) for name, joint in mechanism.joints.items()}
        for name, efforts in friction.items():
            for k, effort in enumerate(efforts):
                column = pair_column(pairs[name][k], jacobians)
                needed = needed - effort * column
        terms.append(np.abs(needed))

        driven = [self.drive_column(joint, k, pairs, jacobians) for joint, k in mechanism.actuated()]
        closing = [pair for closure in engine.closures for pair in closure_pairs(closure, poses)]
        columns = np.array(driven + [pair_column(pair, jacobians) for pair in closing]).T
        # Columns of forces and moments differ by lengths; unit columns make their ranks comparable.
        norms = np.linalg.norm(columns, axis=0)
        norms[norms == 0.0] = 1.0
        unknowns = np.linalg.lstsq(columns / norms, needed, rcond=1e-11)[0] / norms
        size = max(float(np.max(t)) for t in terms) or 1.0
        balance = float(np.max(np.abs(columns @ unknowns - needed))) / size
        drives, forces = unknowns[: len(driven)], unknowns[len(driven) :]

        reactions = self.reactions(
            sample, friction, pairs, poses, jacobians, (q, v, a), drives, list(zip(closing, forces)), spring_wrenches
        )
        gap = max((closure_gap(closure, poses) for closure in engine.closures), default=0.0)
        return Solution(drives, reactions, max(pose_error, gap), max(velocity_error, acceleration_error), balance)

    def reactions(
        self, sample, friction, pairs, poses, jacobians, state, drives, closing, spring_wrenches
    ) -> dict[str, Array]:
        """The engine's reactions in the tree with all forces applied, and those of the closures."""
        engine, mechanism = self.engine, self.mechanism
        loads = self.outer_loads(sample)
        if engine.name != "Drake":  # where springs are force elements that act anyway
            for name, wrench in spring_wrenches.items():
                if name in loads:
                    loads[name] += wrench
        tau = np.zeros(engine.nv)
        at_cut = {name: np.zeros(6) for name in self.cut}
        efforts = {name: np.array(friction.get(name, np.zeros(len(pairs[name])))) for name in mechanism.joints}
        for (joint, k), drive in zip(mechanism.actuated(), drives):
            efforts[joint.name][k] += drive
        for name, joint in mechanism.joints.items():
            for pair, effort in zip(pairs[name], efforts[name]):
                if name in self.cut:
                    add_pair(loads, pair, effort)
                    at_cut[name] += effort * pair.wrench_at(joint.frames(poses)[0].position)
                else:
                    tau += effort * pair_column(pair, jacobians)
        for pair, force in closing:
            add_pair(loads, pair, force)
            if pair.name not in self.cut:
                continue  # within a body of several parts
            joint = mechanism.joints[pair.name]
            at_joint = force * pair.wrench_at(joint.frames(poses)[0].position)
            at_cut[joint.name] += at_joint if self.is_on(pair.on, joint.successor) else -at_joint
        in_tree = engine.reactions(*state, tau, loads)
        result = dict(at_cut)
        for name, child in self.child.items():
            if child not in in_tree:
                continue
            joint = mechanism.joints[name]
            lever = poses[child].position - joint.frames(poses)[0].position
            wrench = moved_wrench(in_tree[child], lever)
            result[name] = wrench if self.owner[child] == joint.successor else -wrench
        return result

    @staticmethod
    def is_on(body: str, successor: str) -> bool:
        return body == successor or (body == WORLD and successor == GROUND)

    def drive_column(
        self, joint: Joint, k: int, pairs: dict[str, list["Pair"]], jacobians: dict[str, Array]
    ) -> Array:
        """Generalised forces of a unit drive: by the engine's own actuator, if it reads those of the file."""
        own = self.engine.drive(self.q, (f"{joint.name}.{joint.freedoms[k].name}", joint.name))
        return own if own is not None else pair_column(pairs[joint.name][k], jacobians)

    def outer_loads(self, sample: Sample) -> dict[str, Array]:
        """Loads on the engine's bodies: of a body in parts all is on its first, which has the body's name."""
        return {
            name: sample.loads[body].copy() if name == body else np.zeros(6) for name, body in self.owner.items()
        }

    def freedom_pairs(self, joint: Joint, poses: dict[str, Pose]) -> list["Pair"]:
        """Unit efforts on the freedoms as pairs of wrenches on `to` and `from`."""
        origin = joint.frames(poses)[0].position
        on, against = joint.successor, joint.predecessor
        child = self.child.get(joint.name)
        if child is not None:  # perhaps a part of the body
            on, against = (child, against) if self.owner[child] == on else (on, child)
        return [
            Pair(joint.name, on, against, effort, origin, poses)
            for effort in joint.efforts(poses).T
        ]

    def spring_wrenches(self, sample: Sample) -> dict[str, Array]:
        """Wrenches of all springs on bodies about their origins, by the formula of the model file's page."""
        result: dict[str, Array] = {}
        for spring in self.mechanism.springs:
            ends, rates = [], []
            for body, place in ((spring.predecessor, spring.at_from), (spring.successor, spring.at_to)):
                lever = sample.poses[body].rotation @ place
                ends.append(sample.poses[body].position + lever)
                rates.append((motion_shift(lever) @ sample.motions[body])[:3])
            line = ends[1] - ends[0]
            distance = float(np.linalg.norm(line))
            direction = line / distance
            pull = spring.stiffness * (distance - spring.free_length)
            pull += spring.damping * float(direction @ (rates[1] - rates[0]))
            for body, end, sign in ((spring.predecessor, ends[0], 1.0), (spring.successor, ends[1], -1.0)):
                wrench = np.concatenate([sign * pull * direction, np.zeros(3)])
                moved = moved_wrench(wrench, end - sample.poses[body].position)
                result[body] = result.get(body, np.zeros(6)) + moved
        return result


@dataclass(frozen=True)
class Pair:
    """A wrench on one body and its negative on another; `wrench` is about `origin`, world axes."""

    name: str
    on: str
    against: str
    wrench: Array
    origin: Array
    poses: dict[str, Pose]

    def wrench_at(self, point: Array) -> Array:
        return moved_wrench(self.wrench, self.origin - point)

    def on_body(self, body: str) -> Array:
        return self.wrench_at(self.poses[body].position)


def pair_column(pair: Pair, jacobians: dict[str, Array]) -> Array:
    """Generalised forces of a pair."""
    column = 0.0
    for body, sign in ((pair.on, 1.0), (pair.against, -1.0)):
        if body in jacobians:
            column = column + sign * jacobians[body].T @ pair.on_body(body)
    return column


def add_pair(loads: dict[str, Array], pair: Pair, size: float) -> None:
    for body, sign in ((pair.on, 1.0), (pair.against, -1.0)):
        if body in loads:
            loads[body] += sign * size * pair.on_body(body)


def closure_pairs(closure: Closure, poses: dict[str, Pose]) -> list[Pair]:
    """Unit forces (and moments of a weld) on body b at the closure's point, and back on body a."""
    point = poses[closure.body_b].point(closure.point_b)
    count = 3 if closure.rotation is None else 6
    return [Pair(closure.joint, closure.body_b, closure.body_a, unit, point, poses) for unit in np.eye(6)[:count]]


def closure_gap(closure: Closure, poses: dict[str, Pose]) -> float:
    """How far apart the two points are that the closure holds together, m, or what a weld is turned, rad."""
    a, b = poses[closure.body_a], poses[closure.body_b]
    gap = float(np.linalg.norm(a.point(closure.point_a) - b.point(closure.point_b)))
    if closure.rotation is None:
        return gap
    return max(gap, float(np.linalg.norm(rotation_vector((a.rotation @ closure.rotation).T @ b.rotation))))


def tree_child(joint: Joint, parents: dict[str, str]) -> str | None:
    """The body, or part of a body, that hangs by a joint in the exported tree; none if the joint is cut."""
    for child, parent in ((joint.successor, joint.predecessor), (joint.predecessor, joint.successor)):
        if parents.get(f"{child}@{joint.name}") == parent:
            return f"{child}@{joint.name}"
        if parents.get(child) == parent:
            return child
    return None
