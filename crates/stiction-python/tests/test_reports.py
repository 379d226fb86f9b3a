"""Reports, conversions, relative paths, and values between samples."""

import json
import pickle

import numpy as np
import pytest

import stiction

ARM = """
gravity = [0, 0, -9.81]
[bodies.b]
mass = "1 kg"
com = [0.1, 0, 0]
inertia = [1, 1, 1]
[joints.j]
type = "R"
from = "ground"
to = "b"
axis = "y"
actuated = true
"""


def test_results_draw_their_report(tmp_path):
    r = stiction.load("five-bar").inverse(step=0.1)
    page = r.report(tmp_path / "report.html")
    assert (tmp_path / "report.html").read_text(encoding="utf-8") == page
    assert page.startswith("<!DOCTYPE html>") and "left_motor" in page
    assert [file.name for file in tmp_path.iterdir()] == ["report.html"]
    assert pickle.loads(pickle.dumps(r)).report() == page
    with pytest.raises(stiction.OutputError, match="cannot write"):
        r.report(tmp_path / "report.html" / "x")
    with pytest.raises(stiction.InputError, match="`path` is a int"):
        r.report(3)


def test_simulations_draw_their_report():
    m = stiction.load("five-bar")
    assert "left_motor" in m.forward(until=0.02).report()
    by_function = m.forward(controller=lambda state: 0 * state.q, until=0.02)
    assert len(pickle.loads(pickle.dumps(by_function))) == len(by_function)
    with pytest.raises(stiction.InputError, match="has no report"):
        by_function.report()


def test_joints_between_samples():
    m = stiction.load("five-bar")
    fine, middle, coarse = (m.forward(until=0.1, step=step, friction=False) for step in (0.001, 0.005, 0.01))
    exact = fine.joint["left_motor"]
    errors = []
    for run in (middle, coarse):
        found = run.joint_at(fine.time)["left_motor"]
        errors.append(abs(found.position - exact.position).max())
        assert abs(found.rate - exact.rate).max() < 1e-3
        assert abs(found.acceleration - exact.acceleration).max() < 1.0
    assert errors[0] < errors[1] / 4 and errors[1] < 1e-6
    assert np.array_equal(coarse.joint_at(coarse.time)["left_motor"].position[:-1], coarse.joint["left_motor"].position[:-1])
    assert coarse.joint_at(0.05)["left_motor"].position.shape == ()
    for times in (-0.01, [0.0, 0.2], np.nan):
        with pytest.raises(stiction.InputError, match="`times` are not all from 0 s to 0.1 s"):
            coarse.joint_at(times)


def test_models_are_converted_to_urdf_and_without_a_motion():
    m = stiction.load("five-bar")
    assert "<robot" in m.convert("urdf") and "left_motor" in m.convert("urdf-yaml")
    arm = stiction.load(ARM)
    for format in ("json", "toml", "mjcf", "urdf", "sdf"):
        assert arm.convert(format)
    json.loads(arm.convert("json"))


def test_relative_paths_do_not_depend_on_the_current_folder(tmp_path, monkeypatch):
    robot, other = tmp_path / "robot", tmp_path / "other"
    robot.mkdir(), other.mkdir()
    motion = '[motions.rec]\nfile = "rec.csv"\n[default]\nmotion = "rec"\n'
    (robot / "m.toml").write_text(ARM + motion)
    rows = "".join(f"{0.01 * k},{0.1 * np.sin(0.1 * k)}\n" for k in range(101))
    (robot / "rec.csv").write_text("time [s],j [rad]\n" + rows)
    for folder, name in ((tmp_path, "robot/m.toml"), (robot, "./m.toml")):
        monkeypatch.chdir(folder)
        m = stiction.load(name)
        monkeypatch.chdir(other)
        again = pickle.loads(pickle.dumps(m))
        for one in (m, again):
            assert len(one.with_({"b.mass": "2 kg"}).inverse()) == 101
            table = stiction.sweep(one, {"b.mass [kg]": [1.0, 2.0]}, "peak(j.effort)")
            assert list(table["status"]) == ["ok", "ok"]


def test_files_of_options_are_those_of_the_folder_of_the_call(tmp_path, monkeypatch):
    here, other = tmp_path / "here", tmp_path / "other"
    here.mkdir(), other.mkdir()
    for folder, amplitude in ((here, 0.1), (other, 0.3)):
        rows = "".join(f"{0.01 * k},{amplitude * np.cos(0.1 * k)}\n" for k in range(101))
        (folder / "rec.csv").write_text("time [s],j [rad]\n" + rows)
    m = stiction.load(ARM)
    monkeypatch.chdir(here)
    runs = [m.inverse("rec.csv"), m.forward(motion="rec.csv", until=0.1)]
    pages = [run.report() for run in runs]
    home = m.home(motion="rec.csv")
    monkeypatch.chdir(other)
    for run, page in zip(runs, pages, strict=True):
        assert run.report() == page
        assert pickle.loads(pickle.dumps(run)).report() == page
    # A new call reads the file of the present folder.
    assert abs(home[0] - 0.1) < 1e-12 and abs(m.home(motion="rec.csv")[0] - 0.3) < 1e-12
