"""Studies of many designs: results do not depend on the division into pieces or on the process."""

import functools
import os
import pickle
import time
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pandas as pd
import pytest

import stiction

OBJECTIVES = ("peak(left_motor.effort)", "min(distance.actuation)")


@pytest.fixture(scope="module")
def robot():
    return stiction.load("five-bar")


def designs(count, seed=3):
    random = np.random.default_rng(seed)
    return pd.DataFrame(
        {"crank [mm]": random.uniform(190, 240, count), "tool.mass [kg]": random.uniform(0.5, 2.0, count)}
    )


def test_rows_are_those_of_single_runs(robot):
    table = designs(3)
    rows = stiction.sweep(robot, table, OBJECTIVES)
    assert list(rows["status"]) == ["ok"] * 3
    for index, design in table.iterrows():
        crank, mass = float(design["crank [mm]"]), float(design["tool.mass [kg]"])
        own = robot.with_({"crank": f"{crank!r} mm", "tool.mass": f"{mass!r} kg"}).inverse()
        peak = abs(own.effort["left_motor"]).max()
        assert peak == rows.loc[index, "peak(left_motor.effort) [N m]"]


def test_pieces_threads_and_processes_give_the_same_bits(robot):
    table = designs(24)
    row = functools.partial(stiction.sweep, robot, objectives=OBJECTIVES)
    whole = row(table)
    assert row(table, threads=2).equals(whole)
    pieces = [table.iloc[k : k + 5] for k in range(0, 24, 5)]
    assert pd.concat(map(row, pieces)).equals(whole)
    again = pickle.loads(pickle.dumps(row))
    assert again(table).equals(whole)
    with ProcessPoolExecutor(2) as pool:
        assert pd.concat(pool.map(row, pieces)).equals(whole)


def test_failures_are_told_by_row(robot):
    rows = stiction.sweep(robot, {"crank": ["200 mm", "9 m", None, "9 kg"]}, OBJECTIVES[0])
    values = rows["peak(left_motor.effort) [N m]"]
    assert np.isfinite(values).tolist() == [True, False, True, False]
    statuses = rows["status"].tolist()
    assert statuses[1].startswith("no answer: ") and statuses[3].startswith("failed: ")
    # An empty cell keeps the value of the model.
    assert values[2] == abs(robot.inverse().effort["left_motor"]).max()


@pytest.mark.parametrize(
    ("table", "text"),
    [
        ({"crank": [float("nan")]}, "in design 1"),
        ({"crnk": [1.0]}, "did you mean `crank`"),
        ({}, "no columns"),
        ([1.0], "not a table of designs"),
        ({"crank": [0.2, 0.21], "tool.mass": [1.0]}, "has 1 values, but the first has 2"),
        ({"crank": 3}, "cannot be read"),
        ({3: [1.0]}, "not a text"),
        ({"crank [": [1.0]}, ""),
        ({"crank": [object()]}, ""),
    ],
)
def test_tables_that_are_none(robot, table, text):
    with pytest.raises(stiction.InputError) as caught:
        stiction.sweep(robot, table, OBJECTIVES)
    assert text in str(caught.value)


@pytest.mark.parametrize("objectives", ["peek(left_motor.effort)", "peak(left)", "", ["peak"], [], 3])
def test_objectives_that_are_none(robot, objectives):
    with pytest.raises(stiction.InputError):
        stiction.sweep(robot, {"crank": [0.2]}, objectives)


def test_empty_tables(robot):
    rows = stiction.sweep(robot, {"crank": []}, OBJECTIVES)
    assert all(len(column) == 0 for column in rows.values())


def test_pickles_keep_the_remarks_of_an_import(tmp_path):
    file = tmp_path / "robot.xml"
    file.write_text(
        "<mujoco><worldbody><body><joint name='a'/><geom size='0.1'/></body></worldbody>"
        "<contact><exclude body1='x' body2='y'/></contact></mujoco>"
    )
    m = stiction.load(file)
    assert any("<contact>" in note for note in m.notes)
    assert pickle.loads(pickle.dumps(m)).notes == m.notes
    assert m.with_({"gravity": "[0, 0, -9.8]"}).notes == m.notes
    assert stiction.load(str(file), literal=True, package_path=tmp_path).bodies == m.bodies
    with pytest.raises(stiction.InputError, match="package_path"):
        stiction.load(file, package_path=3)


def by_dask(row, table, expected):
    """Rows of a study on two workers of Dask, and their duration without start-up."""
    import dask.dataframe
    from distributed import Client, LocalCluster

    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        pieces = dask.dataframe.from_pandas(table, npartitions=16)
        rows = pieces.map_partitions(row, meta=expected.iloc[:0])
        client.run(lambda: __import__("stiction"))  # Excludes start-up from the duration.
        begun = time.perf_counter()
        return rows.compute(), time.perf_counter() - begun


def by_ray(row, table, expected):
    """Rows of a study on two workers of Ray, and their duration without start-up."""
    import pandas
    import ray

    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
    try:
        remote = ray.remote(lambda piece: row(piece))  # Ray accepts functions only.
        size = -(-len(table) // 16)
        pieces = [table.iloc[k : k + size] for k in range(0, len(table), size)]
        ray.get([remote.remote(piece.iloc[:1]) for piece in pieces[:2]])  # Excludes start-up from the duration.
        begun = time.perf_counter()
        rows = pandas.concat(ray.get([remote.remote(piece) for piece in pieces]))
        return rows, time.perf_counter() - begun
    finally:
        ray.shutdown()


@pytest.mark.skipif("STICTION_CLUSTERS" not in os.environ, reason="`cargo xtask audit clusters` sets STICTION_CLUSTERS")
@pytest.mark.parametrize("engine", [by_dask, by_ray])
def test_clusters_give_the_same_bits_at_the_speed_of_threads(robot, engine):
    table = designs(int(os.environ["STICTION_CLUSTERS"]))
    row = functools.partial(
        stiction.sweep, robot, objectives=OBJECTIVES, motion="left_motor = 2; right_motor = 1; duration = 0"
    )
    begun = time.perf_counter()
    expected = row(table, threads=2)
    threads = time.perf_counter() - begun
    found, workers = engine(row, table, expected)
    assert found.equals(expected)
    print(f"{engine.__name__}: {len(table)} rows: 2 threads {threads:.2f} s, 2 workers {workers:.2f} s")
    assert threads / workers > 0.8
