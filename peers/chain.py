"""A row of four-bars without friction: `stiction forward` beside Exudyn, each as accurate as asked.

The row is a known benchmark (IFToMM, library of computational benchmark problems: N four-bars): all rods are 1 m and 1 kg,
the vertical ones start upright with a rate of -1 rad/s. They stay parallel, so that the exact motion follows from one
equation. Exudyn has the row in the plane, where no constraint is redundant, and its trapezoidal rule, which took less
time than its generalised-alpha method. Its time includes the assembly of the system, ours the whole command.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from pathlib import Path

import exudyn as exu
import numpy as np
from commands import alternate, cpu_time, pin
from exudyn import itemInterface as items

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "validation"))

from tables import read_table  # noqa: E402

COUNT, ROUNDS = 40, 3
GRAVITY, RATE, UNTIL = 9.81, -1.0, 1.0
#: greatest errors of the tips of the vertical rods at the end, m
ACCURACIES = (1e-5, 1e-7)
TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10)


def exact_angle() -> float:
    """Angle of the vertical rods at the end, rad, to 1e-12: classical Runge-Kutta with small steps."""
    # Potential and kinetic energy of count + 1 turning and of count translating rods.
    factor = -GRAVITY * (0.5 * (COUNT + 1) + COUNT) / ((COUNT + 1) / 3.0 + COUNT)
    steps = 5000
    step, state = UNTIL / steps, np.array([0.5 * np.pi, RATE])

    def slope(state):
        return np.array([state[1], factor * np.cos(state[0])])

    for _ in range(steps):
        first = slope(state)
        second = slope(state + 0.5 * step * first)
        third = slope(state + 0.5 * step * second)
        state = state + step / 6.0 * (first + 2.0 * second + 2.0 * third + slope(state + step * third))
    return float(state[0])


def model() -> str:
    """Model file of the row."""
    upright = [f"v{k}" for k in range(COUNT + 1)]
    text = f"gravity = [0, -{GRAVITY}, 0]\n"
    for name in upright + [f"h{k}" for k in range(COUNT)]:
        text += f'[bodies.{name}]\nmass = 1\ncom = [0.5, 0, 0]\ninertia = {{ yy = "1/12", zz = "1/12" }}\n'

    def joint(name: str, start: str, end: str, angle: int, places: str) -> str:
        head = f'[joints.{name}]\ntype = "R"\nfrom = "{start}"\nto = "{end}"\naxis = "z"\n'
        return head + f'start = "{angle} deg"\n{places}\n'

    for k, name in enumerate(upright):
        text += joint(f"g{k}", "ground", name, 90, f"at = [{k}, 0, 0]")
    for k in range(COUNT):
        text += joint(f"a{k}", upright[k], f"h{k}", -90, "at = [1, 0, 0]")
        text += joint(f"b{k}", f"h{k}", upright[k + 1], 90, "at = [1, 0, 0]\nto_at = [1, 0, 0]")
    return text


class Ours:
    def __init__(self, program: Path, folder: Path) -> None:
        self.folder = folder
        self.file = folder / "row.toml"
        self.file.write_text(model(), encoding="utf-8")
        start = ["--drives", "none", "--from", f"g0 = 90 deg + ({RATE} rad/s)*t", "--until", repr(UNTIL), "--step", "1"]
        self.command = [program, "forward", self.file, *start, "--json"]

    def time(self, tolerance: float) -> float:
        return cpu_time([*self.command, "--tolerance", repr(tolerance)])[0]

    def error(self, tolerance: float) -> float:
        cpu_time([*self.command, "--tolerance", repr(tolerance), "--report", "off", "-o", self.folder])
        names, rows = read_table(self.folder / "forward.csv")
        angles = [rows[-1][names.index(f"g{k}.position")] for k in range(COUNT + 1)]
        return float(np.max(np.abs(np.array(angles) - exact_angle())))  # rods of 1 m

    def coarsest(self, accuracy: float) -> float:
        return next(tolerance for tolerance in TOLERANCES if self.error(tolerance) <= accuracy)


class Exudyn:
    def assemble(self) -> None:
        self.container = exu.SystemContainer()
        self.system = self.container.AddSystem()
        ground = self.system.AddObject(items.ObjectGround())
        self.upright = []
        turning = [self.rod([k, 0.5, 0.5 * np.pi], [-0.5 * RATE, 0.0, RATE]) for k in range(COUNT + 1)]
        self.upright = [node for _, node in turning]
        moving = [self.rod([k + 0.5, 1.0, 0.0], [-RATE, 0.0, 0.0])[0] for k in range(COUNT)]
        bodies = [body for body, _ in turning]
        for k, body in enumerate(bodies):
            self.pin(ground, [k, 0, 0], body, [-0.5, 0, 0])
        for k, body in enumerate(moving):
            self.pin(bodies[k], [0.5, 0, 0], body, [-0.5, 0, 0])
            self.pin(body, [0.5, 0, 0], bodies[k + 1], [0.5, 0, 0])
        self.system.Assemble()

    def rod(self, place: list[float], rates: list[float]) -> tuple:
        system = self.system
        node = system.AddNode(items.NodeRigidBody2D(referenceCoordinates=place, initialVelocities=rates))
        body = system.AddObject(items.ObjectRigidBody2D(mass=1.0, inertia=1.0 / 12.0, nodeNumber=node))
        marker = system.AddMarker(items.MarkerBodyMass(bodyNumber=body))
        system.AddLoad(items.LoadMassProportional(markerNumber=marker, loadVector=[0.0, -GRAVITY, 0.0]))
        return body, node

    def pin(self, first, at_first: list[float], second, at_second: list[float]) -> None:
        ends = ((first, at_first), (second, at_second))
        markers = [self.system.AddMarker(items.MarkerBodyPosition(bodyNumber=b, localPosition=p)) for b, p in ends]
        self.system.AddObject(items.ObjectJointRevolute2D(markerNumbers=markers))

    def time(self, steps: int) -> float:
        begun = time.process_time()
        self.assemble()
        settings = exu.SimulationSettings()
        settings.solution.file.write = False
        settings.show.statistics = settings.show.computationTime = False
        settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse
        settings.parallel.numberOfThreads = 1
        integration = settings.timeIntegration
        integration.verboseMode, integration.adaptiveStep = 0, False
        integration.endTime, integration.numberOfSteps = UNTIL, steps
        integration.newton.useModifiedNewton = True
        # Tighter tolerances are not reached with small steps.
        integration.newton.relativeTolerance, integration.newton.absoluteTolerance = 1e-6, 1e-7
        kind = exu.DynamicSolverType.TrapezoidalIndex2
        exu.SolveDynamic(self.system, settings, solverType=kind, showHints=False, showCausingItems=False)
        return time.process_time() - begun

    def error(self, steps: int) -> float:
        self.time(steps)
        angle = exact_angle()
        errors = []
        for k, node in enumerate(self.upright):
            x, y, _ = self.system.GetNodeOutput(node, exu.OutputVariableType.Position)
            errors.append(2.0 * np.hypot(x - k - 0.5 * np.cos(angle), y - 0.5 * np.sin(angle)))
        return float(max(errors))

    def coarsest(self, accuracy: float) -> int:
        """Least number of steps within 3 %; the rule is of second order."""
        trial = 200
        steps = int(trial * np.sqrt(self.error(trial) / accuracy) * 0.9)
        while self.error(steps) > accuracy:
            steps = int(1.03 * steps) + 1
        return steps


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--stiction", type=Path, required=True, metavar="PATH", help="the program")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder for models and results")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    pin()
    report, ratios, rows = os.dup(1), [], []
    os.dup2(2, 1)  # Exudyn writes messages to the standard output, which is for the results
    ours, exudyn = Ours(options.stiction, options.out), Exudyn()
    for accuracy in ACCURACIES:
        tolerance, steps = ours.coarsest(accuracy), exudyn.coarsest(accuracy)
        times = alternate({"ours": lambda: ours.time(tolerance), "exudyn": lambda: exudyn.time(steps)}, ROUNDS)
        ratio = times["ours"] / times["exudyn"]
        ratios.append(ratio)
        row = [f"{accuracy:.0e} m", f"{tolerance:.0e}", f"{times['ours']:.3f}", str(steps), f"{times['exudyn']:.3f}"]
        rows.append([*row, f"{ratio:.2f}"])
    columns = [f"{COUNT} four-bars, 1 s, error below", "tolerance", "time, s", "steps of Exudyn", "time, s", "ratio"]
    table = {"columns": columns, "rows": rows}
    data = {"ratios": {f"simulation_chain{COUNT}_vs_exudyn": max(ratios)}, "tables": [table]}
    os.write(report, json.dumps(data).encode())


if __name__ == "__main__":
    main()
