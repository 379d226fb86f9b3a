"""Types, stubs and documentation of the package."""

import importlib.util
import os
import pathlib
import subprocess
import sys

import pytest
from conftest import ROOT

import stiction

PYPROJECT = ROOT / "crates/stiction-python/pyproject.toml"
PACKAGE = pathlib.Path(stiction.__file__).parent


def run(*arguments, folder):
    if importlib.util.find_spec("mypy") is None:
        pytest.skip("the package `mypy` is not installed")
    environment = {**os.environ, "MYPYPATH": str(PACKAGE.parent), "PYTHONPATH": str(PACKAGE.parent)}
    done = subprocess.run(
        [sys.executable, "-m", *arguments], capture_output=True, text=True, cwd=folder, env=environment
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_types(tmp_path):
    run("mypy", "--config-file", str(PYPROJECT), "-p", "stiction", "--cache-dir", str(tmp_path), folder=tmp_path)


def test_stubs(tmp_path):
    allowed = pathlib.Path(__file__).with_name("stubtest-allowlist.txt")
    run("mypy.stubtest", "stiction", "--mypy-config-file", str(PYPROJECT), "--allowlist", str(allowed), folder=tmp_path)


def test_examples_in_documentation():
    import doctest

    from stiction import _builder, _errors, _model, _results, _states

    for module in (stiction, _builder, _errors, _model, _results, _states):
        failed, _ = doctest.testmod(module)
        assert failed == 0


def test_everything_public_has_documentation():
    for name in stiction.__all__:
        thing = getattr(stiction, name)
        assert name == "__version__" or thing.__doc__, name
        if isinstance(thing, type):
            for member, value in vars(thing).items():
                if not member.startswith("_") and (callable(value) or isinstance(value, property)):
                    assert value.__doc__, f"{name}.{member}"
