"""Result of an engine."""

from __future__ import annotations

from dataclasses import dataclass

from spatial import Array


@dataclass(frozen=True)
class Solution:
    """Actuator forces and reactions at one instant.

    `drives` in the order of `Mechanism.actuated`; `reactions` of `from` on `to` about J, world axes. `place` is the
    largest position error of bodies and closures relative to the motion, m; `motion` is the same for rates and
    accelerations, relative to the largest; `balance` is the residual of the engine's balance, relative to its largest term.
    """

    drives: Array
    reactions: dict[str, Array]
    place: float
    motion: float
    balance: float
