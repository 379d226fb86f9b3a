"""Simulations of whole robots with friction: `stiction forward` beside MuJoCo.

Stiction has friction that depends on the normal load, and integrates from event to event. MuJoCo simulates the exported
file with fixed steps, soft constraints and constant friction, whose values are means of our friction along the motion;
its loop is the program `mujoco_simulation.cpp`, whose time excludes its start.
"""

from __future__ import annotations

import argparse
import json
import sys
import xml.etree.ElementTree as xml
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
from commands import alternate, cpu_time, pin

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "validation"))

from tables import read_table  # noqa: E402

ROUNDS = 5
#: duration of a simulation, and the period of the controllers and of MuJoCo's steps, s
DURATION, PERIOD = 10.0, 1e-3
#: controllers of our side; the slower one counts
CONTROLLERS = ("pd", "computed-torque")
#: bandwidth of the controllers, rad/s, and the tracking error above which MuJoCo has not followed the motion, m
BANDWIDTH, FOLLOWED = 2.0 * np.pi * 10.0, 0.01


@dataclass(frozen=True)
class Robot:
    model: str
    #: effective mass at an actuator, kg, for the gains in MuJoCo
    mass: float


ROBOTS = (Robot("3rps", 10.0), Robot("gough", 50.0))


def constant_friction(program: Path, robot: Robot, folder: Path) -> dict[str, float]:
    """Mean friction of each joint of the exported file along the motion, N or N m."""
    mechanism = json.loads(cpu_time([program, "convert", robot.model, "--to", "json"])[1])
    names, rows = read_table(folder / "friction.csv")
    friction = {}
    for joint in mechanism["joints"]:
        interfaces = joint["friction"] or []
        for interface in interfaces:
            name = joint["name"] if len(interfaces) == 1 else f"{joint['name']}.{interface['place']}"
            load = np.mean(np.abs(rows[:, names.index(f"{name}.load")]))
            friction[name] = float(interface["law"]["mu"] * (interface["radius"] or 1.0) * load)
    return friction


def for_mujoco(program: Path, robot: Robot, folder: Path) -> list[Path]:
    """Arguments of `mujoco_simulation`: the exported file with constant friction, and the setting."""
    folder.mkdir(parents=True, exist_ok=True)
    arguments = ["--friction", "on", "--load", "none", "--step", repr(PERIOD), "--report", "off", "-o", folder]
    cpu_time([program, "inverse", robot.model, *arguments])
    root = xml.fromstring(cpu_time([program, "convert", robot.model, "--to", "mjcf"])[1])
    friction = constant_friction(program, robot, folder)
    for joint in root.iter("joint"):
        if joint.get("name") in friction:
            joint.set("frictionloss", repr(friction[joint.get("name")]))
    file, setting = folder / "simulation.xml", folder / "simulation.txt"
    xml.ElementTree(root).write(file, encoding="utf-8")

    model = mujoco.MjModel.from_xml_path(str(file))
    names, rows = read_table(folder / "joints.csv")
    period = rows[:-1]  # the last row is the first of the next period
    joints = [model.joint(int(model.actuator(k).trnid[0])) for k in range(model.nu)]
    columns = [names.index(f"{joint.name}.{what}") for joint in joints for what in ("position", "rate")]
    gains = (robot.mass * BANDWIDTH**2, 2.0 * robot.mass * BANDWIDTH)
    lines = [[PERIOD, int(DURATION / PERIOD), len(period)], model.key_qpos[0], np.zeros(model.nv)]
    lines += [[int(joint.qposadr[0]), int(joint.dofadr[0]), *gains] for joint in joints]
    lines += list(period[:, columns])
    text = "".join(" ".join(repr(x.item() if hasattr(x, "item") else x) for x in line) + "\n" for line in lines)
    setting.write_text(text, encoding="utf-8")
    return [file, setting]


def ours(program: Path, robot: Robot, controller: str) -> float:
    """Processor time of our command, s."""
    arguments = ["--friction", "on", "--load", "none", "--controller", controller, "--until", repr(DURATION)]
    method = ["--method", "event-driven", "--tolerance", "1e-8", "--json"]
    return cpu_time([program, "forward", robot.model, *arguments, *method])[0]


def theirs(harness: Path, arguments: list[Path]) -> float:
    """Processor time of MuJoCo's loop, s."""
    taken, error = map(float, cpu_time([harness, *arguments])[1].split())
    if not error < FOLLOWED:
        raise RuntimeError(f"MuJoCo does not follow the motion: error {error} m")
    return taken


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--stiction", type=Path, required=True, metavar="PATH", help="the program")
    parser.add_argument("--harness", type=Path, required=True, metavar="PATH", help="the compiled mujoco_simulation")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder for models and results")
    options = parser.parse_args()
    pin()
    ratios, rows = {}, []
    for robot in ROBOTS:
        arguments = for_mujoco(options.stiction, robot, options.out / robot.model)
        runs = {name: lambda name=name: ours(options.stiction, robot, name) for name in CONTROLLERS}
        times = alternate({**runs, "mujoco": lambda: theirs(options.harness, arguments)}, ROUNDS)
        ratio = max(times[name] for name in CONTROLLERS) / times["mujoco"]
        ratios[f"simulation_{robot.model}_vs_mujoco"] = ratio
        rows.append([f"`{robot.model}`", *(f"{time:.3f}" for time in times.values()), f"{ratio:.1f}"])
    columns = ["10 s of", *(f"`{name}`, s" for name in CONTROLLERS), "MuJoCo, s", "ratio"]
    print(json.dumps({"ratios": ratios, "tables": [{"columns": columns, "rows": rows}]}))


if __name__ == "__main__":
    main()
