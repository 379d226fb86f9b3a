"""The table of agreements: on the terminal, in agreement.csv, and in the book's page."""

from __future__ import annotations

import csv
import math
from dataclasses import asdict, dataclass
from pathlib import Path

from compare import LIMIT

COLUMNS = (
    "model",
    "engine",
    "version",
    "samples",
    "variants",
    "drives",
    "reactions",
    "drives_friction",
    "reactions_friction",
    "loads",
)
NUMBERS = COLUMNS[5:]

#: a measured value may exceed its committed bound by this factor: rounding differs between machines
FACTOR = 30.0
#: the bound of what is exactly equal, or nearly so: a few units in the last place
LEAST = 1e-15

BEGIN, END = "<!-- agreement.csv -->", "<!-- end of agreement.csv -->"


@dataclass(frozen=True)
class Line:
    """Largest relative differences of a model and an engine, over all variants and samples."""

    model: str
    engine: str
    version: str
    samples: int
    variants: int
    drives: float
    reactions: float
    drives_friction: float
    reactions_friction: float
    loads: float

    def numbers(self) -> dict[str, float]:
        return {name: getattr(self, name) for name in NUMBERS}


def upper_bound(value: float) -> str:
    """The value rounded up to one digit."""
    value = max(value, LEAST)
    exponent = math.floor(math.log10(value) + 1e-12)
    digit = math.ceil(value / 10.0**exponent - 1e-9)
    return f"1e{exponent + 1:03d}" if digit == 10 else f"{digit}e{exponent:03d}"


def cells(line: Line) -> list[str]:
    """The row of agreement.csv."""
    row = asdict(line)
    return [upper_bound(row[name]) if name in NUMBERS else str(row[name]) for name in COLUMNS]


def read_bounds(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def write_bounds(path: Path, lines: list[Line], provenance: str) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        file.write(f"# {provenance}\n")
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(cells(line) for line in lines)


def beyond_bounds(lines: list[Line], bounds: list[dict[str, str]]) -> list[str]:
    """What is worse than the committed bounds allow, in words."""
    committed = {(row["model"], row["engine"]): row for row in bounds}
    complaints = []
    for line in lines:
        row = committed.get((line.model, line.engine))
        if row is None:
            complaints.append(f"{line.model}, {line.engine}: no line in agreement.csv")
            continue
        if (row["version"], row["samples"], row["variants"]) != (line.version, str(line.samples), str(line.variants)):
            complaints.append(f"{line.model}, {line.engine}: agreement.csv is of another version or extent")
        for name, value in line.numbers().items():
            allowed = min(FACTOR * float(row[name]), LIMIT)
            if not value <= allowed:
                complaints.append(f"{line.model}, {line.engine}: {name} {value:.1e} exceeds {allowed:.0e}")
    return complaints


def page_table(bounds: list[dict[str, str]]) -> str:
    """The table of the book's page, from the rows of agreement.csv."""
    head = "| model | engine | drives | reactions | drives, friction | reactions, friction | loads |"
    rows = [
        "| " + " | ".join([f"`{row['model']}`", row["engine"], *(row[name] for name in NUMBERS)]) + " |"
        for row in bounds
    ]
    return "\n".join([BEGIN, "", head, "|" + " --- |" * 7, *rows, "", END])


def page_differs(page: Path, bounds: list[dict[str, str]]) -> bool:
    return page_table(bounds) not in page.read_text(encoding="utf-8")


def write_page(page: Path, bounds: list[dict[str, str]]) -> None:
    text = page.read_text(encoding="utf-8")
    before, rest = text.split(BEGIN)
    page.write_text(before + page_table(bounds) + rest.split(END)[1], encoding="utf-8")


def terminal_table(lines: list[Line]) -> str:
    head = f"{'model':<18} {'engine':<10} {'version':<8} {'samples':>7} {'drives':>8} {'reactions':>9}"
    head += f"  with friction: {'drives':>8} {'reactions':>9} {'loads':>8}"
    rows = [
        f"{x.model:<18} {x.engine:<10} {x.version:<8} {x.samples:>7} {x.drives:>8.1e} {x.reactions:>9.1e}"
        f"{'':17}{x.drives_friction:>8.1e} {x.reactions_friction:>9.1e} {x.loads:>8.1e}"
        for x in lines
    ]
    return "\n".join([head, *rows])
