"""Forces of springs, for engines that have none between bodies."""

from __future__ import annotations

import numpy as np

from mechanism import Mechanism
from spatial import Array, motion_shift, moved_wrench
from tables import Sample


def spring_wrenches(mechanism: Mechanism, sample: Sample) -> dict[str, Array]:
    """Wrenches of all springs on bodies about their origins, by the formula of docs/src/model-file.md."""
    result: dict[str, Array] = {}
    for spring in mechanism.springs:
        ends, rates = [], []
        for body, place in ((spring.predecessor, spring.at_from), (spring.successor, spring.at_to)):
            lever = sample.poses[body].rotation @ place
            ends.append(sample.poses[body].position + lever)
            rates.append((motion_shift(lever) @ sample.motions[body])[:3])
        line = ends[1] - ends[0]
        distance = float(np.linalg.norm(line))
        direction = line / distance
        pull = spring.stiffness * (distance - spring.free_length)
        pull += spring.damping * float(direction @ (rates[1] - rates[0]))
        for body, end, sign in ((spring.predecessor, ends[0], 1.0), (spring.successor, ends[1], -1.0)):
            force = np.concatenate([sign * pull * direction, np.zeros(3)])
            moved = moved_wrench(force, end - sample.poses[body].position)
            result[body] = result.get(body, np.zeros(6)) + moved
    return result
