"""The tables of forward dynamics: on the terminal, in forward.csv and creep.csv, and in the book's page."""

from __future__ import annotations

import csv
from dataclasses import asdict, dataclass
from pathlib import Path

from creep import Creep
from forward import ACCELERATION_LIMIT, INSTANTS, LIMIT, Agreement
from report import FACTOR, read_bounds, upper_bound

NUMBERS = (
    "position",
    "own_position",
    "step_position",
    "velocity",
    "own_velocity",
    "step_velocity",
    "acceleration",
)
COLUMNS = ("model", "friction", "exudyn", "pinocchio", "instants", "variants", *NUMBERS)
CREEP_COLUMNS = ("model", "version", "torque", "limit", "moved", "mujoco", "mujoco_hard")

#: creep is the same on all machines but for rounding; the committed numbers have two digits
CREEP_TOLERANCE = 0.06

BEGIN, END = "<!-- forward.csv -->", "<!-- end of forward.csv -->"
CREEP_BEGIN, CREEP_END = "<!-- creep.csv -->", "<!-- end of creep.csv -->"


@dataclass(frozen=True)
class ForwardLine:
    """Largest differences of a model's runs of one kind, the model itself and all variations."""

    model: str
    friction: str
    exudyn: str
    pinocchio: str
    instants: int
    variants: int
    position: float
    own_position: float
    step_position: float
    velocity: float
    own_velocity: float
    step_velocity: float
    acceleration: float

    @staticmethod
    def of(model: str, viscous: bool, versions: tuple[str, str], found: list[Agreement]) -> "ForwardLine":
        worst = {name: max(getattr(one, name) for one in found) for name in NUMBERS}
        kind = "viscous" if viscous else "none"
        return ForwardLine(model, kind, *versions, INSTANTS * len(found), len(found) - 1, **worst)


def forward_cells(line: ForwardLine) -> list[str]:
    row = asdict(line)
    return [upper_bound(row[name]) if name in NUMBERS else str(row[name]) for name in COLUMNS]


def creep_cells(found: Creep) -> list[str]:
    return [
        found.model,
        found.version,
        f"{found.torque:.4g}",
        f"{found.limit:.4g}",
        f"{found.moved:g}",
        f"{found.mujoco:.2g}",
        f"{found.mujoco_hard:.2g}",
    ]


def write_table(path: Path, columns: tuple[str, ...], rows: list[list[str]], provenance: str) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        file.write(f"# {provenance}\n")
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(rows)


def forward_beyond(lines: list[ForwardLine], bounds: list[dict[str, str]]) -> list[str]:
    """What is worse than the committed bounds allow, in words; Exudyn's own errors among it."""
    committed = {(row["model"], row["friction"]): row for row in bounds}
    complaints = []
    for line in lines:
        name = f"{line.model}, forward, friction {line.friction}"
        row = committed.get((line.model, line.friction))
        if row is None:
            complaints.append(f"{name}: no line in forward.csv")
            continue
        fixed = COLUMNS[2:6]
        if [row[key] for key in fixed] != [str(getattr(line, key)) for key in fixed]:
            complaints.append(f"{name}: forward.csv is of another version or extent")
        for key in NUMBERS:
            limit = ACCELERATION_LIMIT if key == "acceleration" else LIMIT
            allowed = min(FACTOR * float(row[key]), limit) if not key.startswith("step") else FACTOR * float(row[key])
            if not getattr(line, key) <= allowed:
                complaints.append(f"{name}: {key} {getattr(line, key):.1e} exceeds {allowed:.0e}")
    return complaints


def creep_differs(found: list[Creep], rows: list[dict[str, str]]) -> list[str]:
    """Where MuJoCo creeps otherwise than the committed table says."""
    committed = {row["model"]: row for row in rows}
    complaints = []
    for one in found:
        row = committed.get(one.model)
        if row is None or row["version"] != one.version:
            complaints.append(f"{one.model}, creep: not in creep.csv with this version of MuJoCo")
            continue
        for key in ("torque", "limit", "mujoco", "mujoco_hard"):
            value, expected = getattr(one, key), float(row[key])
            if not abs(value - expected) <= CREEP_TOLERANCE * abs(expected):
                complaints.append(f"{one.model}, creep: {key} {value:.3g}, in creep.csv {expected:.3g}")
    return complaints


def forward_page(bounds: list[dict[str, str]]) -> str:
    head = "| model | friction | positions | Exudyn's own | velocities | Exudyn's own | finest step | accelerations |"
    shown = ("position", "own_position", "velocity", "own_velocity", "step_velocity", "acceleration")
    rows = [
        "| " + " | ".join([f"`{row['model']}`", row["friction"], *(row[key] for key in shown)]) + " |"
        for row in bounds
    ]
    return "\n".join([BEGIN, "", head, "|" + " --- |" * 8, *rows, "", END])


def creep_page(rows: list[dict[str, str]]) -> str:
    head = "| crank | torque, N m | limit, N m | Stiction, rad in 1000 s | MuJoCo, rad/s | as hard as can be, rad/s |"
    lines = [
        "| " + " | ".join([row["model"], *(row[key] for key in CREEP_COLUMNS[2:])]) + " |" for row in rows
    ]
    return "\n".join([CREEP_BEGIN, "", head, "|" + " --- |" * 6, *lines, "", CREEP_END])


def sections(forward: Path, creep: Path) -> list[tuple[str, str, str]]:
    """What the page has between which marks."""
    return [
        (BEGIN, forward_page(read_bounds(forward)), END),
        (CREEP_BEGIN, creep_page(read_bounds(creep)), CREEP_END),
    ]


def write_sections(page: Path, parts: list[tuple[str, str, str]]) -> None:
    text = page.read_text(encoding="utf-8")
    for begin, table, end in parts:
        before, rest = text.split(begin)
        text = before + table + rest.split(end)[1]
    page.write_text(text, encoding="utf-8")


def sections_differ(page: Path, parts: list[tuple[str, str, str]]) -> bool:
    text = page.read_text(encoding="utf-8")
    return any(table not in text for _, table, _ in parts)


def forward_terminal(lines: list[ForwardLine], creeping: list[Creep]) -> str:
    head = f"{'forward':<18} {'friction':<10} {'instants':>8} {'position':>9} {'own':>8} {'velocity':>9}"
    head += f" {'own':>8} {'accel.':>8}"
    rows = [
        f"{x.model:<18} {x.friction:<10} {x.instants:>8} {x.position:>9.1e} {x.own_position:>8.1e}"
        f" {x.velocity:>9.1e} {x.own_velocity:>8.1e} {x.acceleration:>8.1e}"
        for x in lines
    ]
    rows += [
        f"creep of a crank, {x.model}: moves {x.moved:g} rad; MuJoCo {x.mujoco:.2g}, hard {x.mujoco_hard:.2g} rad/s"
        for x in creeping
    ]
    return "\n".join([head, *rows])
