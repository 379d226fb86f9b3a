"""Tries an installed wheel: every example of its documentation, and a simulation."""

import doctest
import sys

import stiction
from stiction import _builder, _errors, _model, _results, _states

failed = sum(doctest.testmod(module).failed for module in (stiction, _builder, _errors, _model, _results, _states))
run = stiction.load("gough").forward(until=0.01)
print(f"stiction {stiction.__version__}, Python {sys.version.split()[0]}: {stiction.__file__}")
print(f"{len(stiction.gallery())} models, {len(run)} samples of a simulation, {failed} failures")
sys.exit(failed > 0)
