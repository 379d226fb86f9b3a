"""Invalid input raises an exception of the package, never a panic."""

import itertools

import numpy as np
import pytest
from conftest import ROOT, neighbours
from hostile_values import hostile_values

import stiction

CALLS = ("inverse_dynamics", "kinematics", "jacobian", "mass_matrix")
SHAPES = [(0,), (2,), (4,), (3, 3, 3), (5, 2), (0, 4), (), (1, 1, 3), (3, 0)]


@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize("shape", SHAPES)
def test_wrong_shapes(m, call, shape):
    with pytest.raises(stiction.InputError, match="`q` has the shape"):
        getattr(m, call)(np.zeros(shape))


def test_shapes_that_do_not_fit_together(m):
    q, v, a = neighbours(m, 5)
    for name, wrong in itertools.product(("v", "a"), (v[:4], v[0], v[:, :2], v[:0], np.zeros(()))):
        with pytest.raises(stiction.InputError, match=f"`{name}` has the shape"):
            m.inverse_dynamics(q, **{name: wrong})


@pytest.mark.parametrize(
    "value",
    [
        "text", ["a", "b", "c"], [1j, 0, 0], [None] * 3, object(), {"a": 1}, {1, 2, 3}, b"abc",
        [[1, 2, 3], [1]], np.array(["1", "2", "3"]), np.zeros(3, dtype="M8[s]"), lambda: 0,
        np.zeros(3, dtype=[("x", "f8")]), range,
    ],
)  # fmt: skip
def test_other_types(m, value):
    for call in CALLS:
        with pytest.raises(stiction.InputError, match="`q`"):
            getattr(m, call)(value)
    with pytest.raises(stiction.InputError, match="`v`"):
        m.inverse_dynamics(m.home(), v=value)


def test_unusual_arrays_give_the_same_numbers(m):
    q, v, a = neighbours(m, 8)
    expected = m.inverse_dynamics(q, v, a).check().efforts
    wide = np.zeros((16, 6))
    wide[::2, ::2] = q
    aligned = np.frombuffer(b"\0" + q.tobytes(), dtype=np.uint8)[1:].view(np.float64).reshape(q.shape)
    read_only = q.copy()
    read_only.setflags(write=False)
    same = {
        "strided": wide[::2, ::2],
        "reversed": q[::-1].copy()[::-1],
        "column-major": np.asfortranarray(q),
        "misaligned": aligned,
        "read-only": read_only,
        "big-endian": q.astype(">f8"),
        "list": q.tolist(),
        "masked": np.ma.array(q),
        "transposed": q.T.copy().T,
    }
    for name, other in same.items():
        np.testing.assert_array_equal(m.inverse_dynamics(other, v, a).efforts, expected, err_msg=name)
    single = q.astype(np.float32)
    np.testing.assert_array_equal(
        m.inverse_dynamics(single, v, a).efforts, m.inverse_dynamics(single.astype(float), v, a).efforts
    )
    whole = m.inverse_dynamics(np.zeros((2, 3), dtype=int))
    assert whole.status.shape == (2,)
    np.testing.assert_array_equal(q, neighbours(m, 8)[0])


def test_no_rows(m):
    empty = np.zeros((0, 3))
    r = m.inverse_dynamics(empty, empty, empty, reactions=True, frictions=True, threads=4)
    assert r.efforts.shape == (0, 3) and r.reactions.shape == (0, len(m.joints), 6) and r.ok
    assert m.kinematics(empty).quaternions.shape == (0, len(m.bodies), 4)
    assert m.jacobian(empty).array.shape == (0, len(m.bodies), 6, 3)
    assert m.mass_matrix(empty).array.shape == (0, 3, 3)


def test_extreme_numbers_have_a_status(m):
    extremes = [0.0, -0.0, 1e-320, -1e300, 1.7e308, np.inf, -np.inf, np.nan, 1e15, 3e4]
    rows = np.array(list(itertools.product(extremes, repeat=3)))[::7]
    home = np.tile(m.home(), (len(rows), 1))
    for q, v, a in ((rows, None, None), (home, rows, None), (home, None, rows)):
        r = m.inverse_dynamics(q, v, a, reactions=True, frictions=True)
        assert np.isfinite(r.efforts[r.converged]).all() and np.isnan(r.efforts[~r.converged]).all()
        k = m.kinematics(q, v, a)
        assert np.isfinite(k.accelerations[k.converged]).all()
    assert not m.jacobian(rows).ok and not m.mass_matrix(rows).ok


@pytest.mark.parametrize("value", hostile_values(), ids=lambda value: repr(value)[:30])
def test_options_of_any_type(m, value):
    """Every value for every option gives a result, an exception of the package, or a `TypeError`."""
    home = m.home()
    calls = [lambda: stiction.load(value), lambda: stiction.Model(value), lambda: m.with_(value)]
    calls += [lambda: m.with_(mu=value), lambda: m.with_({"platform.mass": value})]
    for name in ("motion", "load", "friction", "step", "threads", "progress"):
        calls.append(lambda name=name: m.inverse(**{"step": 0.5, name: value}))
    for name in (
        "motion", "load", "start", "at", "rate", "drives", "controller", "prescribe", "hold", "stop",
        "friction", "method", "tolerance", "progress", "step",
    ):  # fmt: skip
        calls.append(lambda name=name: m.forward(**{"until": 0.01, name: value}))
    for name in ("motion", "step", "progress"):
        calls.append(lambda name=name: m.check(**{"step": 0.5, name: value}))
    for name in ("motion", "load", "at"):
        calls.append(lambda name=name: m.breakaway(**{name: value}))
    for name in ("load", "friction", "coordinates", "motion", "at", "threads"):
        calls.append(lambda name=name: m.inverse_dynamics(home, **{name: value}))
    for call in calls:
        try:
            call()
        except stiction.InternalError:
            raise
        except stiction.Error as error:
            assert str(error)
        except TypeError as error:
            # A callable value that is used as the progress function may take other arguments.
            assert callable(value) and "argument" in str(error), error


def test_sources_that_are_no_models(tmp_path):
    not_text = tmp_path / "model.toml"
    not_text.write_bytes(b"\xff\xfe\x00mass")
    for source in (not_text, tmp_path, tmp_path / "missing.toml", "missing.toml", "/dev/null/x", "a\0b.toml"):
        with pytest.raises(stiction.InputError):
            stiction.load(source)
    with pytest.raises(stiction.InputError):
        stiction.load(str(tmp_path / "caf\udce9.toml"))
    with pytest.raises(stiction.InputError, match="decode"):
        stiction.load(b"five-bar")


def test_a_file_with_a_name_that_is_no_text(tmp_path):
    import os

    name = os.fsencode(tmp_path) + b"/\xff.toml"
    try:
        with open(name, "wb") as file:
            file.write((ROOT / "crates/stiction/examples/pendulum.toml").read_bytes())
    except OSError:
        pytest.skip("this file system refuses such names")
    m = stiction.load(os.fsdecode(name))
    assert m.actuators == ["pivot"]


def test_damaged_texts(m):
    text = stiction.load("five-bar").text
    random = np.random.default_rng(7)
    for _ in range(60):
        begin, end = sorted(random.integers(0, len(text), 2))
        damaged = text[:begin] + chr(int(random.integers(1, 0x2FF))) * int(random.integers(0, 5)) + text[end:]
        try:
            stiction.load(damaged + "\n")
        except stiction.InternalError:
            raise
        except stiction.Error as error:
            assert str(error)


def test_large_batches_with_huge_values(m):
    q = np.full((3000, 3), 1e9)
    assert (m.inverse_dynamics(q, threads=2).status == stiction.Status.LOOPS_OPEN).all()
