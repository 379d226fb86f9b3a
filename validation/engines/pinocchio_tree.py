"""Pinocchio: `rnea` for the open tree, `data.f` of a second `rnea` with all loads for the reactions.

Pinocchio joins bodies without a joint between them to one; it does not say what passes between those.
"""

from __future__ import annotations

import tempfile
import xml.etree.ElementTree as xml
from pathlib import Path

import numpy as np
import pinocchio as pin

from engines.tree import WORLD, Closure, TreeEngine, read_tree
from mechanism import Mechanism, Pose
from spatial import Array, moved_wrench

ALIGNED = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED


def read(mjcf: Path) -> tuple[pin.Model, list]:
    """Pinocchio reads only the first body that the world has: all are put into one, which is fixed."""
    root = xml.parse(mjcf).getroot()
    world = root.find("worldbody")
    fixed = xml.Element("body", name="all that the world has")
    xml.SubElement(fixed, "inertial", pos="0 0 0", mass="1", diaginertia="1 1 1")
    for body in world.findall("body"):
        world.remove(body)
        fixed.append(body)
    world.append(fixed)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "wrapped.xml"
        xml.ElementTree(root).write(path, encoding="utf-8")
        model, constraints = pin.buildModelAndConstraintsFromMJCF(str(path))[:2]
    return model, list(constraints)


class Pinocchio(TreeEngine):
    name = "Pinocchio"
    version = pin.__version__

    def __init__(self, mjcf: Path, mechanism: Mechanism) -> None:
        self.model, constraints = read(mjcf)
        self.model.gravity.linear = mechanism.gravity  # Pinocchio does not read the file's
        self.data = self.model.createData()
        if not self.model.check(self.data):
            raise RuntimeError("Pinocchio's joints are not in the order that its recursions ask for")
        self.nv = self.model.nv
        self.parents = read_tree(mjcf)
        self.frames = {name: self.model.getFrameId(name, pin.FrameType.BODY) for name in self.parents}
        # Pinocchio keeps no names of constraints, but their order.
        names = [element.get("name") for element in xml.parse(mjcf).getroot().iterfind("equality/*")]
        if len(names) != len(constraints):
            raise RuntimeError(f"Pinocchio read {len(constraints)} of {len(names)} equalities")
        self.closures = [self._closure(name, constraint) for name, constraint in zip(names, constraints)]

    def _closure(self, name: str, constraint) -> Closure:
        if not isinstance(constraint, pin.PointAnchorConstraintModel):
            raise NotImplementedError(f"Pinocchio read a {constraint.shortname()}, not a pair of points")
        body_a, point_a = self._point(constraint.joint1_id, constraint.joint1_placement)
        body_b, point_b = self._point(constraint.joint2_id, constraint.joint2_placement)
        return Closure(name, body_a, point_a, body_b, point_b, weld=False)

    def _point(self, joint: int, placement: pin.SE3) -> tuple[str, Array]:
        """From the frame of a joint to that of the body behind it."""
        if joint == 0:
            return WORLD, placement.translation.copy()
        for name, frame in self.frames.items():
            if self.model.frames[frame].parentJoint == joint:
                return name, self.model.frames[frame].placement.actInv(placement.translation)
        raise KeyError(f"no body behind joint {joint}")

    def neutral(self) -> Array:
        return pin.neutral(self.model)

    def integrate(self, q: Array, dv: Array) -> Array:
        return pin.integrate(self.model, q, dv)

    def kinematics(self, q: Array) -> tuple[dict[str, Pose], dict[str, Array]]:
        pin.computeJointJacobians(self.model, self.data, q)
        pin.updateFramePlacements(self.model, self.data)
        poses, jacobians = {}, {}
        for name, frame in self.frames.items():
            placement = self.data.oMf[frame]
            poses[name] = Pose(placement.rotation.copy(), placement.translation.copy())
            jacobians[name] = pin.getFrameJacobian(self.model, self.data, frame, ALIGNED).copy()
        return poses, jacobians

    def bias(self, q: Array, v: Array) -> dict[str, Array]:
        pin.forwardKinematics(self.model, self.data, q, v, np.zeros(self.nv))
        pin.updateFramePlacements(self.model, self.data)
        return {
            name: pin.getFrameClassicalAcceleration(self.model, self.data, frame, ALIGNED).vector.copy()
            for name, frame in self.frames.items()
        }

    def inverse_dynamics(self, q: Array, v: Array, a: Array) -> Array:
        return pin.rnea(self.model, self.data, q, v, a).copy()

    def springs(self, q: Array, v: Array) -> Array | None:
        """Pinocchio has no springs between bodies."""
        return None

    def reactions(
        self, q: Array, v: Array, a: Array, tau: Array, loads: dict[str, Array]
    ) -> dict[str, Array]:
        pin.forwardKinematics(self.model, self.data, q)
        pin.updateFramePlacements(self.model, self.data)
        external = pin.StdVec_Force()
        for _ in range(self.model.njoints):
            external.append(pin.Force.Zero())
        for name, wrench in loads.items():
            if name in self.frames:
                joint = self.model.frames[self.frames[name]].parentJoint
                placement, origin = self.data.oMi[joint], self.data.oMf[self.frames[name]].translation
                moved = moved_wrench(wrench, origin - placement.translation)
                turned = np.concatenate([placement.rotation.T @ moved[:3], placement.rotation.T @ moved[3:]])
                external[joint] += pin.Force(turned)
        pin.rnea(self.model, self.data, q, v, a, external)
        result = {}
        for name, parent in self.parents.items():
            joint = self.model.frames[self.frames[name]].parentJoint
            if joint == 0 or (parent in self.frames and self.model.frames[self.frames[parent]].parentJoint == joint):
                continue
            placement, origin = self.data.oMi[joint], self.data.oMf[self.frames[name]].translation
            wrench = np.concatenate(
                [placement.rotation @ self.data.f[joint].linear, placement.rotation @ self.data.f[joint].angular]
            )
            result[name] = moved_wrench(wrench, placement.translation - origin)
        return result
