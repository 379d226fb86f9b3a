"""One engine's answers against the program's, over a motion."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from friction import contact_loads, friction_by_the_tables, law_errors
from mechanism import Joint, Mechanism
from program import Case
from solution import Solution
from spatial import Array
from statics import SelfStress
from tables import Sample

#: the relative difference above which there is no agreement
LIMIT = 1e-8
#: what an engine may leave of its own balance, relative, and of the places of the bodies, m; it reproduces the
#: state that it is given, and both are rounding
BALANCE_LIMIT, PLACE_LIMIT = 1e-10, 1e-10


class Solver(Protocol):
    """An engine with a mechanism."""

    #: joints of which the engine says no reaction
    silent: set[str]

    def solve(self, sample: Sample, friction: dict[str, Array]) -> Solution: ...


@dataclass
class Difference:
    """Largest difference and largest magnitude of one kind of quantity along a motion."""

    error: float = 0.0
    size: float = 0.0

    def add(self, ours: float | Array, error: float | Array) -> None:
        error = float(np.max(np.abs(error), initial=0.0))
        # A number that is none must not pass as small.
        self.error = max(self.error, error) if np.isfinite(error) else np.inf
        self.size = max(self.size, float(np.max(np.abs(ours), initial=0.0)))

    def relative(self) -> float:
        if self.error == 0.0:
            return 0.0
        return self.error / self.size if self.size > 0.0 else np.inf


@dataclass
class Agreement:
    """The differences of one engine and one run: forces and moments apart, each relative to its largest."""

    samples: int = 0
    drive_forces: Difference = field(default_factory=Difference)
    drive_moments: Difference = field(default_factory=Difference)
    forces: Difference = field(default_factory=Difference)
    moments: Difference = field(default_factory=Difference)
    loads: Difference = field(default_factory=Difference)
    frictions: Difference = field(default_factory=Difference)
    place: float = 0.0
    balance: float = 0.0
    #: joints whose reactions could not be compared, though the engine should say them
    missing: set[str] = field(default_factory=set)

    def drives(self) -> float:
        return max(self.drive_forces.relative(), self.drive_moments.relative())

    def reactions(self) -> float:
        return max(self.forces.relative(), self.moments.relative())

    def contact_loads(self) -> float:
        """Of loads, and of what the laws make of them."""
        return max(self.loads.relative(), self.frictions.relative())

    def agrees(self) -> bool:
        numbers = (self.drives(), self.reactions(), self.contact_loads())
        return (
            self.samples > 0
            and not self.missing
            and all(x <= LIMIT for x in numbers)
            and self.balance <= BALANCE_LIMIT
            and self.place <= PLACE_LIMIT
        )


def compare(solver: Solver, case: Case, with_friction: bool) -> Agreement:
    mechanism, result = case.mechanism, Agreement()
    for sample in case.with_friction if with_friction else case.frictionless:
        friction = friction_by_the_tables(mechanism, sample) if with_friction else {}
        solution = solver.solve(sample, friction)
        result.samples += 1
        result.place = max(result.place, solution.place)
        result.balance = max(result.balance, solution.balance, solution.motion)
        for (joint, k), ours, other in zip(mechanism.actuated(), sample.drives, solution.drives):
            kind = result.drive_forces if is_force(joint, k) else result.drive_moments
            kind.add(ours, ours - other)
        stress = add_reactions(result, mechanism, sample, solution)
        result.missing -= solver.silent
        if with_friction:
            # Loads are compared with the self-stress that the program chose: statics does not determine it.
            reactions = {name: w + stress[name] for name, w in solution.reactions.items()}
            for name, load in contact_loads(mechanism, reactions, sample.poses).items():
                result.loads.add(sample.contact_loads[name], sample.contact_loads[name] - load)
            result.frictions.add(np.array([*sample.frictions.values(), 0.0]), np.array(law_errors(mechanism, sample)))
    return result


def is_force(joint: Joint, freedom: int) -> bool:
    return joint.freedoms[freedom].kind == "translation"


def add_reactions(
    result: Agreement, mechanism: Mechanism, sample: Sample, solution: Solution
) -> dict[str, Array]:
    """Compares the reactions but for self-stresses, and returns the self-stress between the two.

    Where the program says that statics determines a reaction there must be none.
    """
    differences = {
        name: ours - solution.reactions[name]
        for name, ours in sample.reactions.items()
        if name in solution.reactions
    }
    result.missing |= set(sample.reactions) - set(differences)
    beyond, stress = SelfStress(mechanism, sample.poses).beyond(differences)
    for name in differences:
        ours = sample.reactions[name]
        rest = differences[name] if sample.determined[name] else beyond[name]
        result.forces.add(ours[:3], rest[:3])
        result.moments.add(ours[3:], rest[3:])
    return stress
