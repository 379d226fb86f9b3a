"""Results for batches of states."""

from __future__ import annotations

from collections.abc import Mapping
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _native
from ._errors import ComputationError, InputError, _floats
from ._results import Bools, ByName, Floats

_OUTCOMES = _native.outcomes()

Codes = NDArray[np.int8]


class Status(IntEnum):
    """Outcome of a row. ``status.reason`` explains it.

    >>> import stiction
    >>> stiction.Status.CONVERGED
    <Status.CONVERGED: 0>
    >>> stiction.Status(2).reason[:24]
    'the loops do not close: '
    """

    CONVERGED = 0
    INPUT_NOT_FINITE = 1
    LOOPS_OPEN = 2
    MOTION_INCONSISTENT = 3
    SINGULAR = 4
    SPRING_WITHOUT_DIRECTION = 5
    NO_OVERLAP = 6
    FRICTION_NOT_CONVERGED = 7
    FRICTION_LOCKS = 8
    UNBALANCED = 9
    SPRING_TURNED = 10

    @property
    def reason(self) -> str:
        """Explanation of the outcome."""
        return _OUTCOMES[self.value][1]


class _Rows:
    """Results with an outcome for each row."""

    __slots__ = ("status",)

    def __init__(self, status: Codes) -> None:
        #: Outcome of each row, shape (n,) or (1,), codes of :class:`Status`.
        self.status = status

    @property
    def converged(self) -> Bools:
        """True for each row with results, shape (n,), or (1,) for a single state."""
        converged: Bools = self.status == 0
        return converged

    @property
    def ok(self) -> bool:
        """True if every row has results."""
        return not self.status.any()

    def check(self) -> Any:
        """Return these results; raise :class:`ComputationError` if a row has no results."""
        if self.ok:
            return self
        rows = np.flatnonzero(self.status)
        first = int(rows[0])
        status = Status(int(self.status[first]))
        raise ComputationError(
            f"row {first} has no result: {status.reason}",
            "see `status` for the outcome of every row",
            None,
            {"row": first, "status": status.name.lower(), "rows": len(rows), "of": len(self.status)},
        )

    def __repr__(self) -> str:
        failed = int(np.count_nonzero(self.status))
        return f"<{type(self).__name__}: {len(self.status)} rows, {failed} without results>"


class Derivatives:
    """Derivatives of the efforts of :meth:`stiction.Model.inverse_dynamics`, exact to round-off.

    Element ``[..., i, j]`` is the change of the effort of actuator i, N or N m, for a unit change of coordinate
    j, its rate or its acceleration, all others constant. The loops remain closed, and friction changes with the
    reactions.

    Attributes:
        q: with respect to coordinates, shape (n, actuators, k), or (actuators, k) for a single state.
        v: with respect to rates, of the same shape.
        a: with respect to accelerations, of the same shape; the mass matrix if friction is off.
        defined: True for each row with derivatives, shape (n,) or (1,). The others are NaN: at rest with
            friction, efforts jump with the sign of the rate and have no derivatives.
    """

    __slots__ = ("a", "defined", "q", "v")

    def __init__(self, q: Floats, v: Floats, a: Floats, defined: Bools) -> None:
        self.q, self.v, self.a, self.defined = q, v, a, defined

    def __repr__(self) -> str:
        missing = int(np.count_nonzero(~self.defined))
        return f"<Derivatives: {len(self.defined)} rows, {missing} without derivatives>"


class InverseDynamics(_Rows):
    """Efforts for given motions; see :meth:`stiction.Model.inverse_dynamics`.

    Rows whose ``status`` is not 0 are NaN.

    Attributes:
        efforts: forces, N, and torques, N m, shape (n, actuators), or (actuators,) for a single state.
        efforts_frictionless: efforts without friction, in the same shape.
        reactions: force, N, and moment about the joint's origin, N m, world axes,
            shape (n, joints, 6) or (joints, 6); ``None`` unless requested.
        frictions: sliding speed, m/s, normal load, N, friction force, N, dissipated power, W,
            shape (n, interfaces, 4) or (interfaces, 4); ``None`` unless requested.
        motor_torques: torques of the motors, N m, in the order of :attr:`stiction.Model.motors`, shape (n, motors) or
            (motors,); ``None`` unless requested. They include the inertia of the rotor and, in motion with friction,
            the friction of the motor and the losses of the gear.
        motor_speeds: speeds of the motors, rad/s, in the same shape; ``None`` unless requested.
        power_residual: residual of the power balance, W, shape (n,) or ().
        derivatives: derivatives of ``efforts``; ``None`` unless requested.
    """

    __slots__ = (
        "_names",
        "derivatives",
        "efforts",
        "efforts_frictionless",
        "frictions",
        "motor_speeds",
        "motor_torques",
        "power_residual",
        "reactions",
    )

    def __init__(
        self,
        names: _Names,
        raw: tuple[
            Codes,
            Floats,
            Floats,
            Floats | None,
            Floats | None,
            Floats | None,
            Floats | None,
            Floats,
            tuple[Floats, Floats, Floats, Bools] | None,
        ],
    ) -> None:
        self._names = names
        (
            self.status,
            self.efforts,
            self.efforts_frictionless,
            self.reactions,
            self.frictions,
            self.motor_torques,
            self.motor_speeds,
            self.power_residual,
            derivatives,
        ) = raw
        #: Derivatives of the efforts.
        self.derivatives = None if derivatives is None else Derivatives(*derivatives)

    @property
    def effort(self) -> ByName[Floats]:
        """Effort of each actuator by name, N or N m, shape (n,) or ()."""
        return _by_name("actuator", self._names.actuators, self.efforts, 1)

    @property
    def reaction(self) -> ByName[Floats]:
        """Reaction of each joint by name, shape (n, 6) or (6,)."""
        if self.reactions is None:
            raise InputError("these results contain no reactions", "compute them with `reactions=True`", "reactions")
        return _by_name("joint", self._names.joints, self.reactions, 2)

    @property
    def friction(self) -> ByName[Floats]:
        """Speed, load, force and power of each friction interface by name, shape (n, 4) or (4,)."""
        if self.frictions is None:
            raise InputError("these results contain no frictions", "compute them with `frictions=True`", "frictions")
        return _by_name("friction interface", self._names.interfaces, self.frictions, 2)

    @property
    def motor_torque(self) -> ByName[Floats]:
        """Torque of each motor by name, N m, shape (n,) or ()."""
        return self._of_motors(self.motor_torques)

    @property
    def motor_speed(self) -> ByName[Floats]:
        """Speed of each motor by name, rad/s, shape (n,) or ()."""
        return self._of_motors(self.motor_speeds)

    def _of_motors(self, values: Floats | None) -> ByName[Floats]:
        if values is None:
            raise InputError("these results contain no motors", "compute them with `motors=True`", "motors")
        return _by_name("motor", self._names.motors, values, 1)


class BodyMotions(_Rows):
    """Poses and motions of all bodies; see :meth:`stiction.Model.kinematics`.

    Bodies are in the order of ``Model.bodies``, the ground first. Vectors are along world axes. Rows whose
    ``status`` is not 0 are NaN.

    Attributes:
        positions: position of each body's origin, m, shape (n, bodies, 3) or (bodies, 3).
        quaternions: orientation as a unit quaternion in the order w, x, y, z, with w >= 0,
            shape (n, bodies, 4) or (bodies, 4).
        twists: velocity of the body's origin, m/s, and angular velocity, rad/s, shape (n, bodies, 6).
        accelerations: acceleration of the origin, m/s^2, and angular acceleration, rad/s^2,
            shape (n, bodies, 6).
    """

    __slots__ = ("_names", "accelerations", "positions", "quaternions", "twists")

    def __init__(
        self, names: _Names, raw: tuple[Codes, Floats, Floats, Floats, Floats]
    ) -> None:
        self._names = names
        self.status, self.positions, self.quaternions, self.twists, self.accelerations = raw

    @property
    def position(self) -> ByName[Floats]:
        """Position of each body by name, m, shape (n, 3) or (3,)."""
        return _by_name("body", self._names.bodies, self.positions, 2)

    @property
    def quaternion(self) -> ByName[Floats]:
        """Orientation of each body by name, w, x, y, z, shape (n, 4) or (4,)."""
        return _by_name("body", self._names.bodies, self.quaternions, 2)

    @property
    def twist(self) -> ByName[Floats]:
        """Velocity and angular velocity of each body by name, shape (n, 6) or (6,)."""
        return _by_name("body", self._names.bodies, self.twists, 2)

    @property
    def acceleration(self) -> ByName[Floats]:
        """Acceleration and angular acceleration of each body by name, shape (n, 6) or (6,)."""
        return _by_name("body", self._names.bodies, self.accelerations, 2)


class Jacobians(_Rows):
    """Jacobians of all bodies; see :meth:`stiction.Model.jacobian`.

    Attributes:
        array: shape (n, bodies, 6, k) or (bodies, 6, k) with k coordinates: velocity of the body's origin,
            m/s, and angular velocity, rad/s, world axes, for a unit rate of each coordinate.
    """

    __slots__ = ("_names", "array")

    def __init__(self, names: _Names, raw: tuple[Codes, Floats]) -> None:
        self._names = names
        self.status, self.array = raw

    @property
    def body(self) -> ByName[Floats]:
        """Jacobian of each body by name, shape (n, 6, k) or (6, k)."""
        return _by_name("body", self._names.bodies, self.array, 3)


class MassMatrices(_Rows):
    """Mass matrices with respect to the actuators; see :meth:`stiction.Model.mass_matrix`.

    Attributes:
        array: shape (n, k, k) or (k, k), kg, kg m and kg m^2.
    """

    __slots__ = ("array",)

    def __init__(self, raw: tuple[Codes, Floats]) -> None:
        self.status, self.array = raw


class _Names:
    """Names of the actuators, joints, friction interfaces, motors and bodies of a model."""

    __slots__ = ("actuators", "bodies", "interfaces", "joints", "motors")

    def __init__(self, native: _native.Model) -> None:
        self.actuators = [name for name, _ in native.actuators]
        self.joints = native.joints
        self.interfaces = native.friction_interfaces
        self.motors = native.motors
        self.bodies = native.bodies


def _rows(name: str, value: Any, states: _native.States) -> Any:
    """Numbers of a state or of states. The columns of a table, and the labels of a pandas Series, are matched by name."""
    if type(value) is np.ndarray or value is None:
        return value
    if isinstance(value, np.ma.MaskedArray):
        return _floats(name, value)
    if type(value).__module__.split(".")[0] not in ("pandas", "polars", "pyarrow"):
        return value
    labels = getattr(value, "columns", None)
    if type(value).__module__.startswith("pyarrow"):
        labels = getattr(value, "column_names", None)
    elif labels is None:
        labels = getattr(value, "index", None)
        # Numbers as labels count the values; they are no names.
        if labels is None or not all(isinstance(label, str) for label in labels):
            return value
    if labels is None:
        return value
    units = dict(states.coordinates)
    places: dict[str, Any] = {}
    for label in labels:
        text = str(label)
        head, bracket, unit = text.rpartition(" [")
        known = head if bracket and head in units and unit == f"{units[head]}]" else text
        if known not in units or known in places:
            raise _mismatch(name, list(labels), units)
        places[known] = label
    if len(places) != len(units):
        raise _mismatch(name, list(labels), units)
    columns = [_floats(f"{name}[{one!r}]", value[places[one]]) for one in units]
    return np.stack(columns, axis=-1) if columns else np.empty((0, 0))


def _mismatch(name: str, labels: list[Any], units: dict[str, str]) -> InputError:
    found = ", ".join(str(label) for label in labels[:12]) + (", ..." if len(labels) > 12 else "")
    return InputError(
        f"the columns of `{name}` are {found or 'none'}, not the coordinates {', '.join(units)}",
        "name each column after its coordinate, in any order; `to_numpy()` gives the numbers in their order",
        name,
    )


def _by_name(what: str, names: list[str], values: Floats, axes: int) -> ByName[Floats]:
    """Slices of an array by name; the first of its last ``axes`` axes runs over ``names``."""
    moved = np.moveaxis(values, -axes, 0)
    found: Mapping[str, Floats] = dict(zip(names, moved, strict=True))
    return ByName(what, dict(found))
