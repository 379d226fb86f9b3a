"""Exudyn in time: its implicit trapezoidal rule from a given state, under constant efforts and viscous friction.

The rule is of second order and knows no adaptive steps, so its error follows from runs with halved steps.
"""

from __future__ import annotations

import exudyn as exu
import numpy as np
from exudyn import itemInterface as items

from engines.exudyn_bodies import AXES, Exudyn
from mechanism import Joint, Mechanism, Pose
from spatial import Array, quaternion_product, rotation_from_quaternion
from tables import Sample


#: axes of constraints that are left out, by joint
Released = dict[str, list[int]]


class Thinned(Exudyn):
    """Exudyn without some constraints: redundant ones make the matrix of its implicit steps singular."""

    def __init__(self, mechanism: Mechanism, released: Released) -> None:
        self.released = released
        super().__init__(mechanism)

    def _axes(self, joint: Joint) -> list[int]:
        return [
            0 if axis in self.released.get(joint.name, []) else constrained
            for axis, constrained in enumerate(super()._axes(joint))
        ]

    def singular_values(self, states: list[Sample]) -> tuple[int, list[Array]]:
        """How many constraints there are, and the singular values of their Jacobian at each state."""
        values, count = [], 0
        for state in states:
            self._place(state.poses, state.motions)
            self.solver.ComputeMassMatrix(self.mbs)
            self.solver.ComputeJacobianODE2RHS(self.mbs, scalarFactor_ODE2=0.0)
            self.solver.ComputeJacobianAE(self.mbs)
            rows = np.array(self.solver.GetSystemJacobian())[self.size :, : self.size]
            # An axis that is not constrained has a row, too, but nothing in it.
            rows = rows[rows.any(axis=1)]
            count = len(rows)
            values.append(np.linalg.svd(rows, compute_uv=False))
        return count, values


def redundant(mechanism: Mechanism, states: list[Sample]) -> Released:
    """Constraints that can be left out along a motion, so that what is left is as far from singular as can be."""
    released: Released = {}
    count, values = Thinned(mechanism, released).singular_values(states)
    rank = min(int(np.sum(v > 1e-8 * v[0])) for v in values)
    for _ in range(count - rank):
        best, chosen = 0.0, None
        for joint in mechanism.joints.values():
            for axis, constrained in enumerate(AXES.get(joint.kind, [])):
                if constrained and axis not in released.get(joint.name, []):
                    trial = {**released, joint.name: [*released.get(joint.name, []), axis]}
                    least = min(float(v[rank - 1]) for v in Thinned(mechanism, trial).singular_values(states)[1])
                    if least > best:
                        best, chosen = least, trial
        if chosen is None:
            raise RuntimeError(f"{mechanism.name}: no constraint can be left out")
        released = chosen
    return released


class ExudynMotion(Thinned):
    """`efforts` by joint, N or N m, on the joint's first freedom; `viscous` takes the joints' own viscous friction.

    `states` are of the motion that is expected, by which redundant constraints are found.
    """

    def __init__(self, mechanism: Mechanism, efforts: dict[str, float], viscous: bool, states: list[Sample]) -> None:
        self.efforts, self.viscous = efforts, viscous
        super().__init__(mechanism, redundant(mechanism, states))

    def _more(self) -> None:
        """Efforts and viscous friction, by Exudyn's own connectors; a sensor for each body."""
        for joint in self.mechanism.joints.values():
            damping = viscous_damping(joint) if self.viscous else np.zeros(len(joint.freedoms))
            self._efforts_of(joint, damping, self.efforts.get(joint.name, 0.0))
        self.sensors = {
            name: [
                self.mbs.AddSensor(
                    items.SensorNode(
                        nodeNumber=self.mbs.GetObject(self.objects[name])["nodeNumber"],
                        storeInternal=True,
                        writeToFile=False,
                        outputVariableType=kind,
                    )
                )
                for kind in (exu.OutputVariableType.Coordinates, exu.OutputVariableType.Coordinates_t)
            ]
            for name in self.moving
        }

    def _efforts_of(self, joint: Joint, damping: Array, effort: float) -> None:
        if not damping.any() and effort == 0.0:
            return
        markers = [
            self._marker(joint.predecessor, joint.frame_from),
            self._marker(joint.successor, joint.frame_to),
        ]
        # A connector's torque or force is what it exerts against the motion of its second marker.
        if joint.kind == "R":
            item = items.ObjectConnectorTorsionalSpringDamper(
                markerNumbers=markers, damping=damping[0], torque=-effort
            )
            self.mbs.AddObject(item)
        elif joint.kind == "P":
            item = items.ObjectConnectorLinearSpringDamper(
                markerNumbers=markers, axisMarker0=[0, 0, 1], damping=damping[0], force=-effort
            )
            self.mbs.AddObject(item)
        elif joint.kind in ("U", "S") and effort == 0.0:
            # About z of J, then, seen from the other body, about x of K; a ball is the same about all axes.
            ends = ((markers, 2, damping[0]), (markers[::-1], 0, damping[1])) if joint.kind == "U" else ()
            for pair, axis, value in ends:
                matrix = np.zeros((6, 6))
                matrix[3 + axis, 3 + axis] = value
                self.mbs.AddObject(items.ObjectConnectorRigidBodySpringDamper(markerNumbers=pair, damping=matrix))
            if joint.kind == "S":
                matrix = np.diag([0.0, 0.0, 0.0, *damping])
                self.mbs.AddObject(items.ObjectConnectorRigidBodySpringDamper(markerNumbers=markers, damping=matrix))
        else:
            raise NotImplementedError(f"{joint.name}: efforts of a joint of type {joint.kind}")

    def integrate(
        self, poses: dict[str, Pose], motions: dict[str, Array], until: float, steps: int, samples: int
    ) -> Array:
        """Coordinates and their rates at equal times to `until`: samples + 1, bodies, 2, 7."""
        self._place(poses, motions, initial=True)
        settings = exu.SimulationSettings()
        settings.solutionSettings.writeSolutionToFile = False
        settings.solutionSettings.sensorsWritePeriod = until / samples
        settings.displayStatistics = settings.displayComputationTime = False
        settings.linearSolverType = exu.LinearSolverType.EigenDense
        integration = settings.timeIntegration
        integration.verboseMode = 0
        integration.startTime, integration.endTime, integration.numberOfSteps = 0.0, until, steps
        integration.adaptiveStep = False
        integration.newton.relativeTolerance = 1e-12
        integration.newton.absoluteTolerance = 1e-13
        integration.newton.useModifiedNewton = True
        kind = exu.DynamicSolverType.TrapezoidalIndex2
        exu.SolveDynamic(self.mbs, settings, solverType=kind, showHints=False, showCausingItems=False)
        bodies = []
        for name in self.moving:
            tables = [np.atleast_2d(self.mbs.GetSensorStoredData(sensor)) for sensor in self.sensors[name]]
            bodies.append(np.array([table[:, 1:] for table in tables]))
            if tables[0].shape[0] != samples + 1:
                raise RuntimeError(f"{tables[0].shape[0]} rows instead of {samples + 1}")
        result = np.transpose(np.array(bodies), (2, 0, 1, 3)).copy()
        result[:, :, 0, 3] += 1.0  # the node's reference, at which it has no rotation
        return result


def viscous_damping(joint: Joint) -> Array:
    """Effort against a unit rate of each freedom: force per speed of the surfaces, times radius twice."""
    result = np.zeros(len(joint.freedoms))
    names = [freedom.name for freedom in joint.freedoms]
    for contact in joint.contacts:
        if contact["law"]["mu"] != 0.0:
            raise ValueError(f"{joint.name} has more than viscous friction")
        for freedom in contact["dofs"]:
            result[names.index(freedom)] += contact["law"]["viscous"] * (contact["radius"] or 1.0) ** 2
    return result


def pose_and_motion(coordinates: Array, rates: Array) -> tuple[Pose, Array]:
    """Pose and motion [v, w] of a body from its seven coordinates and their rates."""
    length = float(np.linalg.norm(coordinates[3:]))
    theta = coordinates[3:] / length
    conjugate = theta * np.array([1.0, -1.0, -1.0, -1.0])
    spin = 2.0 * quaternion_product(rates[3:] / length, conjugate)[1:]
    return Pose(rotation_from_quaternion(theta), coordinates[:3]), np.concatenate([rates[:3], spin])
