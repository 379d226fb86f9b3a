"""Calls the program `stiction`."""

from __future__ import annotations

import subprocess
from dataclasses import dataclass
from pathlib import Path

from mechanism import Mechanism, read_mechanism
from tables import Sample, read_samples


class Refused(Exception):
    """The program says that a model has no answer (exit code 1) or cannot be used (2)."""


@dataclass(frozen=True)
class Case:
    """A model with what the program says about it, frictionless and with friction."""

    model: str
    variant: int
    mechanism: Mechanism
    mjcf: Path
    frictionless: list[Sample]
    with_friction: list[Sample]


class Program:
    def __init__(self, path: Path) -> None:
        self.path = path

    def call(self, *arguments: str) -> str:
        done = subprocess.run([str(self.path), *arguments], capture_output=True, text=True, check=False)
        if done.returncode in (1, 2):
            raise Refused(done.stderr.strip() or done.stdout.strip())
        if done.returncode != 0:
            raise RuntimeError(f"{arguments}: exit code {done.returncode}\n{done.stderr}")
        return done.stdout

    def text(self, model: str) -> str:
        return self.call("models", model)

    def describe(self, model: str, folder: Path, form: str) -> Path:
        path = folder / f"mechanism.{form}"
        path.write_text(self.call("convert", model, "--to", form), encoding="utf-8")
        return path

    def case(self, model: str, variant: int, text: str, step: float, folder: Path) -> Case:
        """Everything that the program says about a text; `step` is the time between samples in s."""
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / f"{model}.toml"
        path.write_text(text, encoding="utf-8")
        mechanism = read_mechanism(self.describe(str(path), folder, "json"))
        mjcf = self.describe(str(path), folder, "mjcf")
        samples = {}
        for friction in ("off", "on"):
            output = folder / friction
            arguments = ["inverse", str(path), "--friction", friction, "--step", repr(step), "-o", str(output)]
            if variant:
                arguments += ["--load", "validation"]
            self.call(*arguments)
            samples[friction] = read_samples(output, mechanism)
        return Case(model, variant, mechanism, mjcf, samples["off"], samples["on"])
