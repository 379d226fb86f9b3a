"""Actuator efforts, joint reactions and load-dependent joint friction of closed-chain mechanisms.

All numbers are in SI units and radians; texts may carry units (``"30 deg"``, ``"128.48 mm"``).

>>> import stiction
>>> m = stiction.load("zhang2018-regular")
>>> r = m.inverse()
>>> peak = abs(r.effort["leg1.P"]).max()   # N
>>> wider = stiction.load("3rps").with_(base_radius="500 mm")
>>> wider.parameters["base_radius"]
0.5
"""

from . import _native
from ._builder import Builder
from ._errors import (
    ComputationError,
    Error,
    InputError,
    InternalError,
    InterruptedRun,
    ModelError,
    OutputError,
    UnknownNameError,
)
from ._model import ControlState, Model, gallery, load
from ._results import (
    ByName,
    Event,
    ForwardResults,
    InverseResults,
    JointFriction,
    JointMotion,
    Report,
    Results,
    Table,
)
from ._states import BodyMotions, Derivatives, InverseDynamics, Jacobians, MassMatrices, Status
from ._sweep import sweep

__version__: str = _native.__version__

__all__ = [
    "BodyMotions",
    "Builder",
    "ByName",
    "ComputationError",
    "ControlState",
    "Derivatives",
    "Error",
    "Event",
    "ForwardResults",
    "InputError",
    "InternalError",
    "InterruptedRun",
    "InverseDynamics",
    "InverseResults",
    "Jacobians",
    "JointFriction",
    "JointMotion",
    "MassMatrices",
    "Model",
    "ModelError",
    "OutputError",
    "Report",
    "Results",
    "Status",
    "Table",
    "UnknownNameError",
    "__version__",
    "gallery",
    "load",
    "sweep",
]
