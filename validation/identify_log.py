"""Log of a five-bar with friction in four joints, for the tests of `stiction identify`.

Inertia and weight come from Pinocchio: the five-bar is cut at its tip, the efforts of the open chains follow from the
recursive Newton-Euler algorithm, friction of the cranks and elbows is added to them, and the rates of the closed
five-bar project all onto the motors. Nothing of Stiction takes part.

    python identify_log.py > ../crates/stiction-cli/tests/suite/identify/five_bar_pinocchio.csv
"""

import math
import sys

import numpy as np
import pinocchio as pin

HALF_BASE, CRANK, COUPLER = 0.06, 0.2, 0.28
CRANK_MASS, COUPLER_MASS, TOOL_MASS = 0.35, 0.22, 0.5
# Constant friction, N m, and viscous friction, N m s/rad: left crank and elbow, right crank and elbow.
COULOMB = np.array([0.08, 0.04, 0.06, 0.03])
VISCOUS = np.array([0.03, 0.015, 0.02, 0.012])
STEP, ROWS = 5e-3, 1200
NOISE, QUANTUM, ENCODER = 0.01, 5e-3, 2e-5


def rod(mass, length):
    """Inertia of a thin rod along x from the origin."""
    i = mass * length**2 / 12
    return pin.Inertia(mass, np.array([length / 2, 0, 0]), np.diag([0.0, i, i]))


def five_bar():
    """Both chains from the base to the tip, as one tree."""
    model = pin.Model()
    model.gravity.linear = np.array([0, -9.81, 0])
    for side, x in (("left", -HALF_BASE), ("right", HALF_BASE)):
        base = pin.SE3(np.eye(3), np.array([x, 0, 0]))
        crank = model.addJoint(0, pin.JointModelRZ(), base, f"{side}_crank")
        model.appendBodyToJoint(crank, rod(CRANK_MASS, CRANK), pin.SE3.Identity())
        at = pin.SE3(np.eye(3), np.array([CRANK, 0, 0]))
        coupler = model.addJoint(crank, pin.JointModelRZ(), at, f"{side}_coupler")
        model.appendBodyToJoint(coupler, rod(COUPLER_MASS, COUPLER), pin.SE3.Identity())
        tip = pin.SE3(np.eye(3), np.array([COUPLER, 0, 0]))
        if side == "left":
            tool = pin.Inertia(TOOL_MASS, np.zeros(3), 1e-4 * np.eye(3))
            model.appendBodyToJoint(coupler, tool, tip)
        model.addFrame(pin.Frame(f"{side}_tip", coupler, tip, pin.FrameType.OP_FRAME))
    return model


def wave(t, middle, terms):
    """Sum of sines with two derivatives."""
    value = middle + sum(a * math.sin(w * t + p) for a, w, p in terms)
    rate = sum(a * w * math.cos(w * t + p) for a, w, p in terms)
    return value, rate, sum(-a * w * w * math.sin(w * t + p) for a, w, p in terms)


def angles(x, y, side):
    """Crank and elbow angles with the elbow outside."""
    dx = x + HALF_BASE if side == "left" else x - HALF_BASE
    distance = math.hypot(dx, y)
    bend = math.acos((CRANK**2 + distance**2 - COUPLER**2) / (2 * CRANK * distance))
    sign = 1 if side == "left" else -1
    crank = math.atan2(y, dx) + sign * bend
    elbow = math.atan2(y - CRANK * math.sin(crank), dx - CRANK * math.cos(crank)) - crank
    return crank, elbow


def efforts(model, data, t):
    """Angles and torques of the motors."""
    x, vx, ax = wave(t, 0.0, [(0.06, 4.4, 0), (0.03, 10.7, 1)])
    y, vy, ay = wave(t, 0.36, [(0.04, 5.7, 0), (0.02, 13.2, 0)])
    q = np.array([*angles(x, y, "left"), *angles(x, y, "right")])
    v, a = np.zeros(4), np.zeros(4)
    jacobians = []
    world = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    for k, side in enumerate(("left", "right")):
        frame = model.getFrameId(f"{side}_tip")
        own = slice(2 * k, 2 * k + 2)
        jacobian = pin.computeFrameJacobian(model, data, q, frame, world)[:2, own]
        v[own] = np.linalg.solve(jacobian, [vx, vy])
        pin.forwardKinematics(model, data, q, v, np.zeros(4))
        pin.updateFramePlacements(model, data)
        drift = pin.getFrameClassicalAcceleration(model, data, frame, world).linear[:2]
        a[own] = np.linalg.solve(jacobian, np.array([ax, ay]) - drift)
        jacobians.append(jacobian)
    tree = pin.rnea(model, data, q, v, a) + COULOMB * np.sign(v) + VISCOUS * v
    # Rates of all joints for unit rates of the cranks: both chains move the tip alike.
    (left, right) = jacobians
    elbows = np.linalg.solve(
        np.column_stack([left[:, 1], -right[:, 1]]), np.column_stack([-left[:, 0], right[:, 0]])
    )
    rates = np.array([[1, 0], elbows[0], [0, 1], elbows[1]])
    return q[[0, 2]], rates.T @ tree


def main():
    """Writes the log with noise, quantised efforts and encoder steps."""
    model = five_bar()
    data = model.createData()
    random = np.random.default_rng(24)
    print("time [s],left_motor [rad],right_motor [rad],left_motor.effort [N m],right_motor.effort [N m]")
    for row in range(ROWS):
        t = row * STEP
        q, torque = efforts(model, data, t)
        torque = torque + NOISE * random.standard_normal(2)
        torque = np.round(torque / QUANTUM) * QUANTUM
        q = np.round(q / ENCODER) * ENCODER
        cells = [f"{t:.3f}", *(f"{x:.5f}" for x in q), *(f"{x:.3f}" for x in torque)]
        sys.stdout.write(",".join(cells) + "\n")


if __name__ == "__main__":
    main()
