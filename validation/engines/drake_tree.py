"""Drake: `CalcInverseDynamics` with the contribution of its force elements, and the port `reaction_forces`.

A plant in continuous time has no constraints, and one in discrete time solves its own step instead of the equations
of motion at an instant. So the loops are left out of the file that Drake reads, and their forces are applied. The
reaction port follows from forward dynamics with all forces given: reactions are right only if Drake finds the
accelerations of the motion.
"""

from __future__ import annotations

import logging
import xml.etree.ElementTree as xml
from importlib.metadata import version
from pathlib import Path

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import ExternallyAppliedSpatialForce, MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable, LinearSpringDamper, MultibodyForces

logging.getLogger("drake").setLevel(logging.ERROR)  # it warns of every tag that it does not read

from engines.tree import TreeEngine, read_closures, read_pose, read_tree, vector
from mechanism import Mechanism, Pose
from spatial import Array, moved_wrench


class Drake(TreeEngine):
    name = "Drake"
    version = version("drake")

    def __init__(self, mjcf: Path, mechanism: Mechanism) -> None:
        self.plant = MultibodyPlant(time_step=0.0)
        Parser(self.plant).AddModelsFromString(open_tree(mjcf), "xml")
        self.parents = read_tree(mjcf)
        self.closures = read_closures(mjcf)
        self.bodies = {name: self.plant.GetBodyByName(name) for name in self.parents}
        for spring in mechanism.springs:
            self.plant.AddForceElement(
                LinearSpringDamper(
                    self.bodies[spring.predecessor],
                    spring.at_from,
                    self.bodies[spring.successor],
                    spring.at_to,
                    spring.free_length,
                    spring.stiffness,
                    spring.damping,
                )
            )
        self.plant.Finalize()
        self.nv = self.plant.num_velocities()
        self.context = self.plant.CreateDefaultContext()
        self.at_rest = self.plant.get_actuation_input_port().size()
        self.joints = [self.plant.get_joint(i) for i in self.plant.GetJointIndices()]

    def neutral(self) -> Array:
        return self.plant.GetPositions(self.plant.CreateDefaultContext()).copy()

    def integrate(self, q: Array, dv: Array) -> Array:
        """Drake maps rates; a step along them is made, and quaternions are normalised."""
        self.plant.SetPositions(self.context, q)
        moved = q + self.plant.MapVelocityToQDot(self.context, dv)
        for joint in self.joints:
            if joint.type_name() == "quaternion_floating":
                first = joint.position_start()
                moved[first : first + 4] /= np.linalg.norm(moved[first : first + 4])
        return moved

    def kinematics(self, q: Array) -> tuple[dict[str, Pose], dict[str, Array]]:
        self.plant.SetPositions(self.context, q)
        poses, jacobians = {}, {}
        for name, body in self.bodies.items():
            pose = self.plant.EvalBodyPoseInWorld(self.context, body)
            poses[name] = Pose(pose.rotation().matrix().copy(), pose.translation().copy())
            jacobian = self.plant.CalcJacobianSpatialVelocity(
                self.context,
                JacobianWrtVariable.kV,
                body.body_frame(),
                np.zeros(3),
                self.plant.world_frame(),
                self.plant.world_frame(),
            )
            jacobians[name] = np.vstack([jacobian[3:], jacobian[:3]])  # Drake has rotations first
        return poses, jacobians

    def bias(self, q: Array, v: Array) -> dict[str, Array]:
        self.plant.SetPositions(self.context, q)
        self.plant.SetVelocities(self.context, v)
        result = {}
        for name, body in self.bodies.items():
            acceleration = self.plant.CalcBiasSpatialAcceleration(
                self.context,
                JacobianWrtVariable.kV,
                body.body_frame(),
                np.zeros(3),
                self.plant.world_frame(),
                self.plant.world_frame(),
            )
            result[name] = np.concatenate([acceleration.translational(), acceleration.rotational()])
        return result

    def _inverse(self, q: Array, v: Array, a: Array) -> Array:
        """Of the open tree with gravity and springs."""
        self.plant.SetPositions(self.context, q)
        self.plant.SetVelocities(self.context, v)
        forces = MultibodyForces(self.plant)
        self.plant.CalcForceElementsContribution(self.context, forces)
        return self.plant.CalcInverseDynamics(self.context, a, forces)

    def inverse_dynamics(self, q: Array, v: Array, a: Array) -> Array:
        springs = self.springs(q, v)
        return self._inverse(q, v, a) + (0.0 if springs is None else springs)

    def springs(self, q: Array, v: Array) -> Array | None:
        """Force elements that are not gravity, from the difference that they make."""
        if self.plant.num_force_elements() == 1:
            return None
        self.plant.SetPositions(self.context, q)
        self.plant.SetVelocities(self.context, v)
        forces = MultibodyForces(self.plant)
        self.plant.CalcForceElementsContribution(self.context, forces)
        # Inverse dynamics at rest with forces F gives -J^T F: once with all elements, once with gravity alone.
        self.plant.SetVelocities(self.context, np.zeros(self.nv))
        all_forces = -self.plant.CalcInverseDynamics(self.context, np.zeros(self.nv), forces)
        return all_forces - self.plant.CalcGravityGeneralizedForces(self.context)

    def reactions(
        self, q: Array, v: Array, a: Array, tau: Array, loads: dict[str, Array]
    ) -> dict[str, Array]:
        """The port says the wrench on the child at the joint's frame there, in axes of that frame."""
        plant, context = self.plant, self.context
        plant.SetPositions(context, q)
        plant.SetVelocities(context, v)
        plant.get_actuation_input_port().FixValue(context, np.zeros(self.at_rest))
        plant.get_applied_generalized_force_input_port().FixValue(context, tau)
        applied = []
        for name, wrench in loads.items():
            force = ExternallyAppliedSpatialForce()
            force.body_index = self.bodies[name].index()
            force.p_BoBq_B = np.zeros(3)
            force.F_Bq_W = SpatialForce(tau=wrench[3:], f=wrench[:3])
            applied.append(force)
        port = plant.get_applied_spatial_force_input_port()
        port.FixValue(context, Value[list[ExternallyAppliedSpatialForce]](applied))
        forces = plant.get_reaction_forces_output_port().Eval(context)
        result = {}
        for joint in self.joints:
            child = joint.child_body()
            if child.name() not in self.parents:
                continue
            frame: RigidTransform = joint.frame_on_child().CalcPoseInWorld(context)
            rotation = frame.rotation().matrix()
            at_joint = forces[int(joint.index())]
            wrench = np.concatenate(
                [rotation @ at_joint.translational(), rotation @ at_joint.rotational()]
            )
            origin = plant.EvalBodyPoseInWorld(context, child).translation()
            result[child.name()] = moved_wrench(wrench, frame.translation() - origin)
        return result


def open_tree(mjcf: Path) -> str:
    """The file without its loops, tendons, drives and damping, all of which are applied from here."""
    root = xml.parse(mjcf).getroot()
    for tag in ("equality", "tendon", "actuator", "keyframe"):
        for element in root.findall(tag):
            root.remove(element)
    for inertial in root.iterfind("worldbody/body/inertial[@mass='0']"):
        # The ground's, which stands still: Drake takes none without mass.
        inertial.set("mass", "1")
        inertial.set("diaginertia", "1 1 1")
    for body in root.iter("body"):
        restate_joints(body)
    for joint in root.iter("joint"):
        joint.attrib.pop("damping", None)
    return xml.tostring(root, encoding="unicode")


def restate_joints(body: xml.Element) -> None:
    """Where a body has several joints, Drake takes all but the last as if given in the parent's frame.

    MuJoCo, whose format it is, takes them in the body's. So they are restated for Drake; that its bodies then move
    as they should shows in the places that are compared.
    """
    pose = read_pose(body)
    for joint in body.findall("joint")[:-1]:
        place = pose.point(vector(joint.get("pos", "0 0 0")))
        axis = pose.rotation @ vector(joint.get("axis"))
        joint.set("pos", " ".join(repr(float(x)) for x in place))
        joint.set("axis", " ".join(repr(float(x)) for x in axis))
