"""Models and the command line for the tests."""

import os
import pathlib
import subprocess

import numpy as np
import pytest

import stiction

ROOT = pathlib.Path(__file__).resolve().parents[3]


@pytest.fixture(scope="session")
def m():
    """A 3-RPS robot with friction in all joints."""
    return stiction.load("zhang2018-regular")


@pytest.fixture(scope="session")
def pendulum():
    return stiction.load(ROOT / "crates/stiction/examples/pendulum.toml")


@pytest.fixture(scope="session")
def cli():
    """Function that runs the command line. The variable STICTION names its program; `cargo xtask test` sets it."""
    program = os.environ.get("STICTION")
    if program is None:
        pytest.skip("STICTION does not name the program `stiction`")

    def run(*arguments, folder):
        command = [program, *arguments, "-o", str(folder), "--quiet"]
        subprocess.run(command, check=True, capture_output=True, timeout=120)
        return folder

    return run


def neighbours(m, rows, seed=1):
    """States close to the home position: coordinates, rates, accelerations."""
    random = np.random.default_rng(seed)
    phase = np.linspace(0, 2 * np.pi, rows)[:, None] + np.arange(len(m.home()))
    q = m.home() + 2e-3 * np.sin(phase)
    return q, 0.01 * np.cos(phase), 0.1 * random.standard_normal(q.shape)
