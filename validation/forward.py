"""Forward dynamics: `stiction forward` against Exudyn's integration in time and Pinocchio's accelerations.

Exudyn's trapezoidal rule runs with three steps, each half the one before. From two runs follows a solution without
the error of second order; how far two such solutions are apart is what Exudyn itself leaves open. The program must not
be farther from the better of them.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

import variants
from closed_loop import ClosedLoop
from engines.exudyn_motion import ExudynMotion, pose_and_motion, viscous_damping
from engines.pinocchio_forward import PinocchioForward
from engines.pinocchio_tree import Pinocchio
from mechanism import Mechanism, read_mechanism
from program import Program
from selftest import with_wrong_mass
from spatial import Array, skew
from tables import Sample, read_states

#: tolerance of our steps, and what of it may be left at the end of a motion that is not stable
TOLERANCE, FLOOR = 1e-12, 1e-11
#: largest relative difference of accelerations: of states that are given all is rounding
ACCELERATION_LIMIT = 1e-9
#: largest relative difference of positions and velocities, and Exudyn's own, so that agreement means something
LIMIT = 1e-6
#: instants that are compared, besides the beginning
INSTANTS = 10


@dataclass(frozen=True)
class Setting:
    """What drives a model, for how long, and the coarsest of Exudyn's steps, as their number."""

    efforts: dict[str, float]
    until: float
    steps: int


def legs(count: int, force: float) -> dict[str, float]:
    return {f"leg{k}.P": force for k in range(1, count + 1)}


#: efforts are some that nearly carry the platforms
SETTINGS = {
    "3rps": Setting(legs(3, 45.0), 0.5, 500),
    "gough": Setting(legs(6, 135.0), 0.5, 100),
    "slider-crank": Setting({"A": 0.5}, 0.5, 1000),
    "bricard": Setting({}, 0.5, 500),
}


@dataclass(frozen=True)
class Run:
    """A motion by the program: `viscous` says whether all joints have viscous friction, or none any."""

    model: str
    variant: int
    viscous: bool
    mechanism: Mechanism
    mjcf: Path
    states: list[Sample]


@dataclass(frozen=True)
class Agreement:
    """Positions relative to the characteristic length, velocities to the largest one of the motion.

    `step_*` is the difference of Exudyn with its finest step and of its extrapolated solution, `own_*` how far its
    two extrapolated solutions are apart, `*` how far the program is from the better of them.
    """

    position: float
    velocity: float
    own_position: float
    own_velocity: float
    step_position: float
    step_velocity: float
    acceleration: float

    def agrees(self) -> bool:
        return (
            self.follows()
            and max(self.own_position, self.own_velocity) <= LIMIT
            and self.acceleration <= ACCELERATION_LIMIT
        )

    def follows(self) -> bool:
        """Whether the program is no farther from Exudyn than Exudyn is from itself."""
        return self.position <= self.own_position + FLOOR and self.velocity <= self.own_velocity + FLOOR

    def in_words(self) -> str:
        return (
            f"positions {self.position:.1e}, of Exudyn itself {self.own_position:.1e}; velocities {self.velocity:.1e}, "
            f"of Exudyn itself {self.own_velocity:.1e}; accelerations {self.acceleration:.1e}"
        )


def only_viscous(text: str) -> str:
    """The model's text with viscous friction in place of all others."""

    def changed(match: re.Match) -> str:
        radius = re.search(r'radius = ("[^"]*"|[\d.]+)', match[0])
        return 'friction = { mu = 0, viscous = "100 N s/m"' + (f", radius = {radius[1]}" if radius else "") + " }"

    return re.sub(r"friction = \{[^}]*\}", changed, text)


def run(program: Program, model: str, variant: int, text: str, viscous: bool, folder: Path) -> Run:
    folder.mkdir(parents=True, exist_ok=True)
    setting = SETTINGS[model]
    path = folder / f"{model}.toml"
    path.write_text(text, encoding="utf-8")
    mechanism = read_mechanism(program.describe(str(path), folder, "json"))
    drives = "; ".join(f"{name} = {effort!r}" for name, effort in setting.efforts.items()) or "none"
    output = folder / "forward"
    program.call(
        *("forward", str(path), "--friction", "on" if viscous else "off", "--load", "none", "--drives", drives),
        *("--until", repr(setting.until), "--step", repr(setting.until / INSTANTS)),
        *("--tolerance", repr(TOLERANCE), "-o", str(output)),
    )
    states = read_states(output, mechanism)
    if len(states) != INSTANTS + 1:
        raise RuntimeError(f"{model}: {len(states)} samples")
    return Run(model, variant, viscous, mechanism, program.describe(str(path), folder, "mjcf"), states)


def draw(program: Program, model: str, wanted: int, seed: int, folder: Path) -> list[Run]:
    """The model and its variations, each without friction and with viscous friction."""
    original = variants.physical(program.text(model))
    result = []
    for number in range(wanted + 1):
        for viscous in (False, True):
            text = only_viscous(original) if viscous else original
            if number:
                text = variants.vary(model, text, seed + number)
            where = folder / model / f"forward-{number}-{'viscous' if viscous else 'frictionless'}"
            result.append(run(program, model, number, text, viscous, where))
    return result


def compare(case: Run) -> Agreement:
    position, velocity = in_time(case)
    return Agreement(position[0], velocity[0], position[1], velocity[1], position[2], velocity[2], at_instants(case))


def in_time(case: Run) -> tuple[Array, Array]:
    """Of positions and of velocities: the program's difference, Exudyn's own, that of its finest step."""
    setting, mechanism = SETTINGS[case.model], case.mechanism
    exudyn = ExudynMotion(mechanism, setting.efforts, case.viscous, case.states)
    first = case.states[0]
    coarse, middle, fine = (
        exudyn.integrate(first.poses, first.motions, setting.until, factor * setting.steps, INSTANTS)
        for factor in (1, 2, 4)
    )
    # The error of second order is gone from these.
    better, best = (4.0 * middle - coarse) / 3.0, (4.0 * fine - middle) / 3.0
    positions, velocities, speed = np.zeros(3), np.zeros(3), 0.0
    for k, state in enumerate(case.states):
        for i, name in enumerate(mechanism.moving()):
            pose, motion = pose_and_motion(*best[k, i])
            speed = max(speed, *size_of(mechanism, state.motions[name]))
            others = [pose_and_motion(*better[k, i]), pose_and_motion(*fine[k, i])]
            ours = (state.poses[name], state.motions[name])
            for column, (at, moving) in enumerate([ours, *others]):
                gap = max(
                    float(np.linalg.norm(at.position - pose.position)) / mechanism.length,
                    float(np.max(np.abs(at.rotation - pose.rotation))),
                )
                positions[column] = np.fmax(positions[column], gap) if np.isfinite(gap) else np.inf
                slip = max(size_of(mechanism, moving - motion))
                velocities[column] = np.fmax(velocities[column], slip) if np.isfinite(slip) else np.inf
    return positions, velocities / speed


def size_of(mechanism: Mechanism, motion: Array) -> tuple[float, float]:
    """Speeds of a body's origin, and of a point at the characteristic length from it, m/s."""
    return float(np.linalg.norm(motion[:3])), mechanism.length * float(np.linalg.norm(motion[3:]))


def at_instants(case: Run) -> float:
    """The largest difference of Pinocchio's accelerations and ours at the instants of the run."""
    engine = Pinocchio(case.mjcf, case.mechanism)
    forward = PinocchioForward(engine, ClosedLoop(engine, case.mechanism))
    return max(forward.acceleration_error(state, efforts_at(case, state)) for state in case.states)


def efforts_at(case: Run, state: Sample) -> dict[str, Array]:
    """Constant efforts, and viscous friction against the rates of the joints."""
    given, result = SETTINGS[case.model].efforts, {}
    for name, joint in case.mechanism.joints.items():
        efforts = np.zeros(len(joint.freedoms))
        if name in given:
            efforts[0] = given[name]
        if case.viscous and joint.freedoms:
            efforts -= viscous_damping(joint) * rates(case, name, state)
        result[name] = efforts
    return result


def rates(case: Run, name: str, state: Sample) -> Array:
    """Rates of a joint's freedoms from the motions of its two bodies."""
    joint = case.mechanism.joints[name]
    origin = joint.frames(state.poses)[0].position
    moved = []
    for body in (joint.successor, joint.predecessor):
        motion = state.motions[body].copy()
        motion[:3] -= skew(origin - state.poses[body].position) @ motion[3:]
        moved.append(motion)
    return np.linalg.lstsq(joint.twists(state.poses), moved[0] - moved[1], rcond=None)[0]


def unnoticed(case: Run) -> list[str]:
    """What each of the two engines did not notice of a mass that is wrong by a millionth, in words."""
    name = f"{case.model}, forward"
    if not compare(case).agrees():
        return [f"{name}: does not agree to begin with"]
    wrong = with_wrong_mass(case)
    complaints = []
    if compare(replace(case, mechanism=wrong.mechanism)).follows():
        complaints.append(f"{name}, Exudyn: a mass wrong by a millionth is not noticed")
    if at_instants(wrong) <= ACCELERATION_LIMIT:
        complaints.append(f"{name}, Pinocchio: a mass wrong by a millionth is not noticed")
    return complaints
