"""A crank under a torque that its static friction can bear: it stands still here, and creeps in MuJoCo.

MuJoCo's `frictionloss` is a soft constraint, a spring and damper towards no speed, bounded by a constant. Below its
bound it lets a joint move in proportion to the effort. It gets the same mechanism, the same torque, and the limits
that the program has found for each contact.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

import variants
from closed_loop import ClosedLoop
from engines.mujoco_tree import Mujoco
from friction import contact_name
from mechanism import Joint, Mechanism, read_mechanism
from program import Program
from spatial import Array
from tables import read_states, read_table

#: part of the way from the middle of the interval within which friction holds to its end
PART = 0.31
#: seconds that the program simulates, and MuJoCo; its rate is a mean over the second half
OURS, THEIRS = 1000.0, 1.0
#: a brake of 1 N m in the crank's pin: friction of 0.1 under a preload of 1 kN at 10 mm
BRAKE = '{ mu = 0.1, radius = "10 mm", preload = "1 kN" }'

#: a uniform link of 1 kg and 100 mm, with nothing but the brake; its axis is vertical
ALONE = f"""
title = "A crank with a brake"
gravity = [0, 0, "-9.81 m/s^2"]
[bodies.crank]
mass = "1 kg"
com = ["50 mm", 0, 0]
inertia = ["1e-5 kg m^2", "1 kg*(100 mm)^2/12", "1 kg*(100 mm)^2/12"]
[joints.A]
type = "R"
from = "ground"
to = "crank"
axis = "z"
actuated = true
friction = {BRAKE}
[motions.stand]
duration = "1 s"
A = "60 deg"
"""


@dataclass(frozen=True)
class Creep:
    """What the program's angle changed in all, rad, and rates in MuJoCo as it is and as hard as can be, rad/s."""

    model: str
    version: str
    torque: float
    limit: float
    moved: float
    mujoco: float
    mujoco_hard: float

    def complaints(self) -> list[str]:
        found = []
        if self.moved != 0.0:
            found.append(f"crank {self.model}: at {PART:.0%} of its limit moves by {self.moved:.1e} rad")
        # Were these not as described, the comparison would say something else.
        if not (abs(self.mujoco) > 1e-3 and abs(self.mujoco_hard) > 1e-9):
            found.append(f"crank {self.model}: MuJoCo does not creep: {self.mujoco:.1e}, {self.mujoco_hard:.1e} rad/s")
        return found


def measure(program: Program, folder: Path) -> list[Creep]:
    gallery = variants.physical(program.text("slider-crank"))
    plain = 'friction = { mu = "mu", radius = "pin" }'
    braked = gallery.replace(plain, f"friction = {BRAKE}", 1)
    if braked == gallery:
        raise RuntimeError("slider-crank has no such friction any more")
    texts = {"alone": ALONE, "of a slider-crank": braked}
    return [
        one(program, name, text, folder / f"creep-{number}") for number, (name, text) in enumerate(texts.items())
    ]


def one(program: Program, name: str, text: str, folder: Path) -> Creep:
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "crank.toml"
    path.write_text(text, encoding="utf-8")
    mechanism = read_mechanism(program.describe(str(path), folder, "json"))
    mjcf = program.describe(str(path), folder, "mjcf")
    at = "A = 60 deg"
    stand = f"{at}; duration = 0 s"
    rest = json.loads(program.call("breakaway", str(path), "--motion", stand, "--load", "none", "--json"))
    bounds = rest["drives"]["A"]
    limit = 0.5 * (bounds["high"] - bounds["low"])
    torque = 0.5 * (bounds["high"] + bounds["low"]) + PART * limit
    output = folder / "forward"
    program.call(
        *("forward", str(path), "--friction", "on", "--load", "none", "--drives", f"A = {torque!r}", "--from", at),
        *("--until", repr(OURS), "--step", repr(OURS / 4), "-o", str(output)),
    )
    names, rows = read_table(output / "forward.csv")
    angles = rows[:, names.index("A.position")]
    names, rows = read_table(output / "friction.csv")
    limits = {n[: -len(".limit")]: abs(rows[0, k]) for k, n in enumerate(names) if n.endswith(".limit")}
    first = read_states(output, mechanism)[0]
    q = ClosedLoop(Mujoco(mjcf, mechanism), mechanism).reproduce(first).q
    rates = [mujoco_rate(mjcf, mechanism, q, torque, limits, hard) for hard in (False, True)]
    return Creep(name, mujoco.__version__, torque, limit, float(np.max(np.abs(angles - angles[0]))), *rates)


def mujoco_rate(
    mjcf: Path, mechanism: Mechanism, q: Array, torque: float, limits: dict[str, float], hard: bool
) -> float:
    """Mean rate of the crank while its friction could hold it, rad/s."""
    model = mujoco.MjModel.from_xml_path(str(mjcf))
    for joint in mechanism.joints.values():
        dof = model.joint(joint.name).dofadr[0]
        model.dof_frictionloss[dof] = greatest_effort(joint, limits)
        if hard:  # the least compliance that MuJoCo allows
            model.dof_solimp[dof] = [0.9999, 0.9999, 0.001, 0.5, 2.0]
            model.dof_solref[dof] = [2.0 * model.opt.timestep, 1.0]
    data = mujoco.MjData(model)
    data.qpos[:] = q
    data.ctrl[model.actuator("A").id] = torque
    address = model.joint("A").qposadr[0]
    while data.time < 0.5 * THEIRS:
        mujoco.mj_step(model, data)
    time, angle = data.time, data.qpos[address]
    while data.time < THEIRS:
        mujoco.mj_step(model, data)
    return float((data.qpos[address] - angle) / (data.time - time))


def greatest_effort(joint: Joint, limits: dict[str, float]) -> float:
    """The friction before sliding of a joint with one freedom, N or N m."""
    return sum(limits[contact_name(joint, c)] * (c["radius"] or 1.0) for c in joint.contacts)
