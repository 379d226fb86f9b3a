"""MuJoCo: `mj_inverse` without equalities, `mj_rnePostConstraint` for the reactions.

With equalities `mj_inverse` returns the torques of the open tree all the same: the soft constraints of a motion
that is consistent have no force. So they are switched off here, and only their places are read.
"""

from __future__ import annotations

from contextlib import contextmanager
from pathlib import Path
from typing import Iterator

import mujoco
import numpy as np

from engines.tree import Closure, TreeEngine, joint_closed_by, read_tree
from mechanism import Mechanism, Pose
from spatial import Array, moved_wrench, rotation_from_quaternion


class Mujoco(TreeEngine):
    name = "MuJoCo"
    version = mujoco.__version__

    def __init__(self, mjcf: Path, mechanism: Mechanism) -> None:
        self.model = mujoco.MjModel.from_xml_path(str(mjcf))
        disabled = mujoco.mjtDisableBit
        for bit in ("mjDSBL_EQUALITY", "mjDSBL_CONTACT", "mjDSBL_FRICTIONLOSS", "mjDSBL_SPRING", "mjDSBL_DAMPER"):
            self.model.opt.disableflags |= int(getattr(disabled, bit))
        self.model.dof_damping[:] = 0.0  # friction comes as a load, with its viscous part
        self.data = mujoco.MjData(self.model)
        self.nv = self.model.nv
        self.parents = read_tree(mjcf)
        self.ids = {name: self.model.body(name).id for name in self.parents}
        self.closures = [self._closure(i) for i in range(self.model.neq)]

    def _closure(self, i: int) -> Closure:
        """Equalities are between sites of bodies: points, or frames of a weld."""
        model = self.model
        kinds = {int(mujoco.mjtEq.mjEQ_CONNECT): False, int(mujoco.mjtEq.mjEQ_WELD): True}
        weld = kinds[int(model.eq_type[i])]
        if int(model.eq_objtype[i]) != int(mujoco.mjtObj.mjOBJ_SITE):
            raise NotImplementedError("an equality that is not between sites")
        sites = int(model.eq_obj1id[i]), int(model.eq_obj2id[i])
        a, b = (model.body(int(model.site_bodyid[site])).name for site in sites)
        points = [model.site_pos[site].copy() for site in sites]
        turns = [rotation_from_quaternion(model.site_quat[site]) for site in sites]
        rotation = turns[0] @ turns[1].T if weld else None
        return Closure(joint_closed_by(model.equality(i).name), a, points[0], b, points[1], rotation)

    def neutral(self) -> Array:
        return self.model.qpos0.copy()

    def integrate(self, q: Array, dv: Array) -> Array:
        moved = q.copy()
        mujoco.mj_integratePos(self.model, moved, dv, 1.0)
        return moved

    def _place(self, q: Array, v: Array | None = None) -> None:
        self.data.qpos[:] = q
        self.data.qvel[:] = 0.0 if v is None else v
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)
        mujoco.mj_comVel(self.model, self.data)

    def kinematics(self, q: Array) -> tuple[dict[str, Pose], dict[str, Array]]:
        self._place(q)
        poses, jacobians = {}, {}
        for name, index in self.ids.items():
            poses[name] = Pose(self.data.xmat[index].reshape(3, 3).copy(), self.data.xpos[index].copy())
            jacobian = np.zeros((6, self.nv))
            mujoco.mj_jacBody(self.model, self.data, jacobian[:3], jacobian[3:], index)
            jacobians[name] = jacobian
        return poses, jacobians

    def bias(self, q: Array, v: Array) -> dict[str, Array]:
        self._place(q, v)
        result = {}
        for name, index in self.ids.items():
            rate = np.zeros((6, self.nv))
            mujoco.mj_jacDot(self.model, self.data, rate[:3], rate[3:], self.data.xpos[index], index)
            result[name] = rate @ v
        return result

    def inverse_dynamics(self, q: Array, v: Array, a: Array) -> Array:
        self._set(q, v, a)
        mujoco.mj_inverse(self.model, self.data)
        return self.data.qfrc_inverse.copy()

    def _set(self, q: Array, v: Array, a: Array) -> None:
        self.data.qpos[:], self.data.qvel[:], self.data.qacc[:] = q, v, a
        self.data.xfrc_applied[:] = 0.0

    def drive(self, q: Array, names: tuple[str, ...]) -> Array | None:
        """The file's motors: the first of the names that it has."""
        index = next(i for name in names for i in range(self.model.nu) if self.model.actuator(i).name == name)
        self._place(q)
        mujoco.mj_transmission(self.model, self.data)
        self.data.ctrl[:] = 0.0
        self.data.ctrl[index] = 1.0
        mujoco.mj_fwdActuation(self.model, self.data)
        return self.data.qfrc_actuator.copy()

    def springs(self, q: Array, v: Array) -> Array | None:
        """The springs are tendons between two sites."""
        if self.model.ntendon == 0:
            return None
        with self._springs_on():
            self._set(q, v, np.zeros(self.nv))
            mujoco.mj_fwdPosition(self.model, self.data)
            mujoco.mj_fwdVelocity(self.model, self.data)
        return self.data.qfrc_spring + self.data.qfrc_damper

    @contextmanager
    def _springs_on(self) -> Iterator[None]:
        flags, bits = self.model.opt.disableflags, mujoco.mjtDisableBit
        self.model.opt.disableflags = flags & ~int(bits.mjDSBL_SPRING) & ~int(bits.mjDSBL_DAMPER)
        yield
        self.model.opt.disableflags = flags

    def reactions(
        self, q: Array, v: Array, a: Array, tau: Array, loads: dict[str, Array]
    ) -> dict[str, Array]:
        """`cfrc_int` is [moment, force] about the centre of mass of the whole tree. It does not ask for `tau`."""
        self._set(q, v, a)
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)
        for name, index in self.ids.items():
            if name in loads:
                lever = self.data.xpos[index] - self.data.xipos[index]
                self.data.xfrc_applied[index] = moved_wrench(loads[name], lever)
        with self._springs_on():
            mujoco.mj_inverse(self.model, self.data)
            mujoco.mj_rnePostConstraint(self.model, self.data)
        result = {}
        for name in self.parents:
            index = self.ids[name]
            moment, force = self.data.cfrc_int[index, :3], self.data.cfrc_int[index, 3:]
            lever = self.data.subtree_com[self.model.body_rootid[index]] - self.data.xpos[index]
            result[name] = moved_wrench(np.concatenate([force, moment]), lever)
        return result
