"""Vectors of motion and force.

A *motion* is a 6-vector [v, w]: velocity (or acceleration) of a point, then angular velocity. A *wrench* is a
6-vector [f, m]: force, then moment about a point. With the same point and axes, wrench @ motion is a power.
All are in world axes and SI units unless a name says otherwise.
"""

from __future__ import annotations

import numpy as np

Array = np.ndarray


def skew(r: Array) -> Array:
    """The matrix of the cross product: skew(r) @ x = r x x."""
    return np.array([[0.0, -r[2], r[1]], [r[2], 0.0, -r[0]], [-r[1], r[0], 0.0]])


def rotation_from_quaternion(q: Array) -> Array:
    """Rotation matrix of a unit quaternion (w, x, y, z)."""
    w, x, y, z = q / np.linalg.norm(q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def quaternion_product(a: Array, b: Array) -> Array:
    """Product of quaternions (w, x, y, z)."""
    vector = a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:])
    return np.array([a[0] * b[0] - a[1:] @ b[1:], *vector])


def rotation_vector(rotation: Array) -> Array:
    """Axis times angle, below half a turn, exact for small angles."""
    axial = 0.5 * np.array(
        [
            rotation[2, 1] - rotation[1, 2],
            rotation[0, 2] - rotation[2, 0],
            rotation[1, 0] - rotation[0, 1],
        ]
    )
    sine = np.linalg.norm(axial)
    if sine < 1e-12:
        return axial
    return axial / sine * np.arctan2(sine, 0.5 * (np.trace(rotation) - 1.0))


def moved_wrench(wrench: Array, lever: Array) -> Array:
    """The same wrench about another point; `lever` leads from the new point to the old one."""
    return np.concatenate([wrench[:3], wrench[3:] + np.cross(lever, wrench[:3])])


def motion_shift(lever: Array) -> Array:
    """6x6: from the motion of one point of a body to that of another; `lever` leads to the new point."""
    shift = np.eye(6)
    shift[:3, 3:] = -skew(lever)
    return shift
