"""Growth of computing time with the number of bodies: commands of Stiction, and accelerations of MuJoCo and Pinocchio.

Each time is the difference of two runs of a command, divided by the difference of their numbers of samples or
evaluations; `check` and `breakaway` are whole commands. The exponents are those between the two largest mechanisms of
each family that a command manages within `LIMIT`; the greatest exponent of all families is the result. A command that
refuses a mechanism does not count; the table says so. A command that exceeds the limit counts with the limit, divided
by the greatest number of samples if it is for samples, set-up included.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from math import isnan, log, nan
from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin
from commands import Refused, TooSlow, cpu_time
from commands import pin as keep_on_one_core
from families import FAMILIES, Family

ROUNDS = 2
#: processor time of a command, s, above which it and larger mechanisms are left out, and above which it runs only once
LIMIT, LONG = 20, 2.0
#: difference of two runs, s, that suffices
DIFFERENCE = 0.3
#: numbers of samples; no motion rests at these fractions of its duration, and no run is so long that a program is recorded
SAMPLES = (11, 31, 127, 509, 1987)
#: greatest number of bodies for the other engines
OTHERS = 301
#: simulated times, s; later, large platforms pass singular positions, near which an evaluation takes longer
DURATIONS = (0.001, 0.1, 0.3)


@dataclass(frozen=True)
class Model:
    """Model file of a family with `count` units."""

    program: Path
    family: Family
    count: int
    file: Path

    def bodies(self) -> int:
        return self.family.bodies(self.count)

    def drives(self) -> int:
        return self.family.drives(self.count)

    def run(self, command: str, *arguments: str) -> tuple[float, str]:
        return cpu_time([self.program, command, self.file, *arguments, "--quiet", "--json"], LIMIT)

    def difference(self, command: str, arguments: list[str], option: str, values: list[str], keys: list[str]) -> float:
        """Time of one sample or evaluation, s; `keys` is the place of their number in the summary."""

        def run(value: str) -> tuple[float, int]:
            taken, text = self.run(command, *arguments, option, value)
            # A short difference of long runs is lost in the noise of one of them.
            if taken < LONG:
                taken = min(taken, self.run(command, *arguments, option, value)[0])
            number = json.loads(text)
            for key in keys:
                number = number[key]
            return taken, number

        first, least = run(values[0])
        for value in values[1:]:
            taken, number = run(value)
            if taken - first > DIFFERENCE:
                break
        return (taken - first) / (number - least)

    def sample(self, motion: str, friction: str, *more: str) -> float:
        arguments = ["--motion", motion, "--friction", friction, "--threads", "1", *more]
        steps = [repr(1.0 / number) for number in SAMPLES]
        return self.difference("inverse", arguments, "--step", steps, ["options", "samples"])

    def rest(self) -> float:
        # With a constant load, the samples at rest would all be the same and be solved once.
        load = ["--load", f"{self.family.loaded}.fx = 1 N*sin(t)"]
        return self.sample("rest", "on", *load) / self.drives()

    def evaluation(self) -> float:
        arguments = ["--motion", "swing", "--drives", "none", "--friction", "off"]
        # Platforms take few steps, so that their times would be lost in the noise.
        tolerance = "1e-12" if self.family.name == "legs" else "1e-8"
        method = ["--method", "event-driven", "--tolerance", tolerance, "--step", "1"]
        durations = [repr(duration) for duration in DURATIONS]
        return self.difference("forward", arguments + method, "--until", durations, ["verdicts", "evaluations"])

    def simulation(self) -> float:
        return self.run("forward", "--motion", "swing", "--drives", "none", "--until", "0.02", "--tolerance", "1e-8")[0]

    def check(self) -> float:
        return self.run("check", "--motion", "swing", "--step", "0.5")[0]

    def breakaway(self) -> float:
        return self.run("breakaway", "--motion", "swing")[0] / self.drives()

    def mujoco_accelerations(self) -> float:
        """`mj_forward` of MuJoCo for the exported file, without friction, up to `OTHERS` bodies.

        MuJoCo refuses files as deep as 1000 pendulums, and needs minutes for 500 four-bars.
        """
        if self.bodies() > OTHERS:
            return nan
        text = cpu_time([self.program, "convert", self.file, "--to", "mjcf"])[1]
        model = mujoco.MjModel.from_xml_string(text)
        model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
        data = mujoco.MjData(model)
        mujoco.mj_resetDataKeyframe(model, data, 0)
        return call_time(lambda: mujoco.mj_forward(model, data))

    def pinocchio_accelerations(self) -> float:
        """`aba` of Pinocchio; only for chains, because it has no loops, up to `OTHERS` bodies.

        The memory of its data grows with the third power of the number of bodies: 1.8 GB for 300.
        """
        if self.family.name != "pendulums" or self.count > OTHERS:
            return nan
        model, joint = pin.Model(), 0
        for k in range(self.count):
            place = pin.SE3(np.eye(3), np.array([0.1 if k else 0.0, 0.0, 0.0]))
            joint = model.addJoint(joint, pin.JointModelRY(), place, f"j{k}")
            inertia = pin.Inertia(1.0, np.array([0.05, 0.0, 0.0]), 1e-3 * np.eye(3))
            model.appendBodyToJoint(joint, inertia, pin.SE3.Identity())
        data, zeros = model.createData(), np.zeros(self.count)
        return call_time(lambda: pin.aba(model, data, zeros, zeros, zeros))


def call_time(call: Callable[[], object]) -> float:
    """Processor time of a call, s."""
    count = 1
    while True:
        begun = time.process_time()
        for _ in range(count):
            call()
        taken = time.process_time() - begun
        if taken > 0.05:
            return taken / count
        count *= 4


@dataclass(frozen=True)
class Quantity:
    """`key` is the name of the greatest exponent in the results."""

    title: str
    measure: Callable[[Model], float]
    key: str | None = None
    #: least time if a command exceeds the limit; `None` if it is unknown
    bound: Callable[[Model], float] | None = None


def at_least(_model: Model) -> float:
    """Least mean time of a sample, s, of a command that exceeds the limit."""
    return LIMIT / SAMPLES[-1]


QUANTITIES = (
    Quantity("`inverse`, no friction", lambda model: model.sample("swing", "off"), "growth_inverse", at_least),
    Quantity("with friction", lambda model: model.sample("swing", "on"), "growth_inverse_with_bound", at_least),
    Quantity("at rest, a drive", Model.rest, "growth_rest_per_drive", lambda model: at_least(model) / model.drives()),
    Quantity("`check`", Model.check, "growth_check", lambda model: LIMIT),
    Quantity("`breakaway`, a drive", Model.breakaway, "growth_breakaway_per_drive", lambda model: LIMIT / model.drives()),
    Quantity("`forward`, an evaluation", Model.evaluation, "growth_rhs"),
    Quantity("20 ms with friction", Model.simulation),
    Quantity("MuJoCo, `mj_forward`", Model.mujoco_accelerations),
    Quantity("Pinocchio, `aba`", Model.pinocchio_accelerations),
)


@dataclass
class Row:
    model: Model
    #: times by quantity, s; not measured quantities are absent
    times: dict[str, float] = field(default_factory=dict)
    #: quantities whose command exceeded the limit
    slow: set[str] = field(default_factory=set)
    #: quantities whose command refused the mechanism
    refused: set[str] = field(default_factory=set)

    def cell(self, quantity: Quantity) -> str:
        if quantity.title in self.slow:
            return f"> {LIMIT} s"
        if quantity.title in self.refused:
            return "refused"
        return f"{1e3 * self.times[quantity.title]:.3g}" if quantity.title in self.times else "-"

    def cells(self) -> list[str]:
        return [str(self.model.bodies()), *map(self.cell, QUANTITIES)]


def measure(rows: list[Row], quantity: Quantity) -> None:
    """Measures a quantity for all mechanisms of a family: upwards until one takes too long, then alternately."""
    repeated, title = [], quantity.title
    for row in rows:
        begun = time.monotonic()
        try:
            taken = quantity.measure(row.model)
        except TooSlow:
            row.slow.add(title)
            break
        except Refused:
            row.refused.add(title)
            break
        if not isnan(taken):
            row.times[title] = taken
            repeated += [row] * (time.monotonic() - begun < LONG)
    for _ in range(ROUNDS - 1):
        repeated.reverse()
        for row in repeated:
            row.times[title] = min(row.times[title], quantity.measure(row.model))


def exponent(rows: list[Row], quantity: Quantity) -> float:
    """Exponent of the time between the two largest mechanisms; not a number if fewer were measured."""

    def between(small: Row, large: Row, time: float) -> float:
        bodies = large.model.bodies() / small.model.bodies()
        return log(max(time, 1e-9) / max(small.times[title], 1e-9)) / log(bodies)

    title = quantity.title
    measured = [row for row in rows if title in row.times]
    exponents = [between(*measured[-2:], measured[-1].times[title])] if len(measured) > 1 else []
    if measured and quantity.bound is not None:
        exponents += [between(measured[-1], row, quantity.bound(row.model)) for row in rows if title in row.slow]
    return max(exponents, default=nan)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--stiction", type=Path, required=True, metavar="PATH", help="the program")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder for the models")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    keep_on_one_core()
    ratios, tables = {}, []
    for family in FAMILIES:
        rows = []
        for count in family.sizes:
            file = options.out / f"{family.name}-{count}.toml"
            file.write_text(family.make(count), encoding="utf-8")
            rows.append(Row(Model(options.stiction, family, count, file)))
        exponents = ["exponent"]
        for quantity in QUANTITIES:
            print(f"== growth of {family.name}: {quantity.title}", file=sys.stderr)
            measure(rows, quantity)
            value = exponent(rows, quantity)
            exponents.append("-" if isnan(value) else f"{value:.1f}")
            if quantity.key is not None and not isnan(value):
                ratios[quantity.key] = max(value, ratios.get(quantity.key, value))
        columns = [f"{family.name}, bodies", *(quantity.title for quantity in QUANTITIES)]
        tables.append({"columns": columns, "rows": [row.cells() for row in rows] + [exponents]})
    print(json.dumps({"ratios": ratios, "tables": tables}))


if __name__ == "__main__":
    main()
