"""Pinocchio: `rnea` for the open tree, `data.f` of a second `rnea` with all loads for the reactions.

Pinocchio joins bodies without a joint between them to one; it does not say what passes between those.
"""

from __future__ import annotations

import tempfile
import xml.etree.ElementTree as xml
from pathlib import Path

import numpy as np
import pinocchio as pin

from engines.tree import TreeEngine, read_closures, read_tree
from mechanism import Mechanism, Pose
from spatial import Array, moved_wrench

ALIGNED = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED


def read(mjcf: Path) -> pin.Model:
    """Pinocchio reads only the first body that the world has, and not its pose if it has no joint.

    So that body is put into another one.
    """
    root = xml.parse(mjcf).getroot()
    world = root.find("worldbody")
    bodies = world.findall("body")
    outer = xml.SubElement(world, "body", name="around")
    xml.SubElement(outer, "inertial", pos="0 0 0", mass="1", diaginertia="1 1 1")
    for body in bodies:
        world.remove(body)
        outer.append(body)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "around.xml"
        xml.ElementTree(root).write(path, encoding="utf-8")
        return pin.buildModelFromMJCF(str(path))


class Pinocchio(TreeEngine):
    name = "Pinocchio"
    version = pin.__version__

    def __init__(self, mjcf: Path, mechanism: Mechanism) -> None:
        self.model = read(mjcf)
        self.model.gravity.linear = mechanism.gravity  # Pinocchio does not read the file's
        self.data = self.model.createData()
        if not self.model.check(self.data):
            raise RuntimeError("Pinocchio's joints are not in the order that its recursions ask for")
        self.nv = self.model.nv
        self.parents = read_tree(mjcf)
        self.frames = {name: self.model.getFrameId(name, pin.FrameType.BODY) for name in self.parents}
        self.merged = frozenset(name for name in self.parents if self._joint(name) == self._joint(self.parents[name]))
        self.closures = read_closures(mjcf)  # Pinocchio reads no equalities between sites

    def _joint(self, body: str) -> int:
        """The joint that carries a body; 0 for what is fixed in the world."""
        return self.model.frames[self.frames[body]].parentJoint if body in self.frames else 0

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
                joint = self._joint(name)
                placement, origin = self.data.oMi[joint], self.data.oMf[self.frames[name]].translation
                moved = moved_wrench(wrench, origin - placement.translation)
                turned = np.concatenate([placement.rotation.T @ moved[:3], placement.rotation.T @ moved[3:]])
                external[joint] += pin.Force(turned)
        pin.rnea(self.model, self.data, q, v, a, external)
        result = {}
        for name in set(self.parents) - self.merged:
            joint = self._joint(name)
            placement, origin = self.data.oMi[joint], self.data.oMf[self.frames[name]].translation
            wrench = np.concatenate(
                [placement.rotation @ self.data.f[joint].linear, placement.rotation @ self.data.f[joint].angular]
            )
            result[name] = moved_wrench(wrench, placement.translation - origin)
        return result
