"""Seeded random variations of a model's text: geometry, inertia, motion, load, friction, gravity and base.

The text is changed, not the numbers behind it, so that everything goes through the program as a user's model does.
Planar linkages stay planar in their geometry, since they would be stuck otherwise; their masses need not be.
"""

from __future__ import annotations

import re

import numpy as np

#: a body that carries a load, and one of the legs
LOADED = {
    "3rps": ("platform", "leg1.rod"),
    "zhang2018-regular": ("platform", "leg2.rod"),
    "gough": ("platform", "leg3.screw"),
    "delta": ("platform", "leg2.arm"),
    "3rrr": ("platform", "leg3.lower"),
    "five-bar": ("tool", "right_coupler"),
    "slider-crank": ("slider", "rod"),
    "bricard": ("link3", "link5"),
}

#: models that move whatever the arrangement of their joints
FREE_GEOMETRY = ("3rps", "zhang2018-regular", "gough")

NUMBER = r"(?<![\w.^*/])(\d+(?:\.\d+)?(?:e-?\d+)?)"


def physical(text: str) -> str:
    """Completes moments of inertia of which a planar model gives only those that matter in its plane.

    Engines refuse inertias that no distribution of mass has. The others have no influence on a planar motion.
    """
    value = r'("[^"]*"|[\d.e-]+)'
    text = re.sub(rf"inertia = \{{ zz = {value} \}}", r"inertia = [\1, \1, \1]", text)
    text = re.sub(
        rf"inertia = \{{ yy = {value}, zz = {value} \}}",
        lambda m: f'inertia = ["0.01*({bare(m[1])})", {m[1]}, {m[2]}]',
        text,
    )
    return text.replace("inertia = [0, 0, 0]", 'inertia = ["1e-3 kg m^2", "1e-3 kg m^2", "1e-3 kg m^2"]')


def bare(value: str) -> str:
    return value.strip('"')


def vary(name: str, text: str, seed: int) -> str:
    """A variation of the model; the same for the same seed."""
    random = np.random.default_rng([seed, *name.encode()])

    def factor(part: float) -> float:
        return float(1.0 + part * random.uniform(-1.0, 1.0))

    def scaled(match: re.Match, part: float) -> str:
        return repr(float(match[1]) * factor(part))

    lines, section, prose = [], "", False
    for line in text.split("\n"):
        if prose or '"""' in line:
            prose ^= line.count('"""') % 2 == 1
            lines.append(line)
            continue
        heading = re.match(r"\[+([^\]]+)\]+", line)
        if heading:
            section = heading[1]
        code, comment = split_comment(line)
        key = code.split("=")[0].strip()
        last = key.split(".")[-1]
        if heading or not key or key in ("title", "source"):
            pass
        elif key == "gravity":
            code = f"gravity = {tilted_gravity(code, random)}"
        elif section == "parameters":
            code = re.sub(NUMBER, lambda m: scaled(m, 0.06), code)
        elif last == "mass":
            code = times(code, key, factor(0.1))
        elif name == "delta" and key in ("bodies.rod.com", "bodies.rod.inertia"):
            pass  # a rod that spins idly must be the same all round its axis
        elif last == "com":
            code = shifted(code, key, random)
        elif name in FREE_GEOMETRY and key in ("foot", "tip"):
            code = shifted(code, key, random)
        elif name in FREE_GEOMETRY and key == "axis" and section in ("legs.joints.R", "legs.joints.P"):
            code = tilted(code, random)
        elif last == "inertia":
            code = enlarged(code, key, factor(0.1), random)
        elif "friction" in code:
            code = re.sub(
                r'(mu|viscous|radius|bending_span|preload) = "?(\d+(?:\.\d+)?)',
                lambda m: m[0].replace(m[2], repr(float(m[2]) * factor(0.1))),
                code,
            )
        elif section.startswith("motions.") and last not in ("duration", "step"):
            code = re.sub(NUMBER + r"(?= (?:mm|m|rad|deg)\b(?!/))", lambda m: scaled(m, 0.05), code)
        lines.append(code + comment)
    return "\n".join(lines) + "\n" + base(random) + load(name, random)


def split_comment(line: str) -> tuple[str, str]:
    """No text of the gallery has a # within quotes."""
    code, sign, comment = line.partition("#")
    return code, sign + comment


def tilted_gravity(code: str, random: np.random.Generator) -> str:
    components = [float(x) for x in re.findall(r'(-?\d+(?:\.\d+)?)(?= m/s|[,\]])', code.split("=", 1)[1])]
    return repr([float(g + random.uniform(-0.5, 0.5)) for g in components])


def entries(code: str) -> list[str]:
    """The entries of a list, as expressions without quotes."""
    inside = code.split("=", 1)[1].strip().strip("[]")
    return [bare(entry.strip()) for entry in re.findall(r'"[^"]*"|[^,\s]+', inside)]


def times(code: str, key: str, by: float) -> str:
    return f'{key} = "{by!r}*({bare(code.split("=", 1)[1].strip())})" '


def shifted(code: str, key: str, random: np.random.Generator) -> str:
    """A place moved by some millimetres in all directions."""
    moved = [f'"({entry}) + {random.uniform(-8.0, 8.0)!r} mm"' for entry in entries(code)]
    return f"{key} = [{', '.join(m.replace('(0) + ', '') for m in moved)}] "


def tilted(code: str, random: np.random.Generator) -> str:
    """An axis like "y", a few degrees off."""
    axis = np.eye(3)["xyz".index(bare(code.split("=", 1)[1].strip()))] + random.uniform(-0.05, 0.05, 3)
    return f"axis = {axis.tolist()!r} "


def enlarged(code: str, key: str, by: float, random: np.random.Generator) -> str:
    """An inertia times a factor, and two small masses beside the centre of mass, so that it stays one that exists."""
    added = np.zeros((3, 3))
    for _ in range(2):
        place = random.uniform(-0.06, 0.06, 3)
        added += random.uniform(0.01, 0.05) * (place @ place * np.eye(3) - np.outer(place, place))
    added = added.tolist()
    diagonal = [
        f'{axis}{axis} = "{by!r}*({entry}) + {added[i][i]!r} kg m^2"'
        for i, (axis, entry) in enumerate(zip("xyz", entries(code)))
    ]
    products = [f"{name} = {added[i][k]!r}" for name, i, k in (("xy", 0, 1), ("xz", 0, 2), ("yz", 1, 2))]
    text = f"{key} = {{ {', '.join(diagonal + products)} }} "
    return text.replace("*(0) + ", "*0 kg m^2 + ")


def base(random: np.random.Generator) -> str:
    position = [float(x) for x in random.uniform(-0.5, 0.5, 3)]
    axis = [float(x) for x in random.normal(size=3)]
    angle = float(random.uniform(-0.3, 0.3))
    return f"\n[base]\nposition = {position!r}\nrotation = {{ axis = {axis!r}, angle = {angle!r} }}\n"


def load(name: str, random: np.random.Generator) -> str:
    """A load on the moving platform, and one that turns with a body of a leg."""
    platform, leg = LOADED[name]
    force, moment, small = ([float(x) for x in random.uniform(-s, s, 3)] for s in (30.0, 1.5, 3.0))
    at = [float(x) for x in random.uniform(-0.05, 0.05, 3)]
    return (
        f'\n[loads.validation]\n"{platform}" = {{ force = {force!r}, moment = {moment!r}, at = {at!r} }}\n'
        f'"{leg}" = {{ force = {small!r}, at = {at!r}, axes = "body" }}\n'
    )
