"""What is asked of an engine that knows open trees of bodies: MuJoCo, Pinocchio, Drake.

None of them has a call for the inverse dynamics of closed loops with all reactions. Each reads the exported MJCF
file, and is asked for its kinematics, its open-tree inverse dynamics and its joint reactions; `closed_loop.py`
puts the loops together.
"""

from __future__ import annotations

import xml.etree.ElementTree as xml
from abc import ABC, abstractmethod
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mechanism import Pose
from spatial import Array, rotation_from_quaternion


@dataclass(frozen=True)
class Closure:
    """A point of body a that is held at a point of body b; of a weld also the rotation of b in a."""

    joint: str
    body_a: str
    point_a: Array
    body_b: str
    point_b: Array
    rotation: Array | None = None


class TreeEngine(ABC):
    """Generalised coordinates q, velocities v, accelerations and forces are the engine's own."""

    name: str
    version: str
    nv: int
    #: tree parent of each body by the exported file, the ground among them
    parents: dict[str, str]
    closures: list[Closure]
    #: bodies that the engine has made one with their parents
    merged: frozenset[str] = frozenset()

    @abstractmethod
    def neutral(self) -> Array:
        """The file's position."""

    @abstractmethod
    def integrate(self, q: Array, dv: Array) -> Array:
        """q moved by dv."""

    @abstractmethod
    def kinematics(self, q: Array) -> tuple[dict[str, Pose], dict[str, Array]]:
        """Pose of every body in the world, and the 6 x nv Jacobian of its motion [v, w] at its origin."""

    @abstractmethod
    def bias(self, q: Array, v: Array) -> dict[str, Array]:
        """Acceleration [a, alpha] of every body's origin while v does not change."""

    @abstractmethod
    def inverse_dynamics(self, q: Array, v: Array, a: Array) -> Array:
        """Forces that the open tree needs under its own weight, without loads, springs and loops."""

    def drive(self, q: Array, names: tuple[str, ...]) -> Array | None:
        """Generalised forces of a unit of the file's drive with the first of these names, if the engine reads them."""
        return None

    def springs(self, q: Array, v: Array) -> Array | None:
        """Generalised forces of the springs, if the engine has such springs; it then has them in its reactions."""
        return None

    @abstractmethod
    def reactions(
        self, q: Array, v: Array, a: Array, tau: Array, loads: dict[str, Array]
    ) -> dict[str, Array]:
        """Wrench [f, m] of each body's tree parent on it, about its origin, world axes.

        `loads` are about the origins of bodies, world axes; `tau` acts in the joints of the tree. Springs that the
        engine has itself are not among them.
        Bodies are missing for which the engine does not say it.
        """


def read_tree(path: Path) -> dict[str, str]:
    """Tree parent of each body in an MJCF file."""
    parents: dict[str, str] = {}

    def visit(element: xml.Element, parent: str) -> None:
        for child in element.findall("body"):
            parents[child.get("name")] = parent
            visit(child, child.get("name"))

    visit(xml.parse(path).getroot().find("worldbody"), "world")
    return parents


def read_closures(path: Path) -> list[Closure]:
    """The equalities between sites of an MJCF file, for an engine that does not keep them."""
    root = xml.parse(path).getroot()
    sites: dict[str, tuple[str, Pose]] = {}
    for body in root.find("worldbody").iter("body"):
        for site in body.findall("site"):
            sites[site.get("name")] = body.get("name"), read_pose(site)
    closures = []
    for element in root.iterfind("equality/*"):
        (a, in_a), (b, in_b) = sites[element.get("site1")], sites[element.get("site2")]
        if element.tag not in ("connect", "weld"):
            raise NotImplementedError(f"an equality of the kind {element.tag}")
        rotation = in_a.rotation @ in_b.rotation.T if element.tag == "weld" else None
        closures.append(Closure(joint_closed_by(element.get("name")), a, in_a.position, b, in_b.position, rotation))
    return closures


def joint_closed_by(equality: str) -> str:
    """The joint an equality stands for: a weld of two parts of one body is named after the joint between them."""
    return equality.removesuffix(".weld")


def read_pose(element: xml.Element) -> Pose:
    rotation = rotation_from_quaternion(vector(element.get("quat", "1 0 0 0")))
    return Pose(rotation, vector(element.get("pos", "0 0 0")))


def vector(text: str) -> Array:
    return np.array([float(x) for x in text.split()])
