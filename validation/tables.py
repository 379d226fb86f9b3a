"""What `stiction inverse -o DIR` wrote, sample by sample, as numbers with names."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mechanism import GROUND, Mechanism, Pose
from spatial import Array, rotation_from_quaternion


@dataclass(frozen=True)
class Sample:
    """One instant.

    Motions, accelerations [v, w] and loads [f, m] of bodies are about the origin of the body's frame; reactions
    are those of `from` on `to` about the origin of J; all in world axes. Contacts are keyed by their names.
    """

    time: float
    poses: dict[str, Pose]
    motions: dict[str, Array]
    accelerations: dict[str, Array]
    loads: dict[str, Array]
    drives: Array
    reactions: dict[str, Array]
    determined: dict[str, bool]
    speeds: dict[str, float]
    contact_loads: dict[str, float]
    frictions: dict[str, float]


def read_table(path: Path) -> tuple[list[str], Array]:
    """Names of the columns without their units, and the rows."""
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file))
    names = [name.split(" [")[0] for name in rows[0]]
    return names, np.array([[float(x) for x in row] for row in rows[1:]]).reshape(-1, len(names))


class Row:
    """One row of a table, by names of columns."""

    def __init__(self, names: list[str], values: Array) -> None:
        self.values = dict(zip(names, values))

    def of(self, prefix: str, *keys: str) -> Array:
        return np.array([self.values[f"{prefix}.{key}"] for key in keys])


def drive_names(mechanism: Mechanism) -> list[str]:
    """Names of the drives as in inverse.csv: with the freedom's name if the joint has several drives."""
    driven = mechanism.actuated()
    joints = [joint.name for joint, _ in driven]
    return [
        joint.name if joints.count(joint.name) == 1 else f"{joint.name}.{joint.freedoms[k].name}"
        for joint, k in driven
    ]


def read_samples(folder: Path, mechanism: Mechanism) -> list[Sample]:
    tables = {name: read_table(folder / f"{name}.csv") for name in ("bodies", "inverse", "reactions", "friction")}
    count = len(tables["bodies"][1])
    return [
        read_sample({name: Row(names, rows[i]) for name, (names, rows) in tables.items()}, mechanism)
        for i in range(count)
    ]


def read_states(folder: Path, mechanism: Mechanism) -> list[Sample]:
    """The motion that `stiction forward -o DIR` wrote: times, poses, motions and accelerations, nothing else."""
    names, rows = read_table(folder / "bodies.csv")
    states = []
    for values in rows:
        row = Row(names, values)
        poses, motions, accelerations, loads = read_bodies(row, mechanism)
        states.append(
            Sample(
                float(row.values["time"]), poses, motions, accelerations, loads, np.zeros(0), {}, {}, {}, {}, {}
            )
        )
    return states


def read_bodies(bodies: Row, mechanism: Mechanism) -> tuple[dict, dict, dict, dict]:
    """Poses, motions, accelerations and loads of all bodies and of the ground."""
    poses = {GROUND: mechanism.bodies[GROUND].home}
    still = np.zeros(6)
    motions, accelerations, loads = {GROUND: still}, {GROUND: still}, {GROUND: still}
    for name in mechanism.moving():
        rotation = rotation_from_quaternion(bodies.of(name, "qw", "qx", "qy", "qz"))
        poses[name] = Pose(rotation, bodies.of(name, "x", "y", "z"))
        motions[name] = bodies.of(name, "vx", "vy", "vz", "wx", "wy", "wz")
        accelerations[name] = bodies.of(name, "ax", "ay", "az", "alphax", "alphay", "alphaz")
        loads[name] = bodies.of(name, "fx", "fy", "fz", "mx", "my", "mz")
    return poses, motions, accelerations, loads


def read_sample(rows: dict[str, Row], mechanism: Mechanism) -> Sample:
    bodies, reactions, friction = rows["bodies"], rows["reactions"], rows["friction"]
    poses, motions, accelerations, loads = read_bodies(bodies, mechanism)
    # Free joints carry nothing and have no columns.
    joints = [name for name in mechanism.joints if f"{name}.fx" in reactions.values]
    contacts = [key[: -len(".load")] for key in friction.values if key.endswith(".load")]
    return Sample(
        time=float(bodies.values["time"]),
        poses=poses,
        motions=motions,
        accelerations=accelerations,
        loads=loads,
        drives=np.array([rows["inverse"].values[f"{name}.drive"] for name in drive_names(mechanism)]),
        reactions={name: reactions.of(name, "fx", "fy", "fz", "mx", "my", "mz") for name in joints},
        determined={name: reactions.values[f"{name}.determined"] == 1 for name in joints},
        speeds={name: friction.values[f"{name}.speed"] for name in contacts},
        contact_loads={name: friction.values[f"{name}.load"] for name in contacts},
        frictions={name: friction.values[f"{name}.friction"] for name in contacts},
    )
