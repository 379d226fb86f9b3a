"""Loads what `stiction convert` writes for other programs: URDF with YAML by Pinocchio, MJCF by MuJoCo.

    python robot_files.py ../target/release/stiction

For each model of the gallery: the loops close at the written coordinates, and the mass is that of the model.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import mujoco
import numpy as np
import pinocchio
import yaml

NAMESPACE = "{urn:stiction:1}"
# Relative to lengths of the order of a metre; the program closes loops to 1e-14.
LIMIT = 1e-9


def call(program: str, *arguments: str) -> str:
    done = subprocess.run([program, *arguments], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{arguments}: exit code {done.returncode}\n{done.stderr}")
    return done.stdout


def with_types(model: pinocchio.Model, types: dict[str, str]) -> pinocchio.Model:
    """The model with other types for some joints: a ball, or hinges about x and then y."""
    changed = pinocchio.Model()
    last = {model.names[0]: 0}
    for index in range(1, model.njoints):
        name, place = model.names[index], model.jointPlacements[index]
        parent, joint = last[model.names[model.parents[index]]], model.joints[index]
        kind = types.get(name)
        if kind == "CARDAN":
            parent = changed.addJoint(parent, pinocchio.JointModelRX(), place, f"{name}.first")
            joint, place = pinocchio.JointModelRY(), pinocchio.SE3.Identity()
        elif kind == "SPHERICAL":
            joint = pinocchio.JointModelSpherical()
        last[name] = changed.addJoint(parent, joint, place, name)
        changed.appendBodyToJoint(last[name], model.inertias[index], pinocchio.SE3.Identity())
    for frame in model.frames:
        parent = last[model.names[frame.parentJoint]]
        changed.addFrame(pinocchio.Frame(frame.name, parent, frame.placement, frame.type), False)
    return changed


def coordinates(model: pinocchio.Model, root: ElementTree.Element, types: dict[str, str]) -> np.ndarray:
    """The coordinates that the file has in the elements of the program."""
    reversed_joints = {element.get("name") for element in root.iter(f"{NAMESPACE}from")}
    q = pinocchio.neutral(model)
    for element in root.iter(f"{NAMESPACE}start"):
        name = element.get("name")
        if not model.existJointName(name):
            continue
        values = [float(word) for word in (element.text or "").split()]
        kind = types.get(name)
        joint = model.joints[model.getJointId(name)]
        if kind == "SPHERICAL":
            w, x, y, z = values
            sign = -1.0 if name in reversed_joints else 1.0
            q[joint.idx_q : joint.idx_q + 4] = [sign * x, sign * y, sign * z, w]
        elif kind == "CARDAN":
            first, second = reversed(values) if name in reversed_joints else values
            q[model.joints[model.getJointId(f"{name}.first")].idx_q] = first
            q[joint.idx_q] = second
        elif joint.nq == 2:
            q[joint.idx_q : joint.idx_q + 2] = [np.cos(values[0]), np.sin(values[0])]
        elif joint.nq == 1:
            q[joint.idx_q] = values[0]
    return q


def by_pinocchio(urdf: Path) -> tuple[float, float]:
    """Total mass, kg, and greatest error of the closures, m or rad."""
    content = yaml.safe_load(urdf.with_suffix(".yaml").read_text(encoding="utf-8"))
    types = dict(zip(content["joint_name"], content["joint_type"], strict=True))
    model = with_types(pinocchio.buildModelFromUrdf(str(urdf)), types)
    data = model.createData()
    q = coordinates(model, ElementTree.parse(urdf).getroot(), types)
    pinocchio.framesForwardKinematics(model, data, q)
    worst = 0.0
    for (first, second), kind in zip(content["closed_loop"], content["type"], strict=True):
        one, two = (data.oMf[model.getFrameId(name)] for name in (first, second))
        error = np.linalg.norm(one.translation - two.translation)
        if kind == "6d":
            error = max(error, np.linalg.norm(pinocchio.log3(one.rotation.T @ two.rotation)))
        worst = max(worst, float(error))
    return sum(inertia.mass for inertia in list(model.inertias)[1:]), worst


def by_mujoco(mjcf: Path) -> tuple[float, float]:
    """Total mass, kg, and greatest error of the equality constraints, m or rad."""
    model = mujoco.MjModel.from_xml_path(str(mjcf))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    equal = data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY
    worst = float(np.max(np.abs(data.efc_pos[equal]), initial=0.0))
    return float(np.sum(model.body_mass)), worst


def main() -> int:
    program = sys.argv[1] if len(sys.argv) > 1 else "../target/release/stiction"
    failed = 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for model in json.loads(call(program, "models", "--json")):
            model = model["name"]
            mechanism = json.loads(call(program, "convert", model, "--to", "json"))
            mass = sum(body["mass"] for body in mechanism["bodies"])
            for ending, load in ((".urdf", by_pinocchio), (".xml", by_mujoco)):
                path = folder / f"{model}{ending}"
                call(program, "convert", model, "-o", str(path))
                found, worst = load(path)
                good = abs(found - mass) < LIMIT * mass and worst < LIMIT
                failed += not good
                print(f"{'ok ' if good else 'BAD'} {path.name:28} {found:10.4f} kg, loops to {worst:.1e}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
