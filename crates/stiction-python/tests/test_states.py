"""Batches of states."""

import numpy as np
import pytest
from conftest import neighbours

import stiction


def test_shapes_and_names(m):
    q, v, a = neighbours(m, 7)
    r = m.inverse_dynamics(q, v, a, reactions=True, frictions=True).check()
    assert r.status.shape == (7,) and r.status.dtype == np.int8 and r.ok and r.converged.all()
    assert r.efforts.shape == r.efforts_frictionless.shape == (7, 3)
    assert r.reactions.shape == (7, len(m.joints), 6)
    assert r.frictions.shape == (7, len(m.friction_interfaces), 4)
    assert abs(r.power_residual).max() < 1e-9
    np.testing.assert_array_equal(r.effort["leg2.P"], r.efforts[:, 1])
    np.testing.assert_array_equal(r.reaction["leg1.S"], r.reactions[:, m.joints.index("leg1.S")])
    np.testing.assert_array_equal(r.friction["leg1.P"][:, 2] * r.friction["leg1.P"][:, 0], r.friction["leg1.P"][:, 3])
    one = m.inverse_dynamics(q[3], v[3], a[3], reactions=True)
    assert one.efforts.shape == (3,) and one.reactions.shape == (len(m.joints), 6)
    assert one.effort["leg1.P"].shape == ()
    # Each row starts from the previous row, so results differ by rounding only.
    np.testing.assert_allclose(one.efforts, r.efforts[3], rtol=1e-10)
    with pytest.raises(stiction.InputError, match="reactions"):
        m.inverse_dynamics(q).reaction


def test_efforts_are_those_of_a_run(m):
    r = m.inverse(load="none")
    columns = [r.joint[name] for name in m.actuators]
    q, v, a = (np.column_stack([getattr(c, x) for c in columns]) for x in ("position", "rate", "acceleration"))
    s = m.inverse_dynamics(q, v, a, load="none").check()
    moving = (abs(v) > 1e-9).all(axis=1)
    assert moving.sum() > 50
    # Actuator coordinates are computed from those of the platform, and the batch inverts this relation.
    np.testing.assert_allclose(s.efforts[moving], r.efforts[moving], atol=1e-9 * abs(r.efforts).max())
    k = m.kinematics(q, v, a).check()
    np.testing.assert_allclose(k.position["platform"], r.position["platform"], atol=1e-10)
    dot = (k.quaternion["platform"] * r.quaternion["platform"]).sum(axis=1)
    np.testing.assert_allclose(abs(dot), 1, atol=1e-12)
    assert (k.quaternions[..., 0] >= 0).all()


def test_results_do_not_depend_on_threads(m):
    q, v, a = neighbours(m, 2000)
    one = m.inverse_dynamics(q, v, a, reactions=True, threads=1)
    for threads in (2, 5, None):
        other = m.inverse_dynamics(q, v, a, reactions=True, threads=threads)
        assert one.efforts.tobytes() == other.efforts.tobytes()
        assert one.reactions.tobytes() == other.reactions.tobytes()


@pytest.mark.parametrize("friction", [False, True])
def test_derivatives_are_differences(m, friction):
    q, v, a = neighbours(m, 5)
    # No actuator is at a reversal, where friction jumps.
    v = v + 0.003
    r = m.inverse_dynamics(q, v, a, friction=friction, derivatives=True).check()
    d = r.derivatives
    assert d.q.shape == d.v.shape == d.a.shape == (5, 3, 3) and d.defined.all()
    for of, array, step in (("q", q, 1e-6), ("v", v, 1e-6), ("a", a, 1e-3)):
        for k in range(3):
            def moved(sign):
                moving = {"q": q.copy(), "v": v.copy(), "a": a.copy()}
                moving[of][:, k] += sign * step
                return m.inverse_dynamics(**moving, friction=friction).check().efforts

            wanted = (moved(1) - moved(-1)) / (2 * step)
            # Rounding of the efforts, 1e-12 of some hundred newton, divided by the step.
            np.testing.assert_allclose(getattr(d, of)[:, :, k], wanted, atol=1e-3, rtol=1e-5)
    one = m.inverse_dynamics(q[0], v[0], a[0], friction=friction, derivatives=True).derivatives
    np.testing.assert_allclose(one.a, d.a[0], rtol=1e-9)
    if not friction:
        np.testing.assert_allclose(one.a, m.mass_matrix(q[0]).check().array, rtol=1e-9)


def test_derivatives_are_missing_where_efforts_jump(m):
    at_rest = m.inverse_dynamics(m.home(), friction=True, derivatives=True)
    assert at_rest.ok and not at_rest.derivatives.defined.any()
    assert np.isnan(at_rest.derivatives.v).all() and "1 without" in repr(at_rest.derivatives)
    assert m.inverse_dynamics(m.home()).derivatives is None
    with pytest.raises(stiction.InputError, match="converged friction"):
        m.inverse_dynamics(m.home(), friction="one-pass", derivatives=True)


def test_jacobian_and_mass_matrix(m):
    q, v, _ = neighbours(m, 5)
    jacobian = m.jacobian(q).check()
    twists = m.kinematics(q, v).check().twists
    np.testing.assert_allclose(np.einsum("nbik,nk->nbi", jacobian.array, v), twists, atol=1e-12 * abs(twists).max())
    assert jacobian.body["platform"].shape == (5, 6, 3)
    mass = m.mass_matrix(q).check().array
    np.testing.assert_allclose(mass, mass.transpose(0, 2, 1), atol=1e-10 * abs(mass).max())
    assert (np.linalg.eigvalsh(mass) > 0).all()
    # Efforts without friction are linear in the accelerations.
    a = np.array([1.0, -2.0, 0.5])
    rest, moved = (m.inverse_dynamics(q, a=x, friction=False).efforts for x in (None, np.tile(a, (5, 1))))
    np.testing.assert_allclose(moved - rest, mass @ a, atol=1e-10 * abs(moved).max())


def test_other_coordinates():
    m = stiction.load("gough")
    names = [f"platform.{x}" for x in ("x", "y", "z", "rx", "ry", "rz")]
    assert list(m.coordinates(names)) == names and m.coordinates(names)["platform.rz"] == "rad"
    home = m.home(names)
    by_pose = m.inverse_dynamics(home, coordinates=names, friction=False).check()
    by_legs = m.inverse_dynamics(m.home(), friction=False).check()
    np.testing.assert_allclose(by_pose.efforts, by_legs.efforts, rtol=1e-9)
    with pytest.raises(stiction.InputError, match="actuators"):
        stiction.load("gough")._native.states(coordinates=names).mass_matrix(home)
    with pytest.raises(stiction.Error, match="plaform"):
        m.home(["plaform.x"])


def test_rows_without_an_answer_have_a_status(m):
    q, v, a = neighbours(m, 6)
    q[1, 0] += 100.0
    v[2, 0] = np.nan
    q[3, 1] = np.inf
    a[4] = -np.inf
    r = m.inverse_dynamics(q, v, a)
    assert r.status.tolist() == [0, 2, 1, 1, 1, 0]
    assert np.isnan(r.efforts[1:5]).all() and np.isfinite(r.efforts[[0, 5]]).all()
    with pytest.raises(stiction.ComputationError, match="row 1") as raised:
        r.check()
    assert raised.value.details["rows"] == 4
    # A failed row changes the next row by rounding at most.
    alone = m.inverse_dynamics(q[5], v[5], a[5])
    np.testing.assert_allclose(alone.efforts, r.efforts[5], rtol=1e-10)


def test_loads_and_payloads(m):
    q = m.home()
    without = m.inverse_dynamics(q, load="none", friction=False).efforts
    with_load = m.inverse_dynamics(q, load="platform.fz = -100 N", friction=False).efforts
    k = m.jacobian(q).body["platform"]
    # Virtual work of a force at the platform's origin, or at its centre of mass: both lie on one vertical.
    np.testing.assert_allclose(with_load - without, 100.0 * k[2], rtol=1e-6)


def test_codes_are_those_of_the_native_module():
    from stiction import _native

    names = [name for name, _ in _native.outcomes()]
    assert names == [status.name.lower() for status in stiction.Status]
    assert all(status.reason for status in stiction.Status)


@pytest.mark.parametrize("name", ["3rrr", "3rps", "five-bar", "gough", "delta"])
def test_a_motion_that_begins_at_home_begins_in_its_assembly_mode(name):
    robot = stiction.load(name)
    units = robot.coordinates()
    motion = "; ".join(f"{key} = {float(q)!r} {units[key]}" for key, q in zip(units, robot.home()))
    r = robot.inverse(motion + "; duration = 0", load="none", friction=False)
    home = robot.kinematics(robot.home())
    for body in robot.bodies[1:]:
        assert abs(r.position[body][0] - home.position[body]).max() < 1e-9


def motorized():
    """A five-bar with a motor on one joint, with a gear, a rotor, friction and losses, and an ideal one on the other."""
    text = stiction.load("five-bar").text + """
[actuators.M]
joint = "left_motor"
ratio = 20
rotor_inertia = "1e-4 kg m^2"
motor_friction = { constant = "0.01 N m", viscous = "1e-5 N m s/rad" }
efficiency = 0.9
[actuators.N]
joint = "right_motor"
ratio = -10
"""
    return stiction.load(text)


def test_motors_are_those_of_a_run():
    m = motorized()
    assert m.motors == ["M", "N"]
    r = m.inverse(load="none")
    columns = [r.joint[name] for name in m.actuators]
    q, v, a = (np.column_stack([getattr(c, x) for c in columns]) for x in ("position", "rate", "acceleration"))
    s = m.inverse_dynamics(q, v, a, load="none", motors=True).check()
    assert s.motor_torques.shape == s.motor_speeds.shape == (len(r), 2) and s.motor_torque["M"].shape == (len(r),)
    assert m.inverse_dynamics(q[0], motors=True).motor_torques.shape == (2,)
    moving = (abs(v) > 1e-6).all(axis=1)
    assert moving.sum() > 50
    for name in m.motors:
        for expected, found in ((r.motor_torque, s.motor_torque), (r.motor_speed, s.motor_speed)):
            expected, found = expected[name][moving], found[name][moving]
            np.testing.assert_allclose(found, expected, atol=1e-9 * abs(expected).max())
    # An ideal gear, by hand.
    np.testing.assert_allclose(s.motor_torque["N"], -s.effort["right_motor"] / 10, rtol=1e-12)
    np.testing.assert_allclose(s.motor_speed["M"], 20 * v[:, 0], atol=1e-12)
    # Without friction, only the rotor adds to the effort over the ratio.
    ideal = m.inverse_dynamics(q, v, a, load="none", friction=False, motors=True).check()
    by_hand = ideal.effort["left_motor"] / 20 + 1e-4 * 20 * a[:, 0]
    np.testing.assert_allclose(ideal.motor_torque["M"], by_hand, rtol=1e-9, atol=1e-12)
    with pytest.raises(stiction.InputError, match="motors=True"):
        m.inverse_dynamics(q).motor_torque
    assert stiction.load("3rps").inverse_dynamics(stiction.load("3rps").home(), motors=True).motor_torques.shape == (0,)


def test_a_bushing_that_is_rotated_too_far_is_an_outcome():
    m = stiction.load("""
gravity = [0, 0, 0]
[bodies.b]
mass = 1
com = [0, 0, 0]
inertia = [1, 1, 1]
[joints.j]
type = "R"
from = "ground"
to = "b"
axis = "y"
actuated = true
[bushings.B]
from = "ground"
to = "b"
stiffness = [1, 1, 1, 1, 1, 1]
""")
    r = m.inverse_dynamics([[0.0], [np.pi]])
    assert r.status.tolist() == [0, stiction.Status.SPRING_TURNED]
    with pytest.raises(stiction.ComputationError, match="rotated too far"):
        r.check()


def test_starts_select_the_assembly_mode():
    m = stiction.load("five-bar")
    other = m.with_({"joints.left_elbow.start": "80 deg", "joints.left_motor.start": "50 deg"})
    modes = [one.check()["assembly"] for one in (m, other)]
    elbows = [mode["coordinates"]["left_elbow"] for mode in modes]
    # The tool is at the same place, with the elbow on its other side.
    assert elbows[0] < -0.5 and abs(elbows[0] + elbows[1]) < 1e-9
    assert all(0 <= mode["distance"] < 1 for mode in modes)
    assert other.home()[1] == pytest.approx(m.home()[1]) and abs(other.home()[0] - m.home()[0]) > 0.5
    shown = m._repr_html_()
    assert f"left_motor = {m.home()[0]:.4g} rad" in shown
