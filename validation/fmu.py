"""Checks functional mock-up units with FMPy: description, efforts against the program's tables, states, many instances.

Usage: python fmu.py STICTION, where STICTION is the program.
"""

from __future__ import annotations

import csv
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from fmpy import extract, instantiate_fmu, read_model_description, simulate_fmu
from fmpy.validation import validate_fmu

ROBOTS = ("five-bar", "3rps", "zhang2018-regular", "delta")

#: largest difference of the efforts of code and program, relative to the largest effort; loops are closed to 1e-12
TOLERANCE = 1e-9


def main() -> int:
    program = sys.argv[1]
    complaints = []
    with tempfile.TemporaryDirectory(prefix="stiction-fmu-") as folder:
        for robot in ROBOTS:
            motion, efforts = reference(program, robot, Path(folder) / robot)
            for fmi in (2, 3):
                path = Path(folder) / f"{robot}-{fmi}.fmu"
                command = [program, "export", robot, "--to", "fmu", "--fmi", str(fmi), "-o", str(path)]
                subprocess.run(command, check=True, capture_output=True)
                problems = validate_fmu(str(path))
                complaints += [f"{path.name}: {problem}" for problem in problems]
                difference = simulated(path, motion, efforts)
                if not difference < TOLERANCE:
                    complaints.append(f"{path.name}: efforts differ by {difference:.1e}")
                if robot == ROBOTS[0]:
                    complaints += instances(path, motion, next(iter(efforts.values())))
                print(f"{path.name}: {len(problems)} problems, largest difference {difference:.1e}")
    for complaint in complaints:
        print(f"FAILED: {complaint}", file=sys.stderr)
    return 1 if complaints else 0


def reference(program: str, robot: str, folder: Path) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Inputs of the units along the default motion, and the efforts of inverse dynamics."""
    subprocess.run([program, "inverse", robot, "--load", "none", "--friction", "on", "-o", str(folder)], check=True, capture_output=True)
    inverse, joints = table(folder / "inverse.csv"), table(folder / "joints.csv")
    find = lambda columns, name: next(v for k, v in columns.items() if k.split(" [")[0] == name)  # noqa: E731
    names = [key.split(" [")[0].removesuffix(".drive") for key in inverse if key.split(" [")[0].endswith(".drive")]
    time = find(inverse, "time")
    columns = {"time": time}
    for what in ("position", "speed", "acceleration"):
        for name in names:
            column = "rate" if what == "speed" else what
            columns[f"{name}.{what}"] = find(joints, f"{name}.{column}")
    inputs = np.zeros(len(time), dtype=[(name, np.float64) for name in columns])
    for name, values in columns.items():
        inputs[name] = values
    # Where an interface rests, the program's effort contains no friction of it; the units decide by the next motion.
    slides = np.logical_and.reduce(
        [find(inverse, f"{name}.drive_low") == find(inverse, f"{name}.drive_high") for name in names]
    )
    return inputs, {f"{name}.effort": np.where(slides, find(inverse, f"{name}.drive"), np.nan) for name in names}


def table(path: Path) -> dict[str, np.ndarray]:
    with path.open(newline="") as file:
        header, *rows = csv.reader(file)
    numbers = np.array([[float(x) for x in row] for row in rows])
    return {name: numbers[:, k] for k, name in enumerate(header)}


def simulated(path: Path, motion: np.ndarray, efforts: dict[str, np.ndarray]) -> float:
    """Largest difference of the efforts, relative to the largest effort, where the reference moves."""
    times = motion["time"]
    step = times[1] - times[0]
    result = simulate_fmu(str(path), input=motion, start_time=times[0], stop_time=times[-1], step_size=step,
                          output_interval=step, output=[*efforts, "status"])
    largest = max(np.nanmax(np.abs(values)) for values in efforts.values())
    worst = 0.0
    for name, values in efforts.items():
        # FMPy sets the inputs of the beginning of a step, and reads the outputs at its end.
        rows = [k for k in range(1, min(len(result), len(times))) if np.isfinite(values[k - 1])]
        if len(rows) < len(times) // 2:
            return float("inf")
        worst = max(worst, max(abs(result[name][k] - values[k - 1]) for k in rows))
    return worst / largest


def instances(path: Path, motion: np.ndarray, effort: np.ndarray) -> list[str]:
    """A hundred instances, each at its own place of the motion, do not disturb each other."""
    folder = extract(str(path))
    description = read_model_description(folder)
    inputs = [v for v in description.modelVariables if v.causality == "input"]
    outputs = [v for v in description.modelVariables if v.causality == "output" and v.type in ("Real", "Float64")]
    references, results = [v.valueReference for v in inputs], [v.valueReference for v in outputs]
    is_two = description.fmiVersion.startswith("2")
    units = []
    for _ in range(100):
        unit = instantiate_fmu(folder, description, fmi_type="CoSimulation")
        if is_two:
            unit.setupExperiment(startTime=0.0)
        unit.enterInitializationMode()
        unit.exitInitializationMode()
        units.append(unit)
    put = lambda unit, values: (unit.setReal if is_two else unit.setFloat64)(references, values)  # noqa: E731
    get = lambda unit: (unit.getReal if is_two else unit.getFloat64)(results)  # noqa: E731
    # At rest the sign of friction depends on the way, or on rounding.
    rows = np.flatnonzero(np.isfinite(effort))
    found = np.zeros((10, 100, len(results)))
    for round_ in range(10):
        for k, unit in enumerate(units):
            put(unit, [motion[v.name][rows[(k + round_) % len(rows)]] for v in inputs])
        for k, unit in enumerate(units):
            found[round_, k] = get(unit)
            unit.doStep(0.001 * round_, 0.001)
    # Instance k + 1 of a round and instance k of the next one are at the same place.
    apart = np.abs(found[:-1, 1:] - found[1:, :-1]).max() / np.abs(found).max()
    for unit in units:
        unit.terminate()
        unit.freeInstance()
    return [] if apart < TOLERANCE else [f"{path.name}: instances differ by {apart:.1e}"]


if __name__ == "__main__":
    sys.exit(main())
