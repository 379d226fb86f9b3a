"""What a Python user gets: closed-loop inverse dynamics with all joint reactions through the engines' Python interfaces.

The other engines are used as in the C++ harnesses, with numpy between the engines' calls. None of them has a call for
many states at once, so a batch is a loop. Stiction's package has both: a call for one state and a call for many, beside
which the same call from Rust runs in alternation. The program's own cost for each sample stands below, everything
written to files.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import mujoco  # noqa: E402
import numpy as np  # noqa: E402
import pinocchio as pin  # noqa: E402

import stiction  # noqa: E402

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "validation"))

from closed_loop import ClosedLoop  # noqa: E402
from engines.drake_tree import Drake as DrakeTree  # noqa: E402
from engines.mujoco_tree import Mujoco as MujocoTree  # noqa: E402
from engines.pinocchio_tree import Pinocchio as PinocchioTree  # noqa: E402
from mechanism import Mechanism, read_mechanism  # noqa: E402
from pydrake.common.value import Value  # noqa: E402
from pydrake.multibody.math import SpatialForce  # noqa: E402
from pydrake.multibody.plant import ExternallyAppliedSpatialForce  # noqa: E402
from pydrake.multibody.tree import JacobianWrtVariable, MultibodyForces  # noqa: E402
from spatial import Array  # noqa: E402
from tables import Sample, read_samples  # noqa: E402

ROUNDS = 40
#: relative differences of driving forces above which times mean nothing
LIMIT = 1e-10
#: times between samples of the two runs of the program whose difference is taken, s
STEPS = {"3rps": (0.01, 0.0002)}
#: neighbouring states in a batch of our package
BATCH = 10_000
#: friction of our calls, by the last part of their names
FRICTION = {"frictionless": False, "friction": True}


def cross(a: Array, b: Array) -> Array:
    """numpy's own takes ten times as long for two vectors."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


class Peer:
    """An engine whose loops are closed here: q, v, a of each sample, and which rows are driven."""

    def __init__(self, tree, mechanism: Mechanism, samples: list[Sample]) -> None:
        self.tree = tree
        loop = ClosedLoop(tree, mechanism)
        self.loaded = [name for name in tree.parents if any(np.any(s.loads.get(name, 0.0)) for s in samples)]
        self.states = []
        for sample in samples:
            loop.place(sample)
            _, jacobians = tree.kinematics(loop.q)
            v, _ = loop.rates(jacobians, {name: sample.motions[body] for name, body in loop.owner.items()})
            bias = tree.bias(loop.q, v)
            wanted = {name: sample.accelerations[body] - bias[name] for name, body in loop.owner.items()}
            a, _ = loop.rates(jacobians, wanted)
            loads = [sample.loads[name] for name in self.loaded]
            self.states.append((loop.q.copy(), v, a, loads))
        joints = [joint.name for joint, _ in mechanism.actuated()]
        self.driven = np.array([self.row(name) for name in joints])
        self.undriven = np.setdiff1d(np.arange(tree.nv), self.driven)
        self.prepare()

    def close(self, needed: Array, rows: Array) -> tuple[Array, Array]:
        """Closing forces from the rows without a drive, drives from the others."""
        forces = np.linalg.solve(rows[:, self.undriven].T, needed[self.undriven])
        return needed[self.driven] - rows[:, self.driven].T @ forces, forces

    def row(self, joint: str) -> int:
        raise NotImplementedError

    def prepare(self) -> None: ...

    def solve(self, q: Array, v: Array, a: Array, loads: list[Array]) -> Array:
        """Drives; the reactions are left in the engine's data."""
        raise NotImplementedError


class Mujoco(Peer):
    what = "mj_rne, mj_jacSite, numpy, mj_rnePostConstraint"

    def row(self, joint: str) -> int:
        return int(self.tree.model.joint(joint).dofadr[0])

    def prepare(self) -> None:
        self.model, self.data = self.tree.model, self.tree.data
        m = self.model
        self.sites = [(int(m.eq_obj1id[i]), int(m.eq_obj2id[i])) for i in range(m.neq)]
        self.bodies = [self.tree.ids[name] for name in self.loaded]
        self.needed = np.zeros(m.nv)
        self.rows = np.zeros((3 * m.neq, m.nv))
        self.other, self.of_body = np.zeros((3, m.nv)), np.zeros((6, m.nv))

    def apply(self, body: int, point: Array, force: Array, moment: Array | float) -> None:
        load = self.data.xfrc_applied[body]
        load[:3] += force
        load[3:] += moment + cross(point - self.data.xipos[body], force)

    def solve(self, q: Array, v: Array, a: Array, loads: list[Array]) -> Array:
        m, d = self.model, self.data
        d.qpos[:], d.qvel[:], d.qacc[:] = q, v, a
        mujoco.mj_kinematics(m, d)
        mujoco.mj_comPos(m, d)
        mujoco.mj_comVel(m, d)
        mujoco.mj_rne(m, d, 1, self.needed)
        needed = self.needed
        d.xfrc_applied[:] = 0.0
        for body, load in zip(self.bodies, loads):
            mujoco.mj_jacBody(m, d, self.of_body[:3], self.of_body[3:], body)
            needed = needed - self.of_body.T @ load
            self.apply(body, d.xpos[body], load[:3], load[3:])
        for i, (site_a, site_b) in enumerate(self.sites):
            rows = self.rows[3 * i : 3 * i + 3]
            mujoco.mj_jacSite(m, d, rows, None, site_b)
            mujoco.mj_jacSite(m, d, self.other, None, site_a)
            rows -= self.other
        drives, forces = self.close(needed, self.rows)
        for i, (site_a, site_b) in enumerate(self.sites):
            force = forces[3 * i : 3 * i + 3]
            self.apply(m.site_bodyid[site_a], d.site_xpos[site_a], -force, 0.0)
            self.apply(m.site_bodyid[site_b], d.site_xpos[site_b], force, 0.0)
        mujoco.mj_rnePostConstraint(m, d)
        return drives


class Pinocchio(Peer):
    what = "rnea, getConstraintsJacobian, numpy, rnea with the closing forces"

    def row(self, joint: str) -> int:
        model = self.tree.model
        return int(model.joints[model.getJointId(joint)].idx_v)

    def prepare(self) -> None:
        model, tree = self.tree.model, self.tree
        self.model, self.data = model, model.createData()
        self.ends, self.constraints = [], pin.StdVec_RigidConstraintModel()
        for closure in tree.closures:
            pair = []
            for body, point in ((closure.body_a, closure.point_a), (closure.body_b, closure.point_b)):
                frame = model.frames[tree.frames[body]]
                pair.append((frame.parentJoint, pin.SE3(np.eye(3), frame.placement.act(point))))
            self.ends.append(pair)
            (a, at_a), (b, at_b) = pair
            kind, axes = pin.ContactType.CONTACT_3D, pin.ReferenceFrame.LOCAL
            self.constraints.append(pin.RigidConstraintModel(kind, model, a, at_a, b, at_b, axes))
        self.constraint_data = pin.StdVec_RigidConstraintData()
        for constraint in self.constraints:
            self.constraint_data.append(constraint.createData())
        self.bodies = []
        for name in self.loaded:
            frame = model.frames[tree.frames[name]]
            self.bodies.append((frame.parentJoint, frame.placement.translation))
        self.external = pin.StdVec_Force()
        for _ in range(model.njoints):
            self.external.append(pin.Force.Zero())

    def solve(self, q: Array, v: Array, a: Array, loads: list[Array]) -> Array:
        model, data, external = self.model, self.data, self.external
        pin.computeJointJacobians(model, data, q)
        for joint in range(model.njoints):
            external[joint] = pin.Force.Zero()
        for (joint, at), load in zip(self.bodies, loads):
            turned = data.oMi[joint].rotation.T
            force = turned @ load[:3]
            external[joint] += pin.Force(force, turned @ load[3:] + cross(at, force))
        needed = pin.rnea(model, data, q, v, a, external)
        for constraint, its_data in zip(self.constraints, self.constraint_data):
            constraint.calc(model, data, its_data)
        rows = pin.getConstraintsJacobian(model, data, self.constraints, self.constraint_data)
        drives, multipliers = self.close(needed, rows)
        for i, pair in enumerate(self.ends):
            # The multipliers are in the axes of the joint of the first point, with the force on its body.
            (joint_a, at_a), (joint_b, at_b) = pair
            force = multipliers[3 * i : 3 * i + 3]
            external[joint_a] += pin.Force(force, cross(at_a.translation, force))
            on_b = data.oMi[joint_b].rotation.T @ (data.oMi[joint_a].rotation @ -force)
            external[joint_b] += pin.Force(on_b, cross(at_b.translation, on_b))
        # Both passes have all loads now: what is left is what the drives do.
        return pin.rnea(model, data, q, v, a, external)[self.driven]


class Drake(Peer):
    what = "CalcInverseDynamics, CalcJacobianTranslationalVelocity, numpy, the port of reaction forces"

    def row(self, joint: str) -> int:
        return int(self.tree.plant.GetJointByName(joint).velocity_start())

    def prepare(self) -> None:
        tree = self.tree
        self.plant, self.context = tree.plant, tree.context
        self.frames = {name: body.body_frame() for name, body in tree.bodies.items()}
        self.plant.get_actuation_input_port().FixValue(self.context, np.zeros(tree.at_rest))

    def force_on(self, name: str, point: Array, force: Array, moment: Array) -> ExternallyAppliedSpatialForce:
        applied = ExternallyAppliedSpatialForce()
        applied.body_index = self.tree.bodies[name].index()
        applied.p_BoBq_B = point
        applied.F_Bq_W = SpatialForce(tau=moment, f=force)
        return applied

    def solve(self, q: Array, v: Array, a: Array, loads: list[Array]) -> Array:
        plant, context, none = self.plant, self.context, np.zeros(3)
        plant.SetPositions(context, q)
        plant.SetVelocities(context, v)
        forces = MultibodyForces(plant)
        plant.CalcForceElementsContribution(context, forces)
        needed = plant.CalcInverseDynamics(context, a, forces)
        world = plant.world_frame()
        applied = []
        for name, load in zip(self.loaded, loads):
            jacobian = plant.CalcJacobianSpatialVelocity(
                context, JacobianWrtVariable.kV, self.frames[name], none, world, world
            )
            needed = needed - jacobian.T @ np.concatenate([load[3:], load[:3]])
            applied.append(self.force_on(name, none, load[:3], load[3:]))
        rows = []
        for c in self.tree.closures:
            ends = (
                plant.CalcJacobianTranslationalVelocity(
                    context, JacobianWrtVariable.kV, self.frames[body], point, world, world
                )
                for body, point in ((c.body_b, c.point_b), (c.body_a, c.point_a))
            )
            rows.append(next(ends) - next(ends))
        drives, closing = self.close(needed, np.vstack(rows))
        for i, c in enumerate(self.tree.closures):
            force = closing[3 * i : 3 * i + 3]
            applied.append(self.force_on(c.body_b, c.point_b, force, none))
            applied.append(self.force_on(c.body_a, c.point_a, -force, none))
        tau = np.zeros(self.tree.nv)
        tau[self.driven] = drives
        plant.get_applied_generalized_force_input_port().FixValue(context, tau)
        port = plant.get_applied_spatial_force_input_port()
        port.FixValue(context, Value[list[ExternallyAppliedSpatialForce]](applied))
        plant.get_reaction_forces_output_port().Eval(context)
        return drives


class Package:
    """Our Python package, and the same call from Rust in a process of its own."""

    def __init__(self, model: str, ours: Path, folder: Path) -> None:
        self.model = stiction.load(model)
        run = self.model.inverse()
        columns = [run.joint[name] for name in self.model.actuators]
        self.samples = [np.column_stack([getattr(c, x) for c in columns]) for x in ("position", "rate", "acceleration")]
        n = len(self.samples[0])
        at = np.linspace(0, n - 1, BATCH)
        self.batch = [np.column_stack([np.interp(at, range(n), x) for x in array.T]) for array in self.samples]
        efforts = [self.call(self.batch, friction).efforts for friction in FRICTION.values()]
        rows = folder / "rows.txt"
        lines = [" ".join(map(repr, row)) for row in np.hstack([*self.batch, *efforts]).tolist()]
        rows.write_text(f"rows {BATCH} {len(columns)}\n" + "\n".join(lines) + "\n", encoding="utf-8")
        command = [str(ours), model, "--rows", str(rows)]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.from_rust: dict[str, float] = {}
        while (line := self.process.stdout.readline().split()) and line[0] == "subject":
            self.from_rust[line[1].removeprefix("rows_")] = float(line[2])

    def call(self, states: list[Array], friction: bool) -> stiction.InverseDynamics:
        """Efforts and all reactions, one thread."""
        return self.model.inverse_dynamics(*states, friction=friction, reactions=True).check()

    def difference(self, samples: list[Sample]) -> float:
        """Largest relative difference of frictionless drives; infinite if Rust has other bits."""
        wanted = np.array([sample.drives for sample in samples])
        found = np.max(np.abs(self.call(self.samples, False).efforts - wanted)) / np.max(np.abs(wanted))
        return max(float(found), *self.from_rust.values()) if self.from_rust.keys() == FRICTION.keys() else np.inf

    def times(self) -> dict[str, float]:
        """Of each state in each kind of call, s."""
        taken = {}
        for name, friction in FRICTION.items():
            solve = self.model.inverse_dynamics
            begun = time.perf_counter()
            for q, v, a in zip(*self.samples):
                solve(q, v, a, friction=friction, reactions=True)
            taken[f"row_{name}"] = (time.perf_counter() - begun) / len(self.samples[0])
            begun = time.perf_counter()
            solve(*self.batch, friction=friction, reactions=True)
            taken[f"batch_{name}"] = (time.perf_counter() - begun) / BATCH
            self.process.stdin.write(f"rows_{name} {BATCH}\n")
            self.process.stdin.flush()
            taken[f"rust_{name}"] = float(self.process.stdout.readline()) * 1e-9
        return taken


def difference(peer: Peer, samples: list[Sample]) -> float:
    drives = np.array([peer.solve(*state) for state in peer.states])
    wanted = np.array([sample.drives for sample in samples])
    return float(np.max(np.abs(drives - wanted)) / np.max(np.abs(wanted)))


def program_times(program: Path, model: str, friction: str, folder: str) -> tuple[float, float]:
    """Of one run along the default motion, and of each further sample, s."""
    taken, samples = [], []
    for step in STEPS[model]:
        command = [str(program), "inverse", model, "--friction", friction, "--step", repr(step), "-o", folder]
        begun = time.perf_counter()
        subprocess.run(command, check=True, capture_output=True)
        taken.append(time.perf_counter() - begun)
        with (Path(folder) / "inverse.csv").open(encoding="utf-8") as file:
            samples.append(sum(1 for _ in file) - 1)
    return taken[0], (taken[1] - taken[0]) / (samples[1] - samples[0])


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--stiction", type=Path, required=True, metavar="PATH", help="the program")
    parser.add_argument("--ours", type=Path, required=True, metavar="PATH", help="our side of the comparison")
    parser.add_argument("--states", type=Path, required=True, metavar="DIR", help="what states.py has written")
    parser.add_argument("model", choices=STEPS, help="of the gallery")
    options = parser.parse_args()
    folder = options.states / options.model
    mechanism = read_mechanism(folder / "mechanism.json")
    samples = read_samples(folder / "off", mechanism)
    mjcf = folder / "mechanism.mjcf"
    peers = {
        "mujoco": Mujoco(MujocoTree(mjcf, mechanism), mechanism, samples),
        "pinocchio": Pinocchio(PinocchioTree(mjcf, mechanism), mechanism, samples),
        "drake": Drake(DrakeTree(mjcf, mechanism), mechanism, samples),
    }
    package = Package(options.model, options.ours, folder)
    differences = {name: difference(peer, samples) for name, peer in peers.items()}
    differences["stiction"] = package.difference(samples)
    for name, found in differences.items():
        if not found <= LIMIT:
            print(f"{name}: driving forces differ by {found:.1e}", file=sys.stderr)
            return 1
    times: dict[str, list[float]] = {name: [] for name in peers}
    ours: dict[str, list[float]] = {}
    runs: dict[str, list[tuple[float, float]]] = {"off": [], "on": []}
    with tempfile.TemporaryDirectory() as temporary:
        for round_number in range(ROUNDS):
            for name, peer in peers.items():
                begun = time.perf_counter()
                for state in peer.states:
                    peer.solve(*state)
                times[name].append((time.perf_counter() - begun) / len(peer.states))
            for name, taken in package.times().items():
                ours.setdefault(name, []).append(taken)
            if round_number % 8 == 0:
                for friction in runs:
                    runs[friction].append(program_times(options.stiction, options.model, friction, temporary))
    rows = [
        {
            "engine": name,
            "task": "inverse",
            "what": f"each state of a loop: {peers[name].what}",
            "median_ns": float(np.median(times[name])) * 1e9,
            "minimum_ns": min(times[name]) * 1e9,
            "difference": differences[name],
        }
        for name in peers
    ]
    calls = {
        "row": "each state of a loop: inverse_dynamics with reactions, loops closed and checked",
        "batch": f"each of {BATCH} neighbouring states in one such call, one thread",
        "rust": f"the same {BATCH} states in the same call from Rust",
    }
    for name, taken in ours.items():
        row = {"engine": "stiction", "task": name, "what": calls[name.split("_")[0]], "difference": differences["stiction"]}
        rows.append({**row, "median_ns": float(np.median(taken)) * 1e9, "minimum_ns": min(taken) * 1e9})
    for friction, task in (("off", "frictionless"), ("on", "friction")):
        whole, each = np.array(runs[friction]).T
        for numbers, what in (
            (each, "each sample of the program `stiction inverse -o`, everything checked and written"),
            (whole, f"one run of the program, {len(samples)} samples and plots"),
        ):
            kind = "sample" if numbers is each else "run"
            row = {"engine": "stiction", "task": f"{kind}_{task}", "what": what}
            rows.append({**row, "median_ns": float(np.median(numbers)) * 1e9, "minimum_ns": float(min(numbers)) * 1e9})
    ratios = {
        f"python_{name}_vs_rust": float(np.median(np.divide(ours[f"batch_{name}"], ours[f"rust_{name}"])))
        for name in FRICTION
    }
    for name in FRICTION:
        for peer in ("mujoco", "pinocchio"):
            ratio = np.median(np.divide(ours[f"row_{name}"], times[peer]))
            ratios[f"python_row_{name}_vs_{peer}_in_python"] = float(ratio)
    print(json.dumps({"model": options.model, "rows": rows, "ratios": ratios}))
    return 0


if __name__ == "__main__":
    sys.exit(main())
