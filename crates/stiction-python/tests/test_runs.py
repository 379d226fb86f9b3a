"""Runs: comparison with the command line and with closed forms; events."""

import csv
import json

import numpy as np
import pytest

import stiction

# Closed forms of the pendulum in crates/stiction/examples: mass, kg, length, m, gravity, m/s^2.
MASS, LENGTH, GRAVITY = 2.0, 0.4, 9.81
INERTIA = 1e-3 + MASS * LENGTH**2


def table(path):
    with open(path, newline="") as file:
        header, *rows = csv.reader(file)
    return header, np.array([[float(cell) for cell in row] for row in rows])


@pytest.mark.parametrize("model", ["zhang2018-regular", "five-bar", "gough", "delta"])
@pytest.mark.parametrize("threads", [1, 3])
def test_inverse_has_the_bits_of_the_command_line(cli, tmp_path, model, threads):
    folder = cli("inverse", model, "--threads", "1", folder=tmp_path / "out")
    r = stiction.load(model).inverse(threads=threads)
    assert {path.stem for path in folder.glob("*.csv")} == set(r.tables)
    for name, mine in r.tables.items():
        header, numbers = table(folder / f"{name}.csv")
        assert mine.columns == header
        # CSV files contain all digits.
        np.testing.assert_array_equal(mine.array, numbers)
    assert r.summary == json.loads((folder / "summary.json").read_text())


def test_forward_has_the_bits_of_the_command_line(cli, tmp_path):
    folder = cli("forward", "five-bar", "--until", "0.2", folder=tmp_path / "out")
    r = stiction.load("five-bar").forward(until=0.2)
    for name, mine in r.tables.items():
        header, numbers = table(folder / f"{name}.csv")
        assert mine.columns == header
        np.testing.assert_array_equal(mine.array, numbers)
    with open(folder / "events.csv", newline="") as file:
        rows = list(csv.reader(file))[1:]
    assert [(float(t), *rest) for t, *rest in rows] == [tuple(event) for event in r.events]
    assert r.summary == json.loads((folder / "summary.json").read_text())


def test_names_lead_to_the_columns_of_the_tables(m):
    r = m.inverse(step=0.1)
    n = len(r)
    assert list(r.effort) == m.actuators
    assert r.efforts.shape == (n, 3)
    t = r.tables["inverse"]
    for name in m.actuators:
        assert r.effort[name] is not None
        np.testing.assert_array_equal(r.effort[name], t[f"{name}.drive [N]"])
        np.testing.assert_array_equal(r.effort_frictionless[name], t[f"{name}.drive_frictionless"])
        assert (r.effort_low[name] <= r.effort[name]).all()
        assert (r.effort[name] <= r.effort_high[name]).all()
    assert list(r.reaction) == list(r.reaction_determined) == m.joints
    columns = [f"leg1.S.{x}" for x in ("fx", "fy", "fz", "mx", "my", "mz")]
    stacked = np.column_stack([r.tables["reactions"][column] for column in columns])
    np.testing.assert_array_equal(r.reaction["leg1.S"], stacked)
    assert r.reaction_determined["leg1.S"].dtype == bool
    assert list(r.friction) == m.friction_interfaces
    f = r.friction["leg1.P"]
    np.testing.assert_array_equal(f.power, r.tables["friction"]["leg1.P.power"])
    np.testing.assert_allclose(f.force * f.speed, f.power, rtol=1e-14, atol=1e-300)
    assert r.joint["leg1.P"].rate.shape == (n,)
    assert r.position["platform"].shape == (n, 3)
    np.testing.assert_allclose(np.linalg.norm(r.quaternion["platform"], axis=1), 1, atol=1e-15)
    assert r.summary and r.cautions == r.summary.get("cautions", [])
    assert "leg1.P" in r.text and "<pre>" in r._repr_html_()


def test_contributions_of_friction_sum_to_its_share_of_an_effort(m):
    r = m.inverse(step=0.1)
    for name in m.actuators:
        total = sum(r.contribution[name].values())
        # The contributions add up to the effect of friction, with a rounding error for each joint.
        np.testing.assert_allclose(
            total, r.effort[name] - r.effort_frictionless[name], atol=1e-9 * abs(r.efforts).max()
        )


def test_efforts_of_a_pendulum_are_the_closed_form(pendulum):
    r = pendulum.inverse("pivot = 0.5 rad/s^2*t^2; duration = 1 s", friction=False, step=0.1)
    angle = 0.5 * r.time**2
    exact = INERTIA * 1.0 + MASS * GRAVITY * LENGTH * np.sin(angle)
    np.testing.assert_allclose(r.effort["pivot"], exact, rtol=1e-12)
    np.testing.assert_allclose(r.joint["pivot"].position, angle, atol=1e-15)


def test_friction_modes(m):
    on, off, one = (m.inverse(step=0.25, friction=mode) for mode in (True, False, "one-pass"))
    np.testing.assert_array_equal(off.efforts, np.column_stack(list(on.effort_frictionless.values())))
    assert not np.array_equal(on.efforts, off.efforts)
    assert not np.array_equal(on.efforts, one.efforts)


def test_frames(m):
    pandas, polars = pytest.importorskip("pandas"), pytest.importorskip("polars")
    r = m.inverse(step=0.5)
    frame = r.to_pandas()
    assert isinstance(frame, pandas.DataFrame)
    np.testing.assert_array_equal(frame.to_numpy(), r.tables["inverse"].array)
    frame = r.to_polars("reactions")
    assert isinstance(frame, polars.DataFrame) and frame.columns == r.tables["reactions"].columns


def test_parquet_files_have_the_numbers_and_units_of_the_tables(m, tmp_path):
    import json

    parquet = pytest.importorskip("pyarrow.parquet")
    r = m.inverse(step=0.25)
    paths = r.to_parquet(tmp_path / "new" / "folder")
    assert sorted(path.stem for path in paths) == sorted(r.tables)
    assert sorted(tmp_path.glob("new/folder/*")) == sorted(paths)
    for path in paths:
        table, own = parquet.read_table(path), r.tables[path.stem]
        assert table.column_names == own.columns
        read = np.column_stack([column.to_numpy() for column in table.columns])
        np.testing.assert_array_equal(read, own.array)
        assert json.loads(table.schema.metadata[b"stiction.summary"]) == r.summary
    efforts = r.to_arrow()
    assert efforts.field("leg1.P.drive [N]").metadata == {b"unit": b"N"}
    assert efforts.field("time [s]").metadata == {b"unit": b"s"}
    assert r.to_arrow("reactions").num_rows == len(r)


def test_a_missing_package_is_named(m, monkeypatch):
    import sys

    r = m.inverse(step=0.5)
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(stiction.InputError, match="pandas"):
        r.to_pandas()
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(stiction.InputError, match="pyarrow"):
        r.to_parquet("nowhere")


def test_a_released_pendulum_keeps_its_energy(pendulum):
    r = pendulum.forward(at={"pivot": 1.0}, until=2.0, friction=False, controller="none")
    energy = r.kinetic_energy + r.potential_energy
    # The relative tolerance of a step is 1e-10.
    assert abs(energy - energy[0]).max() < 1e-7
    rate = r.joint["pivot"].rate
    drop = np.cos(r.joint["pivot"].position) - np.cos(1.0)
    np.testing.assert_allclose(
        0.5 * INERTIA * rate**2, MASS * GRAVITY * LENGTH * drop, atol=1e-7
    )


def test_efforts_as_formulas_and_stop_conditions(pendulum):
    r = pendulum.forward(
        at={"pivot": 0.5},
        rate={"pivot": -1.0},
        drives={"pivot": "-2 N m/rad*pivot"},
        stop="pivot < 0 rad",
        until=5.0,
    )
    assert r.events[-1].event == "stop" and r.events[-1].time == r.time[-1]
    assert abs(r.joint["pivot"].position[-1]) < 1e-8
    np.testing.assert_allclose(r.effort["pivot"], -2.0 * r.joint["pivot"].position, atol=1e-12)
    assert r.ended is None and r.friction["pivot"].flag.dtype == bool


def test_stop_conditions_of_python_act_like_the_same_formulas(pendulum):
    options = {"at": {"pivot": 0.5}, "rate": {"pivot": -1.0}, "until": 5.0}
    formula = pendulum.forward(stop="pivot < 0.1 rad", **options)

    def angle(state):
        assert state.q.shape == state.v.shape == (1,) and state.reference_q.shape == (0,)
        return state.q[0] - 0.1

    function = pendulum.forward(stop=angle, **options)
    assert function.events[-1].event == "stop" and function.events[-1].detail == "angle"
    # The same instants of the integration, and the same search: the same bits.
    assert function.time[-1] == formula.time[-1]
    np.testing.assert_array_equal(function.joint["pivot"].position, formula.joint["pivot"].position)
    # The first condition that becomes true ends the simulation, in any mixture.
    both = pendulum.forward(stop=["pivot < -1 rad", lambda state: state.q[0] - 0.1], **options)
    assert both.time[-1] == formula.time[-1] and both.events[-1].detail == "function"
    timed = pendulum.forward(stop=lambda state: 0.25 - state.time, **options)
    assert abs(timed.time[-1] - 0.25) < 1e-9


def test_failures_of_stop_conditions(pendulum):
    def call(stop, **options):
        return pendulum.forward(stop=stop, until=0.1, **options)

    with pytest.raises(ZeroDivisionError):
        call(lambda state: 1 / 0)
    for wrong in ("text", None, [1.0, 2.0], float("nan"), {}):
        with pytest.raises(stiction.InputError, match="stop condition"):
            call(lambda state, wrong=wrong: wrong)
    for wrong in (3.0, [3.0], object()):
        with pytest.raises(stiction.InputError, match="stop"):
            call(wrong)
    with pytest.raises(stiction.InputError, match="has no report"):
        call(lambda state: 1.0).report()


def test_a_control_law_of_python_acts_like_the_same_formula(pendulum):
    options = {"at": {"pivot": 0.5}, "until": 1.0, "friction": False}
    calls = []

    def law(state):
        calls.append(state.time)
        return {"pivot": -3.0 * state.q[0] - 0.4 * state.v[0]}

    r = pendulum.forward(controller=law, period=1e-3, **options)
    exact = pendulum.forward(drives={"pivot": "-3 N m/rad*pivot - 0.4 N m s/rad*d(pivot)"}, **options)
    # Efforts that are held for a period lag by half of it: about 0.5 ms times the largest rate.
    np.testing.assert_allclose(r.joint["pivot"].position, exact.joint["pivot"].position, atol=2e-3)
    assert len(calls) >= 1000 and calls == sorted(calls)
    # The effort of a sample is that which the law returns for its state.
    q, v = r.joint["pivot"].position, r.joint["pivot"].rate
    np.testing.assert_allclose(r.effort["pivot"], -3.0 * q - 0.4 * v, atol=1e-6)


def test_a_control_law_follows_the_motion(m):
    stiffness, damping = 2e5, 2e3

    def law(state):
        assert state.q.shape == state.reference_q.shape == state.reference_a.shape == (3,)
        return stiffness * (state.reference_q - state.q) + damping * (state.reference_v - state.v)

    r = m.forward(controller=law, period=5e-4, until=0.1, friction=False)
    for name in m.actuators:
        assert abs(r.reference[name] - r.joint[name].position).max() < 2e-3


def test_failures_of_control_laws(pendulum):
    def call(law, **options):
        return pendulum.forward(controller=law, until=0.1, **options)

    with pytest.raises(ZeroDivisionError):
        call(lambda state: 1 / 0)
    for wrong in ([1.0, 2.0], "text", None, {"pivto": 1.0}, {"pivot": float("nan")}, 3.0):
        with pytest.raises(stiction.InputError):
            call(lambda state, wrong=wrong: wrong)
    with pytest.raises(stiction.Error, match="returned NaN"):
        call(lambda state: [float("nan")])
    for period in (0.0, -1.0, 1e-12, float("nan"), "text"):
        with pytest.raises(stiction.InputError, match="period"):
            call(lambda state: [0.0], period=period)
    # A control law may call functions of the package.
    weight = call(lambda state: pendulum.inverse_dynamics(state.q, friction=False).efforts)
    assert np.isfinite(weight.effort["pivot"]).all()


def test_a_simulation_that_cannot_go_on_raises_with_its_samples():
    m = stiction.load("five-bar")
    with pytest.raises(stiction.ComputationError) as raised:
        m.forward(drives={"left_motor": 1e12}, until=1.0)
    assert raised.value.result is not None and raised.value.result.ended is raised.value
    assert len(raised.value.result) >= 1 and "at t = " in str(raised.value)


def test_check_and_breakaway(m):
    report = m.check(step=0.1)
    assert report["mobility"]["instantaneous"] == 3
    assert "degrees of freedom" in str(report) or str(report)
    assert m.breakaway(at=0.5).text and len(m.breakaway()) > 0
    with pytest.raises(stiction.UnknownNameError, match="mobility"):
        report["mobilty"]


def test_identify(tmp_path):
    arm = """
    gravity = [0, 0, 0]
    [bodies.arm]
    mass = "1 kg"
    com = [0, 0, 0]
    inertia = [0.02, 0.02, 0.02]
    [joints.axis]
    type = "R"
    from = "ground"
    to = "arm"
    axis = "z"
    actuated = true
    """
    (tmp_path / "arm.toml").write_text(arm)
    rate = np.concatenate([np.linspace(-5.0, -0.5, 10), np.linspace(0.5, 5.0, 10)])
    noise = np.random.default_rng(1).normal(0.0, 0.01, rate.size)
    effort = 2.0 * np.sign(rate) + 0.5 * rate + noise
    rows = [f"{v},{tau}" for v, tau in zip(rate, effort, strict=True)]
    (tmp_path / "log.csv").write_text("d(axis) [rad/s],axis.effort [N m]\n" + "\n".join(rows))
    options = 'estimate = "friction"\n[[logs]]\nfile = "log.csv"\nsteady = true\n'
    (tmp_path / "options.toml").write_text(options)
    m = stiction.load(tmp_path / "arm.toml")
    found = m.identify(tmp_path / "log.csv", options=tmp_path / "options.toml")
    values = {p["name"]: p for p in found["parameters"]}
    for name, truth in (("axis.coulomb", 2.0), ("axis.viscous", 0.5)):
        # Noise of 0.01 N m in 20 rows.
        assert abs(values[name]["value"] - truth) < 0.02, values[name]
    assert "axis.coulomb" in str(found) and "axis.coulomb = " in found["model"]
    with pytest.raises(stiction.InputError):
        m.identify(tmp_path / "missing.csv")


def test_progress(m):
    seen = []
    m.inverse(progress=lambda done, of: seen.append((done, of)))
    assert seen and all(0 <= done <= of for done, of in seen) and seen[-1][0] == seen[-1][1]
    with pytest.raises(RuntimeError, match="enough"):
        m.inverse(progress=lambda done, of: (_ for _ in ()).throw(RuntimeError("enough")))
    with pytest.raises(ZeroDivisionError):
        m.forward(until=50.0, progress=lambda done, of: 1 // 0)
