"""Torques of geared motors along a motion, against MuJoCo (`armature`, `gear`, `damping`) and Pinocchio (rotor
inertia and gear ratio): an arm of two turning joints and a slide, whose motors have reflected rotors."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
import pinocchio

from program import Program
from spatial import Array
from tables import read_table

#: largest relative difference of the torques of a motor
LIMIT = 1e-10

ARM = """
title = "An arm with three geared motors"
gravity = [0.3, -0.2, -9.81]
[bodies.upper]
mass = 4
com = [0.2, 0.01, -0.02]
inertia = { xx = 0.02, yy = 0.09, zz = 0.08, xy = 0.003, xz = -0.002, yz = 0.001 }
[bodies.lower]
mass = 2.5
com = [0.15, 0.0, 0.03]
inertia = [0.01, 0.05, 0.05]
[bodies.quill]
mass = 1.2
com = [0.0, 0.0, -0.1]
inertia = [0.006, 0.006, 0.001]
[joints.shoulder]
type = "R"
from = "ground"
to = "upper"
at = [0, 0, 0.5]
axis = "y"
[joints.elbow]
type = "R"
from = "upper"
to = "lower"
at = [0.4, 0, 0]
axis = [0.1, 0, 1]
[joints.quill]
type = "P"
from = "lower"
to = "quill"
at = [0.3, 0, 0]
axis = "-z"
[actuators.S]
joint = "shoulder"
ratio = 80
rotor_inertia = 3e-5
motor_friction = { viscous = 4e-5 }
[actuators.E]
joint = "elbow"
ratio = -50
rotor_inertia = 2e-5
motor_friction = { viscous = 1e-5 }
[actuators.Q]
joint = "quill"
lead = "10 mm/rev"
ratio = 2
rotor_inertia = 1e-5
[motions.wave]
duration = 2
step = 0.01
shoulder = "0.4 rad + 0.7 rad*sin(3.1 rad/s*t)"
elbow = "0.9 rad*cos(4.3 rad/s*t)"
quill = "0.05 m*sin(5.7 rad/s*t + 0.4 rad)"
[default]
motion = "wave"
"""

#: of the file; Pinocchio does not read it
GRAVITY = (0.3, -0.2, -9.81)
#: motor, joint, transmission, inertia of the rotor, viscous friction
MOTORS = (
    ("S", "shoulder", 80.0, 3e-5, 4e-5),
    ("E", "elbow", -50.0, 2e-5, 1e-5),
    ("Q", "quill", 2.0 * 2.0 * np.pi / 0.01, 1e-5, 0.0),
)


@dataclass(frozen=True)
class Geared:
    """Largest difference of the torques of a motor, relative to the largest torque."""

    engine: str
    version: str
    motor: str
    difference: float

    def complaints(self) -> list[str]:
        if self.difference <= LIMIT:
            return []
        return [f"motor {self.motor}: differs from {self.engine} by {self.difference:.1e}, more than {LIMIT:.0e}"]


def measure(program: Program, folder: Path) -> list[Geared]:
    folder = folder / "drive_trains"
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "arm.toml"
    path.write_text(ARM, encoding="utf-8")
    mjcf = program.describe(str(path), folder, "mjcf")
    program.call("inverse", str(path), "-o", str(folder / "out"))
    names, rows = read_table(folder / "out" / "inverse.csv")
    joints, motion = read_table(folder / "out" / "joints.csv")
    column = lambda joint, what: motion[:, joints.index(f"{joint}.{what}")]  # noqa: E731
    states = [
        np.stack([column(joint, what) for _, joint, *_ in MOTORS], axis=1)
        for what in ("position", "rate", "acceleration")
    ]
    found = []
    for engine, version, torques in (
        ("MuJoCo", mujoco.__version__, by_mujoco(mjcf, *states)),
        ("Pinocchio", pinocchio.__version__, by_pinocchio(mjcf, *states)),
    ):
        for k, (motor, *_) in enumerate(MOTORS):
            ours = rows[:, names.index(f"{motor}.motor_torque")]
            size = float(np.max(np.abs(torques[:, k])))
            difference = float(np.max(np.abs(ours - torques[:, k]))) / size
            found.append(Geared(engine, version, motor, difference))
    return found


def by_mujoco(mjcf: Path, positions: Array, rates: Array, accelerations: Array) -> Array:
    """Torques of the motors: the actuator's `gear` and the joint's `armature` and `damping` are those of the file."""
    model = mujoco.MjModel.from_xml_path(str(mjcf))
    data = mujoco.MjData(model)
    torques = []
    for q, v, a in zip(positions, rates, accelerations, strict=True):
        for (_, joint, *_), x, y, z in zip(MOTORS, q, v, a, strict=True):
            own = model.joint(joint)
            data.qpos[own.qposadr[0]], data.qvel[own.dofadr[0]], data.qacc[own.dofadr[0]] = x, y, z
        mujoco.mj_inverse(model, data)
        efforts = [data.qfrc_inverse[model.joint(joint).dofadr[0]] for _, joint, *_ in MOTORS]
        gears = [model.actuator(motor).gear[0] for motor, *_ in MOTORS]
        torques.append(np.array(efforts) / np.array(gears))
    return np.array(torques)


def by_pinocchio(mjcf: Path, positions: Array, rates: Array, accelerations: Array) -> Array:
    """Torques of the motors from bodies of the file, and rotors and gear ratios given to Pinocchio."""
    model = pinocchio.buildModelFromMJCF(str(mjcf))
    model.gravity.linear[:] = GRAVITY
    index = [model.joints[model.getJointId(joint)].idx_v for _, joint, *_ in MOTORS]
    armature = np.zeros(model.nv)
    for at, (_, _, ratio, inertia, _) in zip(index, MOTORS, strict=True):
        model.rotorInertia[at], model.rotorGearRatio[at] = inertia, ratio
        armature[at] = inertia * ratio**2
    model.armature = armature
    data = model.createData()
    order = np.argsort(index)
    torques = []
    for q, v, a in zip(positions[:, order], rates[:, order], accelerations[:, order], strict=True):
        efforts = pinocchio.rnea(model, data, q, v, a)[index]
        speeds = v[index]
        torques.append(
            [
                effort / ratio + viscous * ratio * speed
                for effort, speed, (_, _, ratio, _, viscous) in zip(efforts, speeds, MOTORS, strict=True)
            ]
        )
    return np.array(torques)
