"""Models: loading, changing, pickling, drawing, exceptions."""

import copy
import pickle

import numpy as np
import pytest
from conftest import ROOT

import stiction

TEXT = (ROOT / "crates/stiction/examples/pendulum.toml").read_text()


def test_every_built_in_model_loads_and_draws():
    for name in stiction.gallery():
        m = stiction.load(name)
        assert m.name == name and len(m.bodies) > 1 and repr(m)
        assert "<svg" in m._repr_html_()


def test_sources():
    path = ROOT / "crates/stiction/examples/pendulum.toml"
    efforts = [stiction.load(source).inverse(step=0.5).efforts for source in (path, str(path), TEXT)]
    np.testing.assert_array_equal(efforts[0], efforts[1])
    np.testing.assert_array_equal(efforts[0], efforts[2])


def test_description(pendulum):
    assert pendulum.actuators == ["pivot"] and pendulum.effort_units == {"pivot": "N m"}
    assert pendulum.joints == ["pivot"] and pendulum.bodies == ["ground", "bob"]
    assert pendulum.friction_interfaces == ["pivot"]
    assert pendulum.default_motion == pendulum.motions[0] and pendulum.default_load == "none"
    assert pendulum.text == TEXT and pendulum.warnings == []


def test_changed_values():
    m = stiction.load('parameters = { mu = 0.1, reach = "2 mm" }\n' + TEXT.replace("mu = 0.1", 'mu = "mu"'))
    assert m.with_(mu=0.12).parameters == {"mu": 0.12, "reach": 0.002}
    assert m.with_(reach=0.5).parameters["reach"] == 0.5
    assert m.parameter_units == {"mu": "", "reach": "m"}
    assert m.parameters["mu"] == 0.1
    doubled = m.with_({"bodies.bob.mass": "4 kg"}).inverse(friction=False, step=0.5).efforts
    assert not np.array_equal(doubled, m.inverse(friction=False, step=0.5).efforts)
    for wrong in ({"mu": "nonsense"}, {"bodies.bobb.mass": "2 kg"}):
        with pytest.raises(stiction.ModelError, match="--set"):
            m.with_(wrong)
    for wrong in ({"a=b": 1}, {"mu": None}, {"mu": np.nan}, {"": 1}, {1: 2}, {"mu": "\ud800"}):
        with pytest.raises(stiction.InputError):
            m.with_(wrong)
    with pytest.raises(stiction.InputError, match="mapping"):
        m.with_(3)


def test_pickles(m, tmp_path):
    changed = m.with_({"platform.mass": "3 kg"})
    for same in (pickle.loads(pickle.dumps(changed)), copy.deepcopy(changed), copy.copy(changed)):
        assert same.title == changed.title
        np.testing.assert_array_equal(same.inverse(step=0.5).efforts, changed.inverse(step=0.5).efforts)
    r = pickle.loads(pickle.dumps(m.inverse(step=0.5)))
    np.testing.assert_array_equal(r.efforts, m.inverse(step=0.5).efforts)
    with pytest.raises(stiction.ModelError) as raised:
        stiction.load("a = 1")
    again = pickle.loads(pickle.dumps(raised.value))
    assert type(again) is stiction.ModelError and str(again) == str(raised.value)


def test_a_pickle_finds_the_files_of_its_model(tmp_path, monkeypatch):
    rows = "\n".join(f"{t / 10},{0.1 * np.sin(t / 10)}" for t in range(20))
    (tmp_path / "motion.csv").write_text("time [s],pivot [rad]\n" + rows + "\n")
    text = TEXT.partition("[motions")[0] + '[motions.recorded]\nfile = "motion.csv"\n'
    (tmp_path / "model.toml").write_text(text)
    monkeypatch.chdir(tmp_path)
    stored = pickle.dumps(stiction.load("model.toml"))
    monkeypatch.chdir("/")
    assert len(pickle.loads(stored).inverse("recorded")) > 10


def test_defective_models_have_the_diagnostics_of_the_command_line():
    with pytest.raises(stiction.ModelError) as raised:
        stiction.load(TEXT.replace("mass =", "masss ="))
    error = raised.value
    assert "error[unknown-key]" in str(error) and "did you mean `mass`" in str(error) and "-->" in str(error)
    (first, *_) = error.diagnostics
    assert first["code"] == "unknown-key"
    assert isinstance(error, (stiction.InputError, ValueError))


def test_unknown_names_are_answered(m):
    r = m.inverse(step=0.5)
    for mapping in (r.effort, r.reaction, r.friction, r.tables, r.joint, r.tables["inverse"]):
        for name in ("leg1.Q", "", None, 3, "\ud800", "x" * 10_000, ("a", "b")):
            with pytest.raises(stiction.UnknownNameError):
                mapping[name]
    with pytest.raises(KeyError, match="did you mean"):
        r.effort["leg1P"]
    with pytest.raises(stiction.InputError, match="gough"):
        stiction.load("gouhg")


def test_a_described_model_is_that_of_the_file():
    b = stiction.Builder("pendulum", gravity=([0, -9.81, 0], "m/s^2"), parameters={"length": "400 mm"})
    b.body("bob", mass=(2.0, "kg"), com=[0, "-length", 0], inertia=(np.full(3, 1e-3), "kg m^2"))
    friction = {"mu": 0.1, "radius": (0.008, "m")}
    b.joint("pivot", "R", "ground", "bob", axis="z", actuated=True, friction=friction)
    b.motion("swing", duration="2 s", pivot="30 deg*sin(2*pi*t)")
    m = b.build()
    reference = stiction.load(TEXT)
    options = {"motion": "pivot = 30 deg*sin(2*pi*t); duration = 2 s", "step": 0.05}
    np.testing.assert_array_equal(m.inverse(**options).efforts, reference.inverse(**options).efforts)
    assert m.with_(length=0.5).parameters == {"length": 0.5}
    assert pickle.loads(pickle.dumps(m)).name == m.name
    with pytest.raises(stiction.InputError, match="already"):
        b.body("bob")
    with pytest.raises(stiction.ModelError, match="masss"):
        stiction.Builder("wrong").body("bob", masss="2 kg").build()


def test_hostile_descriptions():
    deep = []
    for _ in range(50):
        deep = [deep]
    for value in (float("nan"), None, object(), deep, (deep, "m"), "\ud800", {1: 2}, ([None], "m"), 1e999, b"x"):
        with pytest.raises(stiction.InputError):
            stiction.Builder("b").body("bob", mass=value).build()
    for name in ('"', "a.b", "\n", "", "]", "\x7f", "\0", "ö"):
        with pytest.raises(stiction.ModelError):
            stiction.Builder(name).body(name, mass="2 kg", nonsense=name).build()
