"""Writes what the harnesses are fed with: engines' models, and states along a model's default motion.

`stiction` gives the motion of all bodies and what it says about the forces. For each engine the coordinates of its own
tree are found from the motion of the bodies, by the code that also validates (`validation/closed_loop.py`). Files, all of
numbers in SI units, are described in `README.md`.
"""

from __future__ import annotations

import argparse
import sys
import xml.etree.ElementTree as xml
from pathlib import Path

import numpy as np
import pinocchio as pin

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "validation"))

from closed_loop import ClosedLoop  # noqa: E402
from engines.mujoco_tree import Mujoco  # noqa: E402
from engines.pinocchio_tree import Pinocchio  # noqa: E402
from mechanism import GROUND, Mechanism, read_mechanism  # noqa: E402
from program import Program  # noqa: E402
from spatial import Array, moved_wrench  # noqa: E402
from tables import Sample, read_samples  # noqa: E402

#: an engine's own places and motions of the bodies must be ours to this, m and relative; it is rounding
STATE_LIMIT = 1e-11


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--stiction", type=Path, required=True, metavar="PATH", help="the program")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="where the files go")
    parser.add_argument("models", nargs="+", metavar="MODEL", help="of the gallery")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    for model in options.models:
        write_model(Program(options.stiction), model, options.out)
    return 0


def write_model(program: Program, model: str, out: Path) -> None:
    folder = out / model
    folder.mkdir(parents=True, exist_ok=True)
    mechanism = read_mechanism(program.describe(model, folder, "json"))
    mjcf = program.describe(model, folder, "mjcf")
    samples = {}
    for friction in ("off", "on"):
        program.call("inverse", model, "--friction", friction, "-o", str(folder / friction))
        samples[friction] = read_samples(folder / friction, mechanism)

    (out / f"{model}.ours.txt").write_text(ours(mechanism, samples), encoding="utf-8")
    lean = leaner(mjcf, out / f"{model}.mujoco.xml")
    for name, engine, make in (("mujoco", Mujoco, MujocoTree), ("pinocchio", Pinocchio, PinocchioTree)):
        # Coordinates are the same with the ground's body, by which loops are found.
        loop, tree = ClosedLoop(engine(mjcf, mechanism), mechanism), make(engine(lean, mechanism))
        text = tree.model() + states(tree, loop, samples["off"])
        (out / f"{model}.{name}.txt").write_text(text, encoding="utf-8")


def leaner(mjcf: Path, path: Path) -> Path:
    """The exported file without the body of the ground, which does not move and would only cost the engine time."""
    root = xml.parse(mjcf)
    world = root.find("worldbody")
    ground = next(body for body in world.findall("body") if body.get("name") == GROUND)
    if (ground.get("pos"), ground.get("quat")) != ("0 0 0", "1 0 0 0") or ground.find("site") is not None:
        raise NotImplementedError("a ground that is not the world, or at which a loop closes")
    world.remove(ground)
    world.extend(ground.findall("body"))
    root.write(path, encoding="utf-8")
    return path


def row(*numbers) -> str:
    return " ".join(repr(float(x)) if isinstance(x, (float, np.floating)) else str(x) for x in numbers) + "\n"


def ours(mechanism: Mechanism, samples: dict[str, list[Sample]]) -> str:
    """Instants, and drives and reactions without friction and with it."""
    first = samples["off"][0]
    text = row("samples", len(samples["off"]), len(first.drives), len(first.reactions))
    text += row(*first.reactions)
    for pair in zip(samples["off"], samples["on"]):
        text += row(pair[0].time)
        for sample in pair:
            text += row(*sample.drives, *np.concatenate(list(sample.reactions.values())))
    return text


class MujocoTree:
    """Bodies are numbered as in MuJoCo, and so are the sites at which loops close."""

    def __init__(self, engine: Mujoco) -> None:
        self.engine = engine

    def model(self) -> str:
        return ""  # MuJoCo reads its own file

    def index(self, body: str) -> int:
        return self.engine.ids[body]

    def drive(self, name: str) -> int:
        return int(self.engine.model.joint(name).dofadr[0])

    def origin(self, index: int) -> Array:
        return self.engine.data.xpos[index].copy()

    def closing_points(self) -> list[tuple[int, Array, int, Array]]:
        model = self.engine.model
        pairs = [(int(model.eq_obj1id[i]), int(model.eq_obj2id[i])) for i in range(model.neq)]
        return [(a, model.site_pos[a], b, model.site_pos[b]) for a, b in pairs]


class PinocchioTree:
    """Joints are numbered in the harness's order, where a joint of several axes is one joint for each."""

    def __init__(self, engine: Pinocchio) -> None:
        self.engine = engine
        self.lines: list[str] = []
        #: the harness's joint for each of Pinocchio's
        self.last = [0]
        pin_model = engine.model
        for joint in range(1, pin_model.njoints):
            kinds = [(pin_model.joints[joint].shortname(), pin_model.jointPlacements[joint])]
            if kinds[0][0] == "JointModelComposite":
                kinds = single(pin_model.joints[joint].extract(), kinds[0][1])
            parent = self.last[pin_model.parents[joint]]
            for i, (kind, place) in enumerate(kinds):
                inertia = pin_model.inertias[joint]
                mass = inertia.mass if i + 1 == len(kinds) else 0.0
                matrix = inertia.inertia if i + 1 == len(kinds) else np.zeros((3, 3))
                numbers = (*place.rotation.ravel(), *place.translation, mass, *inertia.lever, *matrix.ravel())
                self.lines.append(row(kind, parent, *numbers))
                parent = len(self.lines)
            self.last.append(parent)

    def model(self) -> str:
        return row("joints", len(self.lines), *self.engine.model.gravity.linear) + "".join(self.lines)

    def index(self, body: str) -> int:
        return self.last[self.engine._joint(body)]

    def drive(self, name: str) -> int:
        joint = self.engine.model.getJointId(name)
        return int(self.engine.model.joints[joint].idx_v)

    def origin(self, index: int) -> Array:
        return self.engine.data.oMi[self.last.index(index)].translation.copy()

    def closing_points(self) -> list[tuple[int, Array, int, Array]]:
        points = []
        for closure in self.engine.closures:
            ends = []
            for body, point in ((closure.body_a, closure.point_a), (closure.body_b, closure.point_b)):
                frame = self.engine.model.frames[self.engine.frames[body]]
                ends += [self.index(body), frame.placement.act(point)]
            points.append(tuple(ends))
        return points


def single(composite: pin.JointModelComposite, outer: pin.SE3) -> list[tuple[str, pin.SE3]]:
    """The joints of a composite one by one, with all axes of hinges along x, y or z, which is what Pinocchio is quick at."""
    kinds, turned_back = [], outer
    for part, place in zip(composite.joints, composite.jointPlacements):
        kind, place = part.shortname(), turned_back * place
        turned_back = pin.SE3.Identity()
        if kind == "JointModelRevoluteUnaligned":
            turn = pin.SE3(pin.Quaternion.FromTwoVectors(np.eye(3)[0], part.extract().axis).matrix(), np.zeros(3))
            kind, place, turned_back = "JointModelRX", place * turn, turn.inverse()
        kinds.append((kind, place))
    if not turned_back.isIdentity():
        raise NotImplementedError("the last axis of a composite is not along x, y or z")
    return kinds


def states(tree: MujocoTree | PinocchioTree, loop: ClosedLoop, samples: list[Sample]) -> str:
    """Structure of the tree, then for each sample its state, loads, and forces that are to be found."""
    engine, mechanism = tree.engine, loop.mechanism
    driven = [tree.drive(joint.name) for joint, _ in mechanism.actuated()]
    loaded = [name for name in engine.parents if name in mechanism.moving() and any(np.any(s.loads[name]) for s in samples)]
    points = tree.closing_points()
    text = row("samples", len(samples), len(engine.neutral()), engine.nv)
    text += row("drives", len(driven), *driven)
    text += row("loaded", len(loaded), *(tree.index(name) for name in loaded))
    text += row("tree", len(loop.child), *(tree.index(child) for child in loop.child.values()))
    text += row("closures", len(points), *(x for a, p, b, q in points for x in (a, *p, b, *q)))
    for sample in samples:
        place_error = loop.place(sample)
        poses, jacobians = loop.engine.kinematics(loop.q)
        v, v_error = loop.rates(jacobians, {name: sample.motions[body] for name, body in loop.owner.items()})
        bias = loop.engine.bias(loop.q, v)
        wanted = {name: sample.accelerations[body] - bias[name] for name, body in loop.owner.items()}
        a, a_error = loop.rates(jacobians, wanted)
        if max(place_error, v_error, a_error) > STATE_LIMIT:
            raise RuntimeError(f"{engine.name} does not move as it should: {place_error}, {v_error}, {a_error}")
        engine.kinematics(loop.q)  # the origins below are at this state
        numbers = [loop.q, v, a]
        for name in loaded:
            numbers.append(moved_wrench(sample.loads[name], poses[name].position - tree.origin(tree.index(name))))
        numbers.append(sample.drives)
        for name, child in loop.child.items():
            joint = mechanism.joints[name]
            wrench = sample.reactions[name] if loop.owner[child] == joint.successor else -sample.reactions[name]
            numbers.append(moved_wrench(wrench, joint.frames(poses)[0].position - tree.origin(tree.index(child))))
        for closure in engine.closures:
            joint = mechanism.joints[closure.joint]
            sign = 1.0 if loop.owner.get(closure.body_b, closure.body_b) == joint.successor else -1.0
            numbers.append(sign * sample.reactions[closure.joint][:3])
        text += row(*np.concatenate(numbers))
    return text


if __name__ == "__main__":
    sys.exit(main())
