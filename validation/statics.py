"""What of the reactions statics determines.

Planar linkages modelled in space have redundant constraints: reactions are unique but for self-stresses, sets of
constraint wrenches that are in balance on every body. Two solutions of the balance differ by a self-stress, and by
nothing else.
"""

from __future__ import annotations

import numpy as np

from mechanism import GROUND, Mechanism, Pose
from spatial import Array, moved_wrench


class SelfStress:
    """The self-stresses at a position; moments over the characteristic length, so that all is in newtons."""

    def __init__(self, mechanism: Mechanism, poses: dict[str, Pose]) -> None:
        self.length = mechanism.length
        self.joints = [joint for joint in mechanism.joints.values() if joint.kind != "free"]
        bodies = mechanism.moving()
        carried, columns = [], []
        for joint in self.joints:
            basis = joint.constraints(poses, self.length)
            carried.append(basis)
            origin = joint.frames(poses)[0].position
            for wrench in basis.T:
                full = np.concatenate([wrench[:3], self.length * wrench[3:]])
                column = np.zeros(6 * len(bodies))
                for body, sign in ((joint.successor, 1.0), (joint.predecessor, -1.0)):
                    if body != GROUND:
                        at_body = moved_wrench(full, origin - poses[body].position)
                        at_body[3:] /= self.length
                        column[6 * bodies.index(body) :][:6] += sign * at_body
                columns.append(column)
        balance = np.array(columns).T
        # As many null directions as singular values that are zero; those of the gallery are far from the limit.
        _, values, right = np.linalg.svd(balance)
        rank = int(np.sum(values > 1e-9 * values[0]))
        null = right[rank:].T
        blocks, row = [], 0
        for basis in carried:
            blocks.append(basis @ null[row : row + basis.shape[1]])
            row += basis.shape[1]
        self.count = null.shape[1]
        # Orthonormal, since the bases of the joints are.
        self.basis = np.vstack(blocks)

    def stack(self, reactions: dict[str, Array]) -> Array:
        """All joints' wrenches in one vector; those that are not given are taken as zero."""
        scale = np.repeat([1.0, 1.0 / self.length], 3)
        return np.concatenate([scale * reactions.get(joint.name, np.zeros(6)) for joint in self.joints])

    def unstack(self, vector: Array) -> dict[str, Array]:
        scale = np.repeat([1.0, self.length], 3)
        return {joint.name: scale * vector[6 * i : 6 * i + 6] for i, joint in enumerate(self.joints)}

    def beyond(self, difference: dict[str, Array]) -> tuple[dict[str, Array], dict[str, Array]]:
        """Splits a difference of reactions into what is no self-stress, and the self-stress.

        Joints that are missing in `difference` do not count: the self-stress is found from the others.
        """
        stacked = self.stack(difference)
        known = np.repeat([joint.name in difference for joint in self.joints], 6)
        if self.count == 0:
            return self.unstack(stacked), self.unstack(np.zeros_like(stacked))
        amounts = np.linalg.lstsq(self.basis[known], stacked[known], rcond=1e-9)[0]
        stress = self.basis @ amounts
        rest = np.where(known, stacked - stress, 0.0)
        return self.unstack(rest), self.unstack(stress)
