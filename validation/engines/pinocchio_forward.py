"""Pinocchio's `constraintDynamics`: accelerations of a closed mechanism from its state and its efforts."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from closed_loop import ClosedLoop
from engines.pinocchio_tree import Pinocchio
from engines.tree import Closure
from spatial import Array
from tables import Sample

#: Redundant constraints need the proximal algorithm, whose error falls by about this factor from step to step.
PROXIMAL = 1e-6


class PinocchioForward:
    """The exported tree with its closures as contacts."""

    version = pin.__version__

    def __init__(self, engine: Pinocchio, closed: ClosedLoop) -> None:
        self.engine, self.closed = engine, closed
        self.contacts = pin.StdVec_RigidConstraintModel()
        for closure in engine.closures:
            self.contacts.append(self._contact(closure))
        self.data = engine.model.createData()
        self.contact_data = pin.StdVec_RigidConstraintData()
        for contact in self.contacts:
            self.contact_data.append(contact.createData())
        pin.initConstraintDynamics(engine.model, self.data, self.contacts, self.contact_data)

    def _contact(self, closure: Closure) -> pin.RigidConstraintModel:
        model = self.engine.model
        kind = pin.ContactType.CONTACT_3D if closure.rotation is None else pin.ContactType.CONTACT_6D
        turn = np.eye(3) if closure.rotation is None else closure.rotation
        # Each frame is given in the joint that carries its body.
        ends = []
        for body, place in (
            (closure.body_a, pin.SE3(turn, closure.point_a)),
            (closure.body_b, pin.SE3(np.eye(3), closure.point_b)),
        ):
            if body in self.engine.frames:
                frame = model.frames[self.engine.frames[body]]
                ends.append((frame.parentJoint, frame.placement * place))
            else:
                ends.append((0, place))
        (a, in_a), (b, in_b) = ends
        return pin.RigidConstraintModel(kind, model, a, in_a, b, in_b, pin.ReferenceFrame.LOCAL)

    def acceleration_error(self, sample: Sample, efforts: dict[str, Array]) -> float:
        """Largest difference of accelerations of the tree's coordinates, relative to the largest of them.

        `efforts` has for each joint the efforts on its freedoms.
        """
        state = self.closed.reproduce(sample)
        tau = np.zeros(self.engine.nv)
        for name, values in efforts.items():
            for pair, effort in zip(
                self.closed.freedom_pairs(self.closed.mechanism.joints[name], state.poses), values, strict=True
            ):
                tau += effort * pair.column(state.poses, state.jacobians)
        settings = pin.ProximalSettings(1e-14, PROXIMAL, 50)
        found = pin.constraintDynamics(
            self.engine.model, self.data, state.q, state.v, tau, self.contacts, self.contact_data, settings
        )
        size = float(np.max(np.abs(state.a))) or 1.0
        error = float(np.max(np.abs(found - state.a))) / size
        return error if np.isfinite(error) else np.inf
