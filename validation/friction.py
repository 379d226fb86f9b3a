"""Loads of contacts from reactions, and the friction that plain laws make of them (docs/src/friction.md)."""

from __future__ import annotations

import numpy as np

from mechanism import Joint, Mechanism, Pose
from spatial import Array, moved_wrench
from tables import Sample


def contact_name(joint: Joint, contact: dict) -> str:
    """As in friction.csv: with the contact's name if the joint has several."""
    return joint.name if len(joint.contacts) == 1 else f"{joint.name}.{contact['place']}"


def contact_load(joint: Joint, contact: dict, reaction: Array, poses: dict[str, Pose]) -> float:
    """Load on a pin, a guide or a ball, N, from the reaction [f, m] about the origin of J, world axes."""
    load = contact["load"]
    force = reaction[:3]
    if contact["shape"] == "ball":
        return float(np.linalg.norm(force)) + load["preload"]
    if contact["shape"] not in ("pin", "guide") or load["combine"] != "sum" or load["smoothing"]:
        raise NotImplementedError(f"{joint.name}: this program does not know such a contact")
    frame_j, frame_k = joint.frames(poses)
    supports = load["supports"]["on"]
    if supports == "to":
        reaction = moved_wrench(reaction, frame_j.position - frame_k.position)
    elif supports != "from":
        raise NotImplementedError(f"{joint.name}: this program does not know such supports")
    # The pin of a U joint's second freedom is about the x axis of K, all others are about the z axis of J.
    second = joint.kind == "U" and contact["dofs"] == [joint.freedoms[1].name]
    axis = frame_k.rotation[:, 0] if second else frame_j.rotation[:, 2]
    moment = reaction[3:]
    along, about = float(axis @ force), float(axis @ moment)
    total = float(np.linalg.norm(force - along * axis)) + load["preload"]
    if load["bending_span"]:
        total += 2.0 * float(np.linalg.norm(moment - about * axis)) / load["bending_span"]
    if contact["shape"] == "pin" and load["axial_ratio"]:
        total += abs(along) * load["axial_ratio"]
    if contact["shape"] == "guide" and load["torsion_arm"]:
        total += abs(about) / load["torsion_arm"]
    return total


def contact_loads(mechanism: Mechanism, reactions: dict[str, Array], poses: dict[str, Pose]) -> dict[str, float]:
    """Of all contacts at the joints that have a reaction here."""
    return {
        contact_name(joint, contact): contact_load(joint, contact, reactions[joint.name], poses)
        for joint in mechanism.joints.values()
        if joint.name in reactions
        for contact in joint.contacts
    }


def law_errors(mechanism: Mechanism, sample: Sample) -> list[float]:
    """For each contact with Coulomb and viscous friction: friction in the table less the law's, both in N.

    What is slower than a billionth of the fastest contact rests: there friction is no number, and the table has 0.
    """
    errors = []
    rest = 1e-9 * max(map(abs, sample.speeds.values()), default=0.0)
    for joint in mechanism.joints.values():
        for contact in joint.contacts:
            law, name = contact["law"], contact_name(joint, contact)
            plain = law["curve"]["kind"] == "constant" and not law["regularisation"] and not contact["backward"]
            if not plain:
                continue
            speed = sample.speeds[name]
            if abs(speed) <= rest:
                continue
            expected = law["mu"] * sample.contact_loads[name] * np.sign(speed) + law["viscous"] * speed
            errors.append(sample.frictions[name] - expected)
    return errors


def friction_efforts(mechanism: Mechanism, sample: Sample) -> dict[str, Array]:
    """Efforts of friction on the freedoms of every joint: the reaction's part along them, less the drive's."""
    efforts = {}
    for name, reaction in sample.reactions.items():
        joint = mechanism.joints[name]
        efforts[name] = joint.twists(sample.poses).T @ reaction
    for (joint, k), drive in zip(mechanism.actuated(), sample.drives):
        efforts[joint.name][k] -= drive
    return efforts


def friction_by_the_tables(mechanism: Mechanism, sample: Sample) -> dict[str, Array]:
    """The same efforts from friction.csv: force times radius against the sliding, for pins, guides and balls."""
    efforts = {name: np.zeros(len(mechanism.joints[name].freedoms)) for name in sample.reactions}
    for joint in mechanism.joints.values():
        for contact in joint.contacts:
            force = sample.frictions[contact_name(joint, contact)]
            if contact["shape"] == "ball":
                relative = sample.motions[joint.successor][3:] - sample.motions[joint.predecessor][3:]
                in_k = joint.frames(sample.poses)[1].rotation.T @ relative
                speed = float(np.linalg.norm(in_k))
                direction = in_k / speed if speed > 0.0 else in_k
                efforts[joint.name] -= force * contact["radius"] * direction
            else:
                k = [freedom.name for freedom in joint.freedoms].index(contact["dofs"][0])
                arm = contact["radius"] if contact["shape"] == "pin" else 1.0
                efforts[joint.name][k] -= force * arm
    return efforts
