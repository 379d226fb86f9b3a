"""Compares what `stiction` reads of robot files, in `robot_files/`, with MuJoCo, Pinocchio and Drake.

    python foreign_files.py ../target/release/stiction

Per file and position: the pose of each body, its mass, centre of mass and inertia in world axes, and anchors and axes
of joints. A URDF has one inertia for links that are fixed together, so total mass, centre of mass and inertia are compared.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import mujoco
import numpy as np
import pinocchio

FOLDER = Path(__file__).parent / "robot_files"
# Relative to lengths of a metre and masses of a kilogram; files have sixteen digits.
LIMIT = 1e-9
POSITIONS = 3


class Body:
    """Pose, mass, centre of mass and inertia about it, world axes."""

    def __init__(self, position, rotation, mass, com, inertia):
        self.position, self.rotation = np.asarray(position), np.asarray(rotation)
        self.mass, self.com, self.inertia = mass, np.asarray(com), np.asarray(inertia)

    def error(self, other: Body) -> float:
        errors = [self.position - other.position, self.rotation - other.rotation, self.mass - other.mass]
        if self.mass > 0.0:
            errors += [self.com - other.com, self.inertia - other.inertia]
        return max(float(np.max(np.abs(error))) for error in errors)


def ours(program: str, file: Path, q: dict[str, float], literal: bool = True):
    command = [program, "convert", str(file), "--to", "json", *(["--literal"] if literal else [])]
    if q:
        command += ["--motion", "; ".join(f"{name} = {value!r}" for name, value in q.items())]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{command}: exit code {done.returncode}\n{done.stderr}")
    mechanism = json.loads(done.stdout)
    bodies, joints = {}, {}
    for body in mechanism["bodies"]:
        home = body["home"]
        p, r = np.array(home["position"]), np.array(home["rotation"])
        inertia = r @ np.array(body["inertia"]) @ r.T
        bodies[body["name"]] = Body(p, r, body["mass"], p + r @ np.array(body["com"]), inertia)
    for joint in mechanism["joints"]:
        base, frame = bodies[joint["from"]], joint["frame_from"]
        point = base.position + base.rotation @ np.array(frame["position"])
        axis = base.rotation @ np.array(frame["rotation"])[:, 2]
        joints[joint["name"]] = (joint["type"], point, axis)
    return bodies, joints


def random_positions(names: list[str]) -> list[dict[str, float]]:
    random = np.random.default_rng(5)
    return [{}] + [dict(zip(names, random.uniform(-0.4, 0.4, len(names)).tolist(), strict=True)) for _ in range(POSITIONS)]


def by_mujoco(program: str, file: Path) -> float:
    model = mujoco.MjModel.from_xml_path(str(file))
    data = mujoco.MjData(model)
    name = lambda kind, index: mujoco.mj_id2name(model, kind, index)
    joints = [name(mujoco.mjtObj.mjOBJ_JOINT, k) for k in range(model.njnt)]
    scalar = all(kind in (2, 3) for kind in model.jnt_type)
    worst = 0.0
    for q in random_positions(joints) if scalar else [{}]:
        if model.nkey:
            mujoco.mj_resetDataKeyframe(model, data, 0)
        for joint, value in q.items():
            data.joint(joint).qpos = value
        mujoco.mj_forward(model, data)
        bodies, found = ours(program, file, q)
        for k in range(1, model.nbody):
            r = data.ximat[k].reshape(3, 3)
            inertia = r @ np.diag(model.body_inertia[k]) @ r.T
            theirs = Body(data.xpos[k], data.xmat[k].reshape(3, 3), model.body_mass[k], data.xipos[k], inertia)
            worst = max(worst, bodies[name(mujoco.mjtObj.mjOBJ_BODY, k)].error(theirs))
        for k, joint in enumerate(joints):
            kind, point, axis = found[joint]
            if kind == "R":
                worst = max(worst, float(np.max(np.abs(np.cross(point - data.xanchor[k], axis)))))
            if kind in ("R", "P"):
                worst = max(worst, float(np.max(np.abs(axis - data.xaxis[k]))))
    return worst


def by_pinocchio(program: str, file: Path) -> float:
    model = pinocchio.buildModelFromUrdf(str(file))
    data = model.createData()
    names = list(model.names)[1:]
    mimics = "<mimic" in file.read_text(encoding="utf-8")
    worst = 0.0
    for q in random_positions(names):
        if mimics:
            # The gearings of the file determine all but the first.
            q = {key: value for key, value in q.items() if key == "thumb_joint"}
            if not q:
                continue
        bodies, _ = ours(program, file, q)
        x = pinocchio.neutral(model)
        full = dict(q)
        if mimics:
            full["index_joint"] = 1.5 * full["thumb_joint"] + 0.1
            full["tip_joint"] = -0.5 * full["index_joint"]
        for joint, value in full.items():
            own = model.joints[model.getJointId(joint)]
            if own.nq == 2:
                x[own.idx_q : own.idx_q + 2] = [np.cos(value), np.sin(value)]
            else:
                x[own.idx_q] = value
        pinocchio.framesForwardKinematics(model, data, x)
        for frame, place in zip(model.frames, data.oMf, strict=True):
            if frame.type == pinocchio.FrameType.BODY and frame.name in bodies:
                own = bodies[frame.name]
                worst = max(worst, float(np.max(np.abs(own.position - place.translation))))
                worst = max(worst, float(np.max(np.abs(own.rotation - place.rotation))))
        total = pinocchio.computeTotalMass(model)
        com = pinocchio.centerOfMass(model, data, x)
        # A URDF whose root is the world has its fixed links in the inertia of the universe.
        fixed = model.inertias[0]
        com = (total * com + fixed.mass * fixed.lever) / (total + fixed.mass)
        mass = sum(body.mass for body in bodies.values())
        own = sum(body.mass * body.com for body in bodies.values()) / mass
        worst = max(worst, abs(total + fixed.mass - mass), float(np.max(np.abs(own - com))))
    return worst


def by_drake(program: str, file: Path) -> float:
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant

    plant = MultibodyPlant(0.0)
    parser = Parser(plant)
    parser.SetAutoRenaming(True)
    parser.AddModels(str(file))
    plant.Finalize()
    context = plant.CreateDefaultContext()
    instances = [plant.GetBodyByName(body.name(), body.model_instance()) for body in bodies_of(plant)]
    joints = [plant.get_joint(k) for k in plant.GetJointIndices()]
    scalar = [joint for joint in joints if joint.num_positions() == 1]
    all_scalar = sum(joint.num_positions() for joint in joints) == len(scalar)
    worst = 0.0
    for q in random_positions([joint.name() for joint in scalar]) if all_scalar else [{}]:
        for joint in scalar:
            value = q.get(joint.name(), 0.0)
            (joint.set_angle if joint.type_name() == "revolute" else joint.set_translation)(context, value)
        bodies, _ = ours(program, file, {full(joint_of, bodies_of(plant), plant): value for joint_of, value in q.items()})
        for body in instances:
            pose = plant.EvalBodyPoseInWorld(context, body)
            inertia = body.CalcSpatialInertiaInBodyFrame(context)
            r = pose.rotation().matrix()
            com = pose.translation() + r @ inertia.get_com()
            about = inertia.Shift(inertia.get_com()).CalcRotationalInertia().CopyToFullMatrix3()
            theirs = Body(pose.translation(), r, inertia.get_mass(), com, r @ about @ r.T)
            own = next(bodies[name] for name in bodies if name == body.name() or name.endswith("." + body.name()))
            worst = max(worst, own.error(theirs))
    return worst


def full(joint: str, _bodies, plant) -> str:
    """Name of a joint in the model file: joints of nested models have the names of these before them."""
    for k in plant.GetJointIndices():
        own = plant.get_joint(k)
        if own.name() == joint:
            names = plant.GetModelInstanceName(own.model_instance()).split("::")
            return ".".join([*names[1:], joint])
    return joint


def bodies_of(plant):
    from pydrake.multibody.tree import BodyIndex

    return [plant.get_body(BodyIndex(k)) for k in range(1, plant.num_bodies())]


def main() -> int:
    program = sys.argv[1] if len(sys.argv) > 1 else "../target/release/stiction"
    engines = {".xml": by_mujoco, ".urdf": by_pinocchio, ".sdf": by_drake}
    failed = 0
    for file in sorted(FOLDER.iterdir()):
        if file.suffix not in engines or "<mujoco>\n" in file.read_text(encoding="utf-8"):
            continue
        try:
            worst = engines[file.suffix](program, file)
        except Exception as error:  # noqa: BLE001
            worst = float("inf")
            print(error)
        good = worst < LIMIT
        failed += not good
        print(f"{'ok ' if good else 'BAD'} {file.name:20} {engines[file.suffix].__name__[3:]:10} {worst:.1e}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
