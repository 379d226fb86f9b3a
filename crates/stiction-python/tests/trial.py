"""Tries an installed wheel: every example of its documentation, and a simulation."""

import doctest
import importlib.metadata
import sys

import stiction
from stiction import _builder, _errors, _model, _results, _states, _sweep

failed = sum(doctest.testmod(module).failed for module in (stiction, _builder, _errors, _model, _results, _states, _sweep))
licences = {path.name for path in importlib.metadata.files("stiction") or [] if "licenses" in path.parts}
failed += not {"LICENSE-MIT", "LICENSE-APACHE", "LICENSES-THIRD-PARTY.txt"} <= licences
run = stiction.load("gough").forward(until=0.01)
print(f"stiction {stiction.__version__}, Python {sys.version.split()[0]}: {stiction.__file__}")
print(f"{len(stiction.gallery())} models, {len(run)} samples of a simulation, {failed} failures")
sys.exit(failed > 0)
