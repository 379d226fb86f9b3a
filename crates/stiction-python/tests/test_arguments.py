"""Tables and masked arrays as states, paths, and numbers without a unit."""

import os

import numpy as np
import pytest

import stiction


@pytest.fixture(scope="module")
def robot():
    return stiction.load("3rps")


def frames(columns):
    pandas, polars, pyarrow = (pytest.importorskip(name) for name in ("pandas", "polars", "pyarrow"))
    return pandas.DataFrame(columns), polars.DataFrame(columns), pyarrow.table(columns)


def test_columns_of_tables_are_matched_by_name(robot):
    q = robot.home() + [0.0, 0.01, 0.02]
    expected = robot.inverse_dynamics(np.array([q, q]), np.array([q, q]) * 0.01).efforts
    columns = {name: [value] * 2 for name, value in zip(robot.actuators, q)}
    turned = dict(reversed(columns.items()))
    slow = {f"{name} [m]": np.array(values) * 0.01 for name, values in turned.items()}
    for table, rates in zip(frames(turned), frames(slow)):
        r = robot.inverse_dynamics(table, rates)
        assert np.array_equal(r.efforts, expected)
        assert np.array_equal(robot.kinematics(table).positions, robot.kinematics([q, q]).positions)
        assert np.array_equal(robot.jacobian(table).array, robot.jacobian([q, q]).array)
        assert np.array_equal(robot.mass_matrix(table).array, robot.mass_matrix([q, q]).array)
    single = frames(turned)[0].iloc[0]
    assert np.array_equal(robot.inverse_dynamics(single, q * 0.01).efforts, expected[0])


@pytest.mark.parametrize(
    "names", [("a", "b", "c"), ("leg1.P", "leg2.P"), ("leg1.P", "leg2.P", "leg3.P", "x"), ("leg1.P [mm]", "leg2.P", "leg3.P")]
)
def test_other_columns_are_refused_with_names(robot, names):
    for table in frames({name: [0.5] for name in names}):
        with pytest.raises(stiction.InputError, match=r"columns of `q` are .* not the coordinates leg1.P, leg2.P, leg3.P") as error:
            robot.inverse_dynamics(table)
        assert names[0] in str(error.value)


def test_masked_values_are_refused(robot):
    q = np.ma.masked_array([robot.home()] * 2, mask=[[0, 1, 0], [0, 0, 0]])
    for compute in (robot.inverse_dynamics, robot.kinematics, robot.jacobian, robot.mass_matrix):
        with pytest.raises(stiction.InputError, match="`q` has 1 masked values"):
            compute(q)
    whole = np.ma.masked_array([robot.home()] * 2)
    assert robot.inverse_dynamics(whole).ok


def test_accelerations_by_name(robot):
    motions = robot.kinematics(robot.home(), [0.1, 0.0, 0.0])
    place = robot.bodies.index("platform")
    assert np.array_equal(motions.acceleration["platform"], motions.accelerations[place])


def test_paths_that_cannot_be_used_have_names(robot, tmp_path):
    pytest.importorskip("pyarrow")
    results = robot.inverse(step=0.5)
    (tmp_path / "file").write_text("")
    with pytest.raises(stiction.OutputError, match="cannot write .*file"):
        results.to_parquet(tmp_path / "file" / "x")
    for folder in (3, b"x", os.fsdecode(b"pq\xff"), "a\0b"):
        with pytest.raises(stiction.InputError, match="`folder`"):
            results.to_parquet(folder)
    for log in (3, b"x", "x\udcff"):
        with pytest.raises(stiction.InputError, match="`logs`"):
            robot.identify(log)
    with pytest.raises(stiction.InputError, match="`options` is a int, not a path"):
        robot.identify("a", options=3)


def test_numbers_of_parameters_are_in_si_units_in_sweeps_as_in_with(robot):
    pytest.importorskip("pandas")
    objective = "peak(leg1.P.effort)"
    bare = stiction.sweep(robot, {"base_radius": [0.46, "460 mm"]}, objective)
    named = stiction.sweep(robot, {"base_radius [m]": [0.46, 0.46]}, objective)
    assert bare["status"].tolist() == ["ok", "ok"]
    column = "peak(leg1.P.effort) [N]"
    assert bare[column].tolist() == named[column].tolist()
    efforts = robot.with_(base_radius=0.46).inverse().effort["leg1.P"]
    assert bare[column][0] == abs(efforts).max()
