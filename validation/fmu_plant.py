"""Checks plant FMUs with FMPy: description, motion under constant efforts against `stiction forward`, events, many instances.

Usage: python fmu_plant.py STICTION, where STICTION is the program; the library of plant FMUs is beside it.
"""

from __future__ import annotations

import csv
import inspect
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from fmpy import extract, instantiate_fmu, read_model_description, simulate_fmu
from fmpy.validation import validate_fmu

#: efforts of the actuators, N or N m, at which the robots move
EFFORTS = {
    "five-bar": {"left_motor": 2.0, "right_motor": -1.5},
    "3rps": {"leg1.P": 120.0, "leg2.P": 80.0, "leg3.P": 100.0},
    "slider-crank": {"A": 0.5},
}

#: duration and communication step, s
STOP, STEP = 0.2, 0.002

#: largest difference of positions, relative to the largest motion: a hundred times the error of a step of integration
TOLERANCE = 1e-8


def main() -> int:
    program = sys.argv[1]
    complaints = []
    with tempfile.TemporaryDirectory(prefix="stiction-plant-") as folder:
        for robot, efforts in EFFORTS.items():
            efforts = {name: efforts[name] for name in efforts}
            motion = reference(program, robot, efforts, Path(folder) / robot)
            for fmi in (2, 3):
                path = Path(folder) / f"{robot}-{fmi}.fmu"
                command = [program, "export", robot, "--to", "fmu", "--plant", "--from", "rest", "--friction", "on",
                           "--fmi", str(fmi), "-o", str(path)]  # fmt: skip
                subprocess.run(command, check=True, capture_output=True)
                problems = validate_fmu(str(path))
                complaints += [f"{path.name}: {problem}" for problem in problems]
                for events in (False, True) if fmi == 3 else (False,):
                    difference = simulated(path, motion, efforts, events)
                    if not difference < TOLERANCE:
                        complaints.append(f"{path.name}: motions differ by {difference:.1e}")
                    mode = ", with events" if events else ""
                    print(f"{path.name}{mode}: {len(problems)} problems, largest difference {difference:.1e}")
                complaints += states(path, efforts)
    for complaint in complaints:
        print(f"FAILED: {complaint}", file=sys.stderr)
    return 1 if complaints else 0


def reference(program: str, robot: str, efforts: dict[str, float], folder: Path) -> dict[str, np.ndarray]:
    """Positions and rates of all joints by `stiction forward`."""
    units = {"3rps": "N"}.get(robot, "N m")
    drives = "; ".join(f"{name} = {effort} {units}" for name, effort in efforts.items())
    command = [program, "forward", robot, "--from", "rest", "--drives", drives, "--friction", "on", "--until", f"{STOP} s",
               "--step", f"{STEP} s", "-o", str(folder)]  # fmt: skip
    subprocess.run(command, check=True, capture_output=True)
    with (folder / "forward.csv").open(newline="") as file:
        header, *rows = csv.reader(file)
    numbers = np.array([[float(x) for x in row] for row in rows])
    columns = {name.split(" [")[0]: numbers[:, k] for k, name in enumerate(header)}
    motion = {"time": columns["time"]}
    for name, values in columns.items():
        if name.endswith(".position"):
            motion[name] = values
        elif name.endswith(".rate"):
            motion[name.removesuffix(".rate") + ".speed"] = values
    return motion


def simulated(path: Path, motion: dict[str, np.ndarray], efforts: dict[str, float], events: bool) -> float:
    """Largest difference of positions and rates, each relative to the largest of its kind."""
    outputs = [name for name in motion if name != "time"]
    known = inspect.signature(simulate_fmu).parameters
    modes = {name: events for name in ("early_return_allowed", "use_event_mode") if name in known}
    result = simulate_fmu(str(path), start_values={f"{name}.effort": effort for name, effort in efforts.items()},
                          start_time=0.0, stop_time=STOP, step_size=STEP, output_interval=STEP, output=outputs, **modes)  # fmt: skip
    worst = 0.0
    for kind in (".position", ".speed"):
        names = [name for name in outputs if name.endswith(kind)]
        size = max(np.abs(motion[name] - motion[name][0]).max() for name in names)
        for name in names:
            # Events add rows.
            found = np.interp(motion["time"], result["time"], result[name]) if events else result[name]
            if len(found) != len(motion["time"]):
                return float("inf")
            worst = max(worst, np.abs(found - motion[name]).max() / size)
    return worst


def states(path: Path, efforts: dict[str, float]) -> list[str]:
    """A state that is serialised continues bit for bit in another instance, among others."""
    folder = extract(str(path))
    description = read_model_description(folder)
    references = {v.name: v.valueReference for v in description.modelVariables}
    inputs = [references[f"{name}.effort"] for name in efforts]
    outputs = [v.valueReference for v in description.modelVariables if v.type in ("Real", "Float64")]
    is_two = description.fmiVersion.startswith("2")
    units = []
    for _ in range(10):
        unit = instantiate_fmu(folder, description, fmi_type="CoSimulation")
        if is_two:
            unit.setupExperiment(startTime=0.0)
        unit.enterInitializationMode()
        unit.exitInitializationMode()
        (unit.setReal if is_two else unit.setFloat64)(inputs, list(efforts.values()))
        units.append(unit)
    get = lambda unit: np.array((unit.getReal if is_two else unit.getFloat64)(outputs))  # noqa: E731

    def run(chosen: list, first: int, last: int) -> None:
        for k in range(first, last):
            for unit in chosen:
                unit.doStep(currentCommunicationPoint=STEP * k, communicationStepSize=STEP)

    run(units, 0, 10)
    first, second = units[:2]
    if is_two:
        state = first.getFMUstate()
        bytes_ = first.serializeFMUstate(state)
    else:
        state = first.getFMUState()
        bytes_ = first.serializeFMUState(state)
    run(units, 10, 20)
    end = get(first)
    complaints = [] if all((get(unit) == end).all() for unit in units) else [f"{path.name}: instances differ"]
    if is_two:
        second.setFMUstate(second.deSerializeFMUstate(bytes_))
    else:
        second.setFMUState(second.deserializeFMUState(bytes_))
    run([second], 10, 20)
    if not (get(second) == end).all():
        complaints.append(f"{path.name}: a restored state continues otherwise")
    for unit in units:
        unit.terminate()
        unit.freeInstance()
    return complaints


if __name__ == "__main__":
    sys.exit(main())
