"""Degrees of freedom and redundant constraints: Exudyn's count against `stiction check`."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

from engines.exudyn_bodies import Exudyn
from mechanism import read_mechanism
from program import Program


@dataclass(frozen=True)
class Count:
    """Freedoms, and redundant constraints, by the program and by Exudyn."""

    model: str
    ours: tuple[int, int]
    exudyn: tuple[int, int]

    def agrees(self) -> bool:
        return self.ours == self.exudyn


def gallery(program: Program) -> list[str]:
    """Names of all built-in models."""
    return [model["name"] for model in json.loads(program.call("models", "--json"))]


def count(program: Program, model: str, folder: Path) -> Count:
    folder.mkdir(parents=True, exist_ok=True)
    found = json.loads(program.call("check", model, "--json"))
    ours = found["mobility"]["instantaneous"], found["redundant_constraints"]
    mechanism = read_mechanism(program.describe(model, folder, "json"))
    return Count(model, ours, Exudyn(mechanism).count())
