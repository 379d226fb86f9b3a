"""The mechanism as `stiction convert --to json` describes it, and the kinematics of its joints.

Frames: W world; B a body; J a joint's frame fixed in its predecessor `from`; K that in its successor `to`.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from spatial import Array

GROUND = "ground"


@dataclass(frozen=True)
class Pose:
    """Pose of one frame in another: `rotation` has the axes as columns."""

    rotation: Array
    position: Array

    @staticmethod
    def read(data: dict) -> "Pose":
        return Pose(np.array(data["rotation"], float), np.array(data["position"], float))

    def __matmul__(self, other: "Pose") -> "Pose":
        return Pose(self.rotation @ other.rotation, self.rotation @ other.position + self.position)

    def point(self, p: Array) -> Array:
        return self.rotation @ p + self.position


@dataclass(frozen=True)
class Body:
    """`com` in the body's frame; `inertia` about the centre of mass, in the body's axes; `home` in the world."""

    name: str
    mass: float
    com: Array
    inertia: Array
    home: Pose


@dataclass(frozen=True)
class Freedom:
    name: str
    kind: str
    actuated: bool


@dataclass(frozen=True)
class Joint:
    name: str
    kind: str
    predecessor: str
    successor: str
    frame_from: Pose
    frame_to: Pose
    pitch: float | None
    freedoms: list[Freedom]
    contacts: list[dict] = field(default_factory=list)

    def frames(self, poses: dict[str, Pose]) -> tuple[Pose, Pose]:
        """J and K in the world."""
        return (
            poses[self.predecessor] @ self.frame_from,
            poses[self.successor] @ self.frame_to,
        )

    def twists(self, poses: dict[str, Pose]) -> Array:
        """Unit motions of the freedoms, 6 x f, [v, w] at the origin of J, world axes (docs/src/notation.md)."""
        frame_j, frame_k = self.frames(poses)
        xj, yj, zj = frame_j.rotation.T
        xk, yk, zk = frame_k.rotation.T
        lever = frame_j.position - frame_k.position  # from the origin of K to that of J

        def turn(axis: Array) -> Array:
            return np.concatenate([np.zeros(3), axis])

        def turn_about_k(axis: Array) -> Array:
            return np.concatenate([np.cross(axis, lever), axis])

        def slide(axis: Array) -> Array:
            return np.concatenate([axis, np.zeros(3)])

        columns = {
            "R": lambda: [turn(zj)],
            "P": lambda: [slide(zj)],
            "H": lambda: [np.concatenate([self.pitch * zj, zj])],
            "C": lambda: [turn(zj), slide(zj)],
            "U": lambda: [turn(zj), turn(xk)],
            "S": lambda: [turn(xk), turn(yk), turn(zk)],
            "E": lambda: [slide(xj), slide(yj), turn_about_k(zk)],
            "fixed": lambda: [],
            "free": lambda: [*map(slide, (xj, yj, zj)), *map(turn_about_k, (xk, yk, zk))],
        }[self.kind]()
        return np.array(columns).reshape(-1, 6).T

    def efforts(self, poses: dict[str, Pose]) -> Array:
        """Wrenches of unit efforts on the freedoms, 6 x f, [f, m] about the origin of J.

        Any wrenches with twists.T @ efforts = 1 will do: they differ by what the constraint carries.
        """
        return np.linalg.pinv(self.twists(poses)).T

    def constraints(self, poses: dict[str, Pose], length: float) -> Array:
        """Orthonormal wrenches that the joint carries, 6 x (6 - f), [f, m / length] about the origin of J."""
        twists = self.twists(poses)
        scaled = np.vstack([twists[:3], length * twists[3:]])
        basis = np.linalg.svd(scaled, full_matrices=True)[0] if scaled.size else np.eye(6)
        return basis[:, twists.shape[1] :]


@dataclass(frozen=True)
class Spring:
    name: str
    predecessor: str
    successor: str
    at_from: Array
    at_to: Array
    stiffness: float
    free_length: float
    damping: float


@dataclass(frozen=True)
class Mechanism:
    name: str
    gravity: Array
    length: float
    bodies: dict[str, Body]
    joints: dict[str, Joint]
    springs: list[Spring]

    def moving(self) -> list[str]:
        return [name for name in self.bodies if name != GROUND]

    def actuated(self) -> list[tuple[Joint, int]]:
        """All driven freedoms: the joint, and which of its freedoms."""
        return [
            (joint, k)
            for joint in self.joints.values()
            for k, freedom in enumerate(joint.freedoms)
            if freedom.actuated
        ]

    def home(self) -> dict[str, Pose]:
        return {name: body.home for name, body in self.bodies.items()}


def read_mechanism(path: Path) -> Mechanism:
    data = json.loads(path.read_text(encoding="utf-8"))
    if data["format"] != "stiction-mechanism" or data["version"] != 1:
        raise ValueError(f"{path}: not a description that this program reads")
    bodies = {
        b["name"]: Body(
            b["name"], b["mass"], np.array(b["com"], float), np.array(b["inertia"], float), Pose.read(b["home"])
        )
        for b in data["bodies"]
    }
    joints = {
        j["name"]: Joint(
            j["name"],
            j["type"],
            j["from"],
            j["to"],
            Pose.read(j["frame_from"]),
            Pose.read(j["frame_to"]),
            j.get("pitch"),
            [Freedom(f["name"], f["kind"], f["actuated"]) for f in j["dofs"]],
            j.get("friction") or [],
        )
        for j in data["joints"]
    }
    springs = [
        Spring(
            s["name"],
            s["from"],
            s["to"],
            np.array(s["point_from"], float),
            np.array(s["point_to"], float),
            s["stiffness"],
            s["free_length"],
            s["damping"],
        )
        for s in data["springs"]
    ]
    return Mechanism(
        data["name"], np.array(data["gravity"], float), data["characteristic_length"], bodies, joints, springs
    )
