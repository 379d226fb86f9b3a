"""Mechanisms of any size, as model files of Stiction: pendulums, rows of four-bars, platforms on many legs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, pi, sin

FRICTION = "friction = { mu = 0.05, radius = 0.005 }"


@dataclass(frozen=True)
class Family:
    """Models of one kind; `make`, `bodies` and `drives` are functions of the number of units."""

    name: str
    sizes: tuple[int, ...]
    make: Callable[[int], str]
    bodies: Callable[[int], int]
    drives: Callable[[int], int]
    #: body that carries a load
    loaded: str


def body(name: str, mass: float, com: str, inertia: str, home: str = "") -> str:
    return f"[bodies.{name}]\nmass = {mass}\ncom = {com}\ninertia = {inertia}\n{home}\n"


def revolute(name: str, start: str, end: str, places: str, more: str) -> str:
    return f'[joints.{name}]\ntype = "R"\nfrom = "{start}"\nto = "{end}"\naxis = "y"\n{places}\n{more}\n'


def model(parts: list[str], motion: dict[str, tuple[float, float]]) -> str:
    """Model with two motions, `swing` and `rest`; for each coordinate a mean value and an amplitude."""
    swing = "".join(f'{name} = "{mean} + {amplitude:.6g}*sin(2*pi*t)"\n' for name, (mean, amplitude) in motion.items())
    rest = "".join(f"{name} = {mean}\n" for name, (mean, _) in motion.items())
    motions = f'\n[motions.swing]\nduration = "1 s"\n{swing}\n[motions.rest]\nduration = "1 s"\n{rest}'
    return "gravity = [0, 0, -9.81]\n" + "\n".join(parts) + motions + '\n[default]\nmotion = "swing"\n'


def pendulums(count: int) -> str:
    """A chain that hangs from the ground; every joint has an actuator."""
    parts = []
    for k in range(count):
        parts.append(body(f"b{k}", 1.0, "[0.05, 0, 0]", "[1e-3, 1e-3, 1e-3]"))
        start = f"b{k - 1}" if k else "ground"
        parts.append(revolute(f"j{k}", start, f"b{k}", f"at = [{0.1 if k else 0.0}, 0, 0]", f"actuated = true\n{FRICTION}"))
    return model(parts, {f"j{k}": (0.0, 0.3 / count) for k in range(count)})


def fourbars(count: int) -> str:
    """Parallelograms side by side: the rocker of each is the crank of the next. The first crank has an actuator."""
    parts = []
    for k in range(count + 1):
        parts.append(body(f"c{k}", 1.0, "[0, 0, 0.1]", "[1e-3, 1e-3, 1e-3]"))
        parts.append(revolute(f"g{k}", "ground", f"c{k}", f"at = [{k}, 0, 0]", FRICTION + ("" if k else "\nactuated = true")))
    for k in range(count):
        parts.append(body(f"k{k}", 1.0, "[0.5, 0, 0]", "[1e-2, 1e-2, 1e-2]"))
        parts.append(revolute(f"p{k}", f"c{k}", f"k{k}", "at = [0, 0, 0.2]", FRICTION))
        parts.append(revolute(f"q{k}", f"k{k}", f"c{k + 1}", "at = [1, 0, 0]\nto_at = [0, 0, 0.2]", FRICTION))
    return model(parts, {"g0": (0.0, 0.3)})


LEG = """[legs.joints.U]
axis = "y"
second_axis = "x"
friction = { mu = 0.1, radius = 0.008 }
[legs.joints.P]
axis = "z"
start = 0.6
friction = { mu = 0.1 }
[legs.joints.S]
friction = { mu = 0.1, radius = 0.008 }
[legs.bodies.lower]
mass = 3
com = [0, 0, 0.15]
inertia = [0.05, 0.05, 0.002]
[legs.bodies.upper]
mass = 1
com = [0, 0, -0.15]
inertia = [0.02, 0.02, 0.001]
"""


def platform(count: int) -> str:
    """A platform on `count` legs of U, P and S joints, a multiple of six; six legs, 60 degrees apart, have actuators."""

    def legs(chain: str, numbers: list[int]) -> str:
        text = f'[[legs]]\nchain = "{chain}"\nto = "platform"\n' + LEG
        for k in numbers:
            # Feet and tips stand in pairs that cross, so that six legs hold the platform.
            pair, side = k // 2, 1 if k % 2 else -1
            foot, tip = 2 * pi * (2 * pair + 0.25 * side) / count, 2 * pi * (2 * pair + 0.75 * side) / count
            text += f"[[legs.place]]\nfoot = [{0.45 * cos(foot):.9f}, {0.45 * sin(foot):.9f}, 0]\n"
            text += f"tip = [{0.2 * cos(tip):.9f}, {0.2 * sin(tip):.9f}, 0]\n"
        return text

    driven = sorted({j // 2 * 2 * (count // 6) + j % 2 for j in range(6)})
    others = [k for k in range(count) if k not in driven]
    home = "home = { position = [0, 0, 0.55] }"
    parts = [body("platform", 10.0, "[0, 0, 0]", "[0.2, 0.2, 0.4]", home), legs("U lower P* upper S", driven)]
    if others:
        parts.append(legs("U lower P upper S", others))
    sway = {"x": (0.0, 0.02), "y": (0.0, 0.0), "z": (0.55, 0.01), "rx": (0.0, 0.05), "ry": (0.0, 0.0), "rz": (0.0, 0.03)}
    return model(parts, {f"platform.{name}": signal for name, signal in sway.items()})


FAMILIES = (
    Family("pendulums", (30, 100, 300, 1000), pendulums, lambda n: n, lambda n: n, "b0"),
    Family("four-bars", (15, 50, 150, 500), fourbars, lambda n: 2 * n + 1, lambda n: 1, "c0"),
    Family("legs", (12, 24, 48, 96), platform, lambda n: 2 * n + 1, lambda n: 6, "platform"),
)
