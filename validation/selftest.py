"""Shows that the comparisons can fail: what is wrong by a millionth is noticed, by every engine."""

from __future__ import annotations

import xml.etree.ElementTree as xml
from dataclasses import replace
from pathlib import Path
from typing import Callable, Iterator

import numpy as np

from compare import Solver, compare
from program import Case
from tables import Sample

WRONG = 1e-6

#: makes an engine from a case
Maker = Callable[[Case], Solver]


def mutations(case: Case) -> Iterator[tuple[str, Case, bool]]:
    """Cases with something wrong: in words, the case, and whether it shows with friction only."""
    middle = len(case.frictionless) // 2

    def with_sample(samples: list[Sample], change: Callable[[Sample], Sample]) -> list[Sample]:
        return [change(sample) if i == middle else sample for i, sample in enumerate(samples)]

    def drive(sample: Sample) -> Sample:
        drives = sample.drives.copy()
        drives[int(np.argmax(np.abs(drives)))] *= 1.0 + WRONG
        return replace(sample, drives=drives)

    def reaction(sample: Sample) -> Sample:
        name = max(sample.reactions, key=lambda joint: float(np.max(np.abs(sample.reactions[joint][:3]))))
        wrench = sample.reactions[name].copy()
        wrench[int(np.argmax(np.abs(wrench[:3])))] *= 1.0 + WRONG
        return replace(sample, reactions={**sample.reactions, name: wrench})

    def load(sample: Sample) -> Sample:
        name = max(sample.contact_loads, key=lambda contact: sample.contact_loads[contact])
        return replace(
            sample, contact_loads={**sample.contact_loads, name: sample.contact_loads[name] * (1.0 + WRONG)}
        )

    def friction(sample: Sample) -> Sample:
        name = max(sample.frictions, key=lambda contact: abs(sample.frictions[contact]))
        return replace(sample, frictions={**sample.frictions, name: sample.frictions[name] * (1.0 + WRONG)})

    yield "a drive", replace(case, frictionless=with_sample(case.frictionless, drive)), False
    yield "a reaction", replace(case, frictionless=with_sample(case.frictionless, reaction)), False
    yield "a drive with friction", replace(case, with_friction=with_sample(case.with_friction, drive)), True
    yield "a reaction with friction", replace(case, with_friction=with_sample(case.with_friction, reaction)), True
    yield "a contact's load", replace(case, with_friction=with_sample(case.with_friction, load)), True
    yield "a contact's friction", replace(case, with_friction=with_sample(case.with_friction, friction)), True
    yield "a mass", with_wrong_mass(case), False
    yield "a joint's place", with_wrong_place(case), False


def with_wrong_mass(case: Case) -> Case:
    """The heaviest body's mass, both in the description and in the exported file."""
    bodies = case.mechanism.bodies
    heavy = max(bodies.values(), key=lambda body: body.mass)
    changed = {**bodies, heavy.name: replace(heavy, mass=heavy.mass * (1.0 + WRONG))}
    root = xml.parse(case.mjcf).getroot()
    inertial = root.find(f".//body[@name='{heavy.name}']/inertial")
    inertial.set("mass", repr(float(inertial.get("mass")) + heavy.mass * WRONG))
    return replace(case, mechanism=replace(case.mechanism, bodies=changed), mjcf=copy(root, case.mjcf))


def with_wrong_place(case: Case) -> Case:
    """Where the last joint sits, in the description; a point of the last equality, in the exported file."""
    joints = dict(case.mechanism.joints)
    last = list(joints.values())[-1]
    place = replace(last.frame_to, position=last.frame_to.position + np.array([0.0, WRONG, 0.0]))
    joints[last.name] = replace(last, frame_to=place)
    root = xml.parse(case.mjcf).getroot()
    site = root.find(f".//site[@name='{root.findall('equality/*')[-1].get('site1')}']")
    x, *others = site.get("pos").split()
    site.set("pos", " ".join([repr(float(x) + WRONG), *others]))
    return replace(case, mechanism=replace(case.mechanism, joints=joints), mjcf=copy(root, case.mjcf))


def copy(root: xml.Element, beside: Path) -> Path:
    path = beside.with_name(f"wrong-{beside.name}")
    xml.ElementTree(root).write(path, encoding="utf-8")
    return path


def unnoticed(case: Case, makers: dict[str, Maker]) -> list[str]:
    """Whatever an engine did not notice, or finds wrong where nothing is, in words."""
    complaints = []
    for name, maker in makers.items():
        for with_friction in (False, True):
            if not compare(maker(case), case, with_friction).agrees():
                complaints.append(f"{case.model}, {name}: does not agree to begin with")
        for what, wrong, with_friction in mutations(case):
            try:
                noticed = not compare(maker(wrong), wrong, with_friction).agrees()
            except RuntimeError:  # an engine that cannot assemble it has noticed it, too
                noticed = True
            if not noticed:
                complaints.append(f"{case.model}, {name}: {what} wrong by a millionth is not noticed")
    return complaints
