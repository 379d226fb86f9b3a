"""Exudyn: rigid bodies with Euler parameters, joints by its own items, from our description of the mechanism.

Its coordinates are those of all bodies, so its equations hold for loops as they are:

    M(q) q'' + Cq^T lambda = f(q, q') + drives + friction

M, f and Cq are Exudyn's; the system is solved for lambda and the drives. All conventions are taken from Exudyn
itself: the generalised force of a moment on a body from the difference that a unit load makes to f, the wrench of a
joint from its rows of Cq.
"""

from __future__ import annotations

import exudyn as exu
import numpy as np
from exudyn import itemInterface as items

from mechanism import GROUND, Joint, Mechanism, Pose
from solution import Solution
from spatial import Array, moved_wrench, quaternion_product
from tables import Sample

#: constrained axes of ObjectJointGeneric: translations x y z, rotations x y z, in the frames J and K
AXES = {
    "R": [1, 1, 1, 1, 1, 0],
    "C": [1, 1, 0, 1, 1, 0],
    "P": [1, 1, 0, 1, 1, 1],
    "U": [1, 1, 1, 1, 0, 0],  # in the frames (y, z, x): that Exudyn's y of J and z of K stay at right angles
    "E": [0, 0, 1, 1, 1, 0],
    "fixed": [1, 1, 1, 1, 1, 1],
}


class Exudyn:
    name = "Exudyn"
    version = exu.__version__
    silent: set[str] = set()

    def __init__(self, mechanism: Mechanism) -> None:
        exu.config.printToConsole = False
        self.mechanism = mechanism
        self.container = exu.SystemContainer()
        self.mbs = self.container.AddSystem()
        self.moving = mechanism.moving()
        self.objects = {GROUND: self.mbs.AddObject(items.ObjectGround())}
        for name in self.moving:
            self.objects[name] = self._body(name)
        self.rows: dict[str, slice] = {}
        joints = [self._joint(joint) for joint in mechanism.joints.values() if joint.kind != "free"]
        for spring in mechanism.springs:
            markers = [
                self._marker(body, Pose(np.eye(3), place))
                for body, place in ((spring.predecessor, spring.at_from), (spring.successor, spring.at_to))
            ]
            self.mbs.AddObject(
                items.ObjectConnectorSpringDamper(
                    markerNumbers=markers,
                    referenceLength=spring.free_length,
                    stiffness=spring.stiffness,
                    damping=spring.damping,
                )
            )
        self._loads()
        self._more()
        self.mbs.Assemble()
        self.settings = exu.SimulationSettings()
        self.settings.solutionSettings.writeSolutionToFile = False
        self.settings.timeIntegration.verboseMode = 0
        # The solver is only asked for its pieces; it need not find accelerations to begin with.
        self.settings.timeIntegration.generalizedAlpha.computeInitialAccelerations = False
        self.solver = exu.MainSolverImplicitSecondOrder()
        self.solver.InitializeSolver(self.mbs, self.settings)
        self.size = self.solver.GetODE2size()
        self.constraints = self.solver.GetAEsize()
        for joint, number in joints:
            indices = self.mbs.systemData.GetObjectLTGAE(number)
            self.rows[joint] = np.array(indices, int)

    def _body(self, name: str) -> int:
        body = self.mechanism.bodies[name]
        node = self.mbs.AddNode(items.NodeRigidBodyEP(referenceCoordinates=[0, 0, 0, 1, 0, 0, 0]))
        c = body.com
        about_origin = body.inertia + body.mass * (c @ c * np.eye(3) - np.outer(c, c))
        tensor = [about_origin[i, k] for i, k in ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))]
        return self.mbs.AddObject(
            items.ObjectRigidBody(mass=body.mass, inertia=tensor, centerOfMass=list(c), nodeNumber=node)
        )

    def _marker(self, body: str, frame: Pose) -> int:
        """A marker fixed in a body; Exudyn's ground is the world."""
        if body == GROUND:
            frame = self.mechanism.bodies[GROUND].home @ frame
        transform = np.eye(4)
        transform[:3, :3], transform[:3, 3] = frame.rotation, frame.position
        return self.mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=self.objects[body], localHT=transform))

    def _joint(self, joint: Joint) -> tuple[str, int]:
        turn = Pose(np.eye(3)[:, [1, 2, 0]] if joint.kind == "U" else np.eye(3), np.zeros(3))
        markers = [
            self._marker(joint.predecessor, joint.frame_from @ turn),
            self._marker(joint.successor, joint.frame_to @ turn),
        ]
        if joint.kind == "S":
            item = items.ObjectJointSpherical(markerNumbers=markers)
        elif joint.kind in AXES:
            item = items.ObjectJointGeneric(markerNumbers=markers, constrainedAxes=self._axes(joint))
        else:
            raise NotImplementedError(f"Exudyn has no joint of type {joint.kind}")
        return joint.name, self.mbs.AddObject(item)

    def _loads(self) -> None:
        """Gravity, and for each body a force at its origin and a moment, world axes, that are set later."""
        identity = Pose(np.eye(3), np.zeros(3))
        self.load_items: dict[str, tuple[int, int]] = {}
        for name in self.moving:
            at_com = self.mbs.AddMarker(items.MarkerBodyMass(bodyNumber=self.objects[name]))
            self.mbs.AddLoad(items.LoadMassProportional(markerNumber=at_com, loadVector=self.mechanism.gravity))
            marker = self._marker(name, identity)
            self.load_items[name] = (
                self.mbs.AddLoad(items.LoadForceVector(markerNumber=marker, loadVector=[0, 0, 0])),
                self.mbs.AddLoad(items.LoadTorqueVector(markerNumber=marker, loadVector=[0, 0, 0])),
            )

    def _axes(self, joint: Joint) -> list[int]:
        return list(AXES[joint.kind])

    def _more(self) -> None:
        """What others add to the bodies and joints before they are assembled."""

    def count(self) -> tuple[int, int]:
        """Degrees of freedom and redundant constraints at home, by Exudyn's own call."""
        self._place(self.mechanism.home(), {name: np.zeros(6) for name in self.moving}, initial=True)
        found = self.mbs.ComputeSystemDegreeOfFreedom()
        return int(found["degreeOfFreedom"]), int(found["redundantConstraints"])

    def _place(self, poses: dict[str, Pose], motions: dict[str, Array], initial: bool = False) -> Array:
        """Sets coordinates and velocities; the Euler parameters of all bodies, one a row."""
        place, rate, parameters = [], [], []
        for name in self.moving:
            theta = euler_parameters(poses[name].rotation)
            spin = 0.5 * quaternion_product(np.array([0.0, *motions[name][3:]]), theta)
            place.extend([*poses[name].position, *(theta - np.array([1.0, 0.0, 0.0, 0.0]))])
            rate.extend([*motions[name][:3], *spin])
            parameters.append(theta)
        kind = exu.ConfigurationType.Initial if initial else exu.ConfigurationType.Current
        self.mbs.systemData.SetODE2Coordinates(place, kind)
        self.mbs.systemData.SetODE2Coordinates_t(rate, kind)
        return np.array(parameters)

    def _forces(self, loads: dict[str, Array]) -> Array:
        """f(q, q') with loads [f, m] about the origins of bodies."""
        for name, (force, torque) in self.load_items.items():
            load = loads.get(name, np.zeros(6))
            self.mbs.SetLoadParameter(force, "loadVector", load[:3])
            self.mbs.SetLoadParameter(torque, "loadVector", load[3:])
        self.solver.ComputeODE2RHS(self.mbs)
        return np.array(self.solver.GetSystemResidual())[: self.size].copy()

    def _unit_loads(self, base: Array) -> dict[str, Array]:
        """Generalised forces of six unit loads on each body, 7 x 6 at the body's own coordinates."""
        maps = {name: np.zeros((7, 6)) for name in self.moving}
        for k in range(6):
            unit = np.eye(6)[k]
            difference = self._forces({name: unit for name in self.moving}) - base
            for i, name in enumerate(self.moving):
                maps[name][:, k] = difference[7 * i : 7 * i + 7]
        return maps

    def solve(self, sample: Sample, friction: dict[str, Array]) -> Solution:
        """Drives and reactions; `friction` has for each joint the efforts on its freedoms."""
        mechanism, poses = self.mechanism, sample.poses
        parameters = self._place(poses, sample.motions)
        rates, accelerations = [], []
        for i, name in enumerate(self.moving):
            theta, spin = parameters[i], np.array([0.0, *sample.motions[name][3:]])
            theta_rate = 0.5 * quaternion_product(spin, theta)
            second = 0.5 * (
                quaternion_product(np.array([0.0, *sample.accelerations[name][3:]]), theta)
                + quaternion_product(spin, theta_rate)
            )
            rates.extend([*sample.motions[name][:3], *theta_rate])
            accelerations.extend([*sample.accelerations[name][:3], *second])
        self.solver.ComputeMassMatrix(self.mbs)
        mass = np.array(self.solver.GetSystemMassMatrix())[: self.size, : self.size].copy()
        self.solver.ComputeJacobianODE2RHS(self.mbs, scalarFactor_ODE2=0.0)
        self.solver.ComputeJacobianAE(self.mbs)
        jacobian = np.array(self.solver.GetSystemJacobian())
        rows = jacobian[self.size :, : self.size].copy()  # Cq
        closure = self._closure()
        # Rates of the constraints, relative to the largest rate, or to 0.1 m/s at rest.
        slip = float(np.max(np.abs(rows @ np.array(rates)))) / max(float(np.max(np.abs(rates))), 0.1)

        base = self._forces({})
        maps = self._unit_loads(base)
        loads = {name: sample.loads[name].copy() for name in self.moving}
        pairs = {name: self._pairs(joint, poses) for name, joint in mechanism.joints.items()}
        for name, efforts in friction.items():
            for pair, effort in zip(pairs[name], efforts):
                for body, wrench in pair.items():
                    loads[body] += effort * wrench
        drive_columns = []
        for joint, k in mechanism.actuated():
            column = np.zeros(self.size)
            for body, wrench in pairs[joint.name][k].items():
                i = 7 * self.moving.index(body)
                column[i : i + 7] = maps[body] @ wrench
            drive_columns.append(column)
        needed = mass @ np.array(accelerations) - self._forces(loads)
        columns = np.column_stack([*drive_columns, *(-rows)])
        norms = np.linalg.norm(columns, axis=0)
        norms[norms == 0.0] = 1.0
        unknowns = np.linalg.lstsq(columns / norms, needed, rcond=1e-11)[0] / norms
        size = max(float(np.max(np.abs(needed))), float(np.max(np.abs(base)))) or 1.0
        balance = float(np.max(np.abs(columns @ unknowns - needed))) / size
        drives, multipliers = unknowns[: len(drive_columns)], unknowns[len(drive_columns) :]

        reactions = {}
        for name, indices in self.rows.items():
            joint = mechanism.joints[name]
            generalised = -rows[indices].T @ multipliers[indices]
            # The wrench on `to`, or minus that on `from` where `to` is the ground.
            body, sign = (joint.successor, 1.0) if joint.successor != GROUND else (joint.predecessor, -1.0)
            i = 7 * self.moving.index(body)
            # The part along the Euler parameters themselves belongs to their own constraint.
            wrench = sign * np.linalg.lstsq(maps[body], generalised[i : i + 7], rcond=None)[0]
            origin = joint.frames(poses)[0].position
            total = moved_wrench(wrench, poses[body].position - origin)
            efforts = np.array(friction.get(name, np.zeros(len(joint.freedoms))))
            for (driven, k), drive in zip(mechanism.actuated(), drives):
                if driven.name == name:
                    efforts[k] += drive
            reactions[name] = total + joint.efforts(poses) @ efforts
        return Solution(drives, reactions, closure, slip, balance)

    def _closure(self) -> float:
        """Largest residual of Exudyn's own constraint equations."""
        self.solver.ComputeAlgebraicEquations(self.mbs)
        residual = np.array(self.solver.GetSystemResidual())[self.size :]
        return float(np.max(np.abs(residual))) if residual.size else 0.0

    def _pairs(self, joint: Joint, poses: dict[str, Pose]) -> list[dict[str, Array]]:
        """Unit efforts on the freedoms as wrenches on the two bodies, about their origins."""
        origin = joint.frames(poses)[0].position
        result = []
        for effort in joint.efforts(poses).T:
            pair = {}
            for body, sign in ((joint.successor, 1.0), (joint.predecessor, -1.0)):
                if body != GROUND:
                    pair[body] = sign * moved_wrench(effort, origin - poses[body].position)
            result.append(pair)
        return result


def euler_parameters(rotation: Array) -> Array:
    """Unit quaternion (w, x, y, z) of a rotation matrix, by its largest component."""
    r = rotation
    squares = np.array(
        [
            1 + r[0, 0] + r[1, 1] + r[2, 2],
            1 + r[0, 0] - r[1, 1] - r[2, 2],
            1 - r[0, 0] + r[1, 1] - r[2, 2],
            1 - r[0, 0] - r[1, 1] + r[2, 2],
        ]
    )
    products = np.array(
        [
            [squares[0], r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]],
            [r[2, 1] - r[1, 2], squares[1], r[0, 1] + r[1, 0], r[0, 2] + r[2, 0]],
            [r[0, 2] - r[2, 0], r[0, 1] + r[1, 0], squares[2], r[1, 2] + r[2, 1]],
            [r[1, 0] - r[0, 1], r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], squares[3]],
        ]
    )
    row = products[int(np.argmax(squares))]
    return row / np.linalg.norm(row)
