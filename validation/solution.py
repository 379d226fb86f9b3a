"""What an engine says."""

from __future__ import annotations

from dataclasses import dataclass

from spatial import Array


@dataclass(frozen=True)
class Solution:
    """Drives and reactions at one instant.

    `drives` in the order of `Mechanism.actuated`; `reactions` of `from` on `to` about J, world axes. `place` says how
    well the engine's own places of bodies and closures agree with the motion, m; `motion` the same for rates and
    accelerations, relative to the largest; `balance` what the engine's balance leaves, relative to its largest term.
    """

    drives: Array
    reactions: dict[str, Array]
    place: float
    motion: float
    balance: float
