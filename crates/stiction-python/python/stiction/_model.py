"""A robot: a mechanism with its named motions and loads."""

from __future__ import annotations

import html
import json
import os
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from . import _native
from ._errors import Error, InputError, _count, _floats, _number, _items, _path, _text, _texts
from ._results import (
    Floats,
    ForwardResults,
    InverseResults,
    Report,
    _unknown,
)
from ._states import BodyMotions, InverseDynamics, Jacobians, MassMatrices, _Names, _rows

Progress = Callable[[int, int], object]


class ControlState(NamedTuple):
    """State that a control law or a stop condition receives, arrays in the order of the actuators."""

    time: float
    """s"""
    q: Floats
    """Positions, m or rad, shape (actuators,); angles count full turns."""
    v: Floats
    """Rates, m/s or rad/s."""
    reference_q: Floats
    """Positions of the reference motion; empty without a motion and in a stop condition."""
    reference_v: Floats
    """Rates of the reference motion."""
    reference_a: Floats
    """Accelerations of the reference motion, m/s^2 or rad/s^2."""


ControlLaw = Callable[[ControlState], ArrayLike | Mapping[str, float]]
StopCondition = Callable[[ControlState], float]

#: Largest number of compiled robots that a model stores.
_MOST_STATES = 16


def gallery() -> list[str]:
    """Names of the built-in models.

    >>> import stiction
    >>> "gough" in stiction.gallery()
    True
    """
    return _native.gallery()


def load(
    source: str | os.PathLike[str],
    *,
    literal: bool = False,
    package_path: str | os.PathLike[str] | Iterable[str | os.PathLike[str]] = (),
) -> Model:
    """Read a model: a file, a built-in model or the text of a model.

    A text of several lines or with an equals sign is the text of a model; a name with a folder or an extension, or of
    an existing file, is a file; anything else is the name of a built-in model. A :class:`pathlib.Path` is always a
    file. Files of other programs, URDF, MJCF and SDF, are converted; :attr:`Model.notes` lists the differences.

    Args:
        source: file, name or text.
        literal: keep every joint of a file of another program, instead of recognising hinges and balls. With
            this argument or the next one, ``source`` is a file.
        package_path: folder or folders in which packages and models are searched (``package://``).

    Raises:
        ModelError: the model is defective; the error lists all defects, each with its place.
        InputError: the file cannot be read, or there is no such built-in model.

    >>> import stiction
    >>> stiction.load("five-bar").actuators
    ['left_motor', 'right_motor']
    """
    folders: Iterable[str | os.PathLike[str]]
    folders = [package_path] if isinstance(package_path, (str, os.PathLike)) else package_path
    try:
        packages = [os.fspath(path) for path in folders]
    except Exception as error:
        raise InputError(f"`package_path` is not a path: {error}") from error
    if isinstance(source, os.PathLike) or ((literal or packages) and isinstance(source, str)):
        try:
            path = os.fspath(source)
        except Exception as error:
            raise InputError(f"`source` is not a path: {error}") from error
        return _read(lambda: _native.Model.file(path, bool(literal), packages))
    if isinstance(source, (bytes, bytearray)):
        raise InputError("`source` is bytes, not a text", "decode it: `source.decode()`")
    if isinstance(source, str) and "\n" not in source and not _is_text(source):
        # `os.listdir` may return file names that are not valid text.
        return _read(lambda: _native.Model.file(source))
    text = _text("source", source)
    return _read(lambda: _native.Model.find(text))


def _is_text(text: str) -> bool:
    try:
        text.encode()
    except UnicodeEncodeError:
        return False
    return True


def _read(make: Callable[[], _native.Model]) -> Model:
    try:
        return Model(make())
    except (UnicodeError, TypeError) as error:
        raise InputError(f"`source` is not a path: {error}") from error


class Model:
    """A robot, created by :func:`stiction.load`. It is immutable.

    **States.** ``q`` is a row of independent coordinates, m and rad: those of the actuators in the order of
    :attr:`actuators`, unless ``coordinates`` names others. Columns of a table of pandas, polars or pyarrow are matched
    by their names, in any order. Angles of joints are counted as in the model file.
    The home position, :meth:`home`, is the position at the first instant of the default motion, or at the time
    ``at`` of another ``motion``. It is the initial guess for closing the loops, and determines the assembly mode.
    Each row is reached from the previous row along a straight line in the coordinates, in short steps, so all rows
    are in the assembly mode of the home position. Each piece of 256 rows begins at the home position, so results do
    not depend on the number of threads. The mode is that nearest to the ``home`` of bodies and the ``start`` of joints in
    the model; :meth:`with_` changes them to select another one, and ``check()["assembly"]`` shows the result.

    >>> import stiction
    >>> m = stiction.load("3rps")
    >>> m
    <stiction.Model 3rps: 3 actuators, 9 joints, 8 bodies>
    """

    __slots__ = ("_names", "_native", "_states")

    def __init__(self, native: _native.Model) -> None:
        if not isinstance(native, _native.Model):
            raise InputError("a Model cannot be created directly", "call `stiction.load`")
        self._native = native
        self._names = _Names(native)
        self._states: dict[tuple[object, ...], _native.States] = {}

    # Description

    @property
    def name(self) -> str:
        """Name of the model."""
        return self._native.name

    @property
    def title(self) -> str:
        """Title in one line; may be empty."""
        return self._native.title

    @property
    def warnings(self) -> list[str]:
        """Warnings about the model, each with its place.

        Those that begin with `warning[import]` state how results differ from those of the
        imported file; the others do not affect results.
        """
        return self._native.warnings

    @property
    def notes(self) -> list[str]:
        """Remarks on the conversion of a URDF, MJCF or SDF file: the differences from the file, with its lines."""
        return self._native.notes

    @property
    def actuators(self) -> list[str]:
        """Names of the actuators, in the order of efforts and of ``q``."""
        return list(self._names.actuators)

    @property
    def effort_units(self) -> dict[str, str]:
        """Unit of each actuator's effort, ``N`` or ``N m``."""
        return dict(self._native.actuators)

    @property
    def joints(self) -> list[str]:
        """Names of the joints, in the order of reactions."""
        return list(self._names.joints)

    @property
    def bodies(self) -> list[str]:
        """Names of the bodies; the first is the ground."""
        return list(self._names.bodies)

    @property
    def friction_interfaces(self) -> list[str]:
        """Names of the friction interfaces of the joints."""
        return list(self._names.interfaces)

    @property
    def motors(self) -> list[str]:
        """Names of the motors, one for each drive train, in the order of the torques of motors."""
        return list(self._names.motors)

    @property
    def motions(self) -> list[str]:
        """Names of the motions of the model."""
        return self._native.motions

    @property
    def loads(self) -> list[str]:
        """Names of the loads of the model."""
        return self._native.loads

    @property
    def default_motion(self) -> str | None:
        """Name of the default motion."""
        return self._native.defaults[0]

    @property
    def default_load(self) -> str:
        """Name of the default load, or ``none``."""
        return self._native.defaults[1]

    @property
    def parameters(self) -> dict[str, float]:
        """Parameters of the model file with their values in SI units and radians.

        >>> import stiction
        >>> stiction.load("3rps").parameters["base_radius"]
        0.45
        """
        return {name: value for name, value, _ in self._native.parameters}

    @property
    def parameter_units(self) -> dict[str, str]:
        """SI unit of each parameter; empty for a plain number."""
        return {name: unit for name, _, unit in self._native.parameters}

    @property
    def text(self) -> str:
        """Text of the model file, without the changes of :meth:`with_`."""
        return self._native.parts()[1]

    def with_(self, changes: Mapping[str, object] | None = None, /, **parameters: object) -> Model:
        """Return the robot with values of its model changed, as ``--set`` of the command line does.

        A name is the name of a parameter or, in ``changes``, also the path of a key such as
        ``"bodies.platform.mass"``. A value is a text with units, or a number: in the SI unit or radians for a
        parameter, without a unit for a key.

        >>> import stiction
        >>> m = stiction.load("3rps").with_({"platform.mass": "0.7 kg"}, base_radius=0.5)
        >>> m.parameters["base_radius"]
        0.5
        """
        if changes is not None and not isinstance(changes, Mapping):
            raise InputError(
                f"`changes` is a {type(changes).__name__}, not a mapping",
                'give for example {"bodies.platform.mass": "2 kg"}',
            )
        every = {**(changes or {}), **parameters}
        lines = []
        units = self.parameter_units
        for name, value in every.items():
            if not _text("changes", name).strip() or "=" in name or "\n" in name:
                raise InputError(
                    f"`{name}` is not the name of a parameter or key", "give a name such as `bodies.platform.mass`"
                )
            text = _value(name, value)
            is_number = not isinstance(value, (str, bool, np.bool_, list, tuple, np.ndarray))
            lines.append(f"{name} = {text} {units.get(name, '') if is_number else ''}".rstrip())
        return Model(self._native.changed(lines))

    def __reduce__(self) -> Any:
        return _again, (self._native.parts(),)

    def __repr__(self) -> str:
        names = self._names
        return (
            f"<stiction.Model {self.name}: {len(names.actuators)} actuators, "
            f"{len(names.joints)} joints, {len(names.bodies)} bodies>"
        )

    def drawing(self) -> str:
        """Draw the robot as SVG, in light or dark colours according to the reader's preference.

        >>> import stiction
        >>> stiction.load("five-bar").drawing().startswith("<svg")
        True
        """
        return self._native.drawing()

    def convert(self, to: str) -> str:
        """Convert the robot at its home position to another format: ``"mjcf"`` (MuJoCo), ``"urdf"``, ``"sdf"``,
        ``"json"`` (plain numbers), ``"toml"`` (a model file without formulas).

        A URDF file cannot contain loop closures and motors: they are in a YAML file of the same name beside it, whose
        text is ``convert("urdf-yaml")``; it is empty if the robot needs none.

        >>> import stiction
        >>> "<mujoco" in stiction.load("3rps").convert("mjcf")
        True
        """
        if to == "urdf-yaml":
            return self._native.converted("urdf")[1] or ""
        return self._native.converted(_text("to", to))[0]

    def _repr_html_(self) -> str:
        heading = f"<b>{html.escape(self.name)}</b> {html.escape(self.title)}"
        try:
            picture = self.drawing()
        except Error as error:
            picture = f"<pre>no drawing: {html.escape(str(error))}</pre>"
        try:
            units = self.coordinates()
            values = zip(units.items(), self.home(), strict=True)
            at = ", ".join(f"{html.escape(name)} = {value:.4g} {unit}" for (name, unit), value in values)
            home = f"<div>home position and assembly mode: {at}</div>" if at else ""
        except Error:
            # The actuators do not determine the position.
            home = ""
        return f'<div style="max-width:40em">{heading}{picture}{home}</div>'

    # Runs

    def inverse(
        self,
        motion: str | None = None,
        *,
        load: str | None = None,
        friction: bool | str | None = None,
        step: float | None = None,
        threads: int | None = None,
        friction_margin: bool = False,
        progress: Progress | None = None,
    ) -> InverseResults:
        """Compute inverse dynamics along a motion: efforts, reactions and friction by name.

        Args:
            motion: name of a motion of the model, name of a file (CSV or TOML), or assignments such as
                ``"platform.x = 5 mm*sin(2*pi*t); duration = 2 s"``. Default: that of the model.
            load: name of a load of the model, or assignments such as ``"platform.fz = -100 N"``.
            friction: ``True`` or ``"on"``, ``"one-pass"``, ``False`` or ``"off"``. Default: that of the model.
            step: time between samples, s.
            threads: number of threads; all cores by default. Results do not depend on it.
            friction_margin: compute the friction margin to jamming, in ``summary``.
            progress: called at intervals with the amount of work done and the total amount.

        Raises:
            InputError: an option cannot be used.
            ComputationError: the motion cannot be followed, or there are no finite efforts.

        >>> import stiction
        >>> r = stiction.load("five-bar").inverse(friction="off", step=0.1)
        >>> bool((r.effort["left_motor"] == r.effort_frictionless["left_motor"]).all())
        True
        """
        options: dict[str, Any] = {
            "motion": _optional_text("motion", motion),
            "load": _optional_text("load", load),
            "friction": _friction(friction),
            "step": None if step is None else _number("step", step),
            "threads": None if threads is None else _count("threads", threads),
            "friction_margin": bool(friction_margin),
        }
        draw = _Draw(self, "inverse_report", (), options)
        raw = self._native.inverse(**options, progress=_progress(progress))
        return InverseResults(self.name, raw, json.loads(raw[1]), draw)

    def forward(
        self,
        *,
        until: float | None = None,
        step: float | None = None,
        motion: str | None = None,
        load: str | None = None,
        start: str | None = None,
        at: Mapping[str, float] | None = None,
        rate: Mapping[str, float] | None = None,
        drives: str | Mapping[str, float | str] | None = None,
        controller: str | ControlLaw | None = None,
        period: float = 1e-3,
        prescribe: str | Iterable[str] = (),
        hold: str | Iterable[str] = (),
        stop: str | StopCondition | Iterable[str | StopCondition] = (),
        friction: bool | None = None,
        method: str | None = None,
        tolerance: float | None = None,
        progress: Progress | None = None,
    ) -> ForwardResults:
        """Simulate the motion under efforts, controllers, loads and locks, with joints that stick and slip.

        Without options the robot follows its default motion under a computed-torque controller that does not
        know the friction. Ctrl-C stops a simulation.

        Args:
            until: end time, s.
            step: time between samples, s; the integration steps do not depend on it.
            motion: motion that a controller follows, and whose first instant is the start.
            load: name of a load, or assignments.
            start: ``"motion"``, ``"rest"``, or assignments such as ``"A = 60 deg; d(B) = 2 rad/s"``.
            at: coordinates at the start, m or rad; their rates are zero unless given in ``rate``.
            rate: rates at the start, m/s or rad/s.
            drives: efforts by actuator, N or N m or texts with units, which may be formulas over measured
                coordinates such as ``"-200 N m/rad*A"``; or a text: assignments, the name of a file,
                ``"inverse"`` or ``"none"``.
            controller: ``"pd"``, ``"pid"``, ``"computed-torque"``, ``"computed-torque+friction"``, the name of
                a TOML file, assignments, or ``"none"``; or a function of a :class:`ControlState` that returns the
                efforts of all actuators, N or N m, as an array in their order or by name. They are added to
                ``drives`` and held until the next call. An exception of the function stops the simulation.
            period: time between calls of a controller function, s.
            prescribe: actuators that follow the motion exactly.
            hold: joints that are locked at their start positions.
            stop: conditions that end the simulation, such as ``"platform.z < 100 mm"``; or functions of a
                :class:`ControlState`, which end it when their value becomes negative. The instant is located to
                the tolerance; it is the last sample and an event. A function is called at trial states of
                integration steps, so it must depend on its argument only.
            friction: switches joint friction on or off. Default: that of the model.
            method: ``"automatic"``, ``"event-driven"`` or ``"time-stepping"``.
            tolerance: relative error of an integration step, 1e-14 to 1e-2.
            progress: called at intervals with the number of samples done and the number of all samples.

        Raises:
            InputError: options contradict each other.
            ComputationError: the robot cannot start or continue; ``error.result`` contains the earlier samples.

        >>> import stiction
        >>> m = stiction.load("five-bar")
        >>> r = m.forward(drives={"left_motor": "1 N m", "right_motor": 0.5}, until=0.05)
        >>> float(r.effort["right_motor"][-1])
        0.5
        >>> r = m.forward(controller=lambda state: 20 * (state.reference_q - state.q) - 0.5 * state.v, until=0.05)
        >>> r.effort["left_motor"].shape
        (11,)
        >>> start = float(m.home()[0])
        >>> r = m.forward(drives={"left_motor": 1.0}, start="rest", stop=lambda state: start + 0.01 - state.q[0])
        >>> r.events[-1].event
        'stop'
        """
        calls: list[tuple[str, str, float]] = []
        for name, text in (("motion", motion), ("load", load)):
            if text is not None:
                calls.append((name, _text(name, text), 0.0))
        if friction is not None:
            if not isinstance(friction, (bool, np.bool_)):
                raise InputError(f"`friction` is {friction!r:.60}, not a bool", "give True or False")
            calls.append(("friction", "on" if friction else "off", 0.0))
        for name, texts in (("hold", hold), ("prescribe", prescribe)):
            calls.extend((name, text, 0.0) for text in _texts(name, texts))
        if drives is not None:
            calls.append(("drives", self._drives(drives), 0.0))
        law = None
        if callable(controller):
            law = (_number("period", period), _law(controller, self._names.actuators))
            controller = None
        for name, text in (("controller", controller), ("start", start), ("method", method)):
            if text is not None:
                calls.append((name, _text(name, text), 0.0))
        for option, values in (("at", at), ("rate", rate)):
            if values is not None and not isinstance(values, Mapping):
                raise InputError(
                    f"`{option}` is a {type(values).__name__}, not a mapping",
                    f'give for example {option}={{"{next(iter(self._names.actuators), "A")}": 0.1}}',
                )
            for key, value in (values or {}).items():
                calls.append((option, _text(option, key), _number(f"{option}[{key!r}]", value)))
        conditions: list[str | StopCondition] = (
            [stop] if isinstance(stop, str) or callable(stop) else list(_items("stop", stop))
        )
        functions = [condition for condition in conditions if callable(condition)]
        texts = [condition for condition in conditions if not callable(condition)]
        calls.extend(("stop", text, 0.0) for text in _texts("stop", texts))
        stops = [(_function_name(function), _stop(function)) for function in functions]
        options: dict[str, Any] = {
            "until": None if until is None else _number("until", until),
            "step": None if step is None else _number("step", step),
            "tolerance": None if tolerance is None else _number("tolerance", tolerance),
        }
        draw = None if law is not None or stops else _Draw(self, "forward_report", (calls,), options)
        raw, events, ended = self._native.forward(calls, **options, law=law, stops=stops, progress=_progress(progress))
        results = ForwardResults(self.name, raw, json.loads(raw[1]), events, ended, draw)
        if ended is not None:
            ended.result = results
            raise ended
        return results

    def _drives(self, drives: str | Mapping[str, float | str]) -> str:
        """Convert efforts to assignments."""
        if isinstance(drives, str):
            return _text("drives", drives)
        if not isinstance(drives, Mapping):
            raise InputError(
                f"`drives` is a {type(drives).__name__}", "give a mapping from actuators to efforts"
            )
        units = self.effort_units
        lines = []
        for name, value in drives.items():
            key = _text("drives", name)
            if isinstance(value, str):
                lines.append(f"{key} = {_text(f'drives[{key!r}]', value)}")
            else:
                number = _number(f"drives[{key!r}]", value)
                lines.append(f"{key} = {number!r} {units.get(key, 'N')}")
        return "; ".join(lines) if lines else "none"

    def check(
        self,
        motion: str | None = None,
        *,
        step: float | None = None,
        progress: Progress | None = None,
    ) -> Report:
        """Determine mobility, redundant constraints and singular positions along a motion.

        >>> import stiction
        >>> print(stiction.load("five-bar").check()["mobility"]["instantaneous"])
        2
        """
        data, text = self._native.check(
            _optional_text("motion", motion),
            None if step is None else _number("step", step),
            _progress(progress),
        )
        return Report(json.loads(data), text)

    def identify(
        self,
        *logs: str | os.PathLike[str],
        options: str | os.PathLike[str] | None = None,
        filter: float | None = None,
    ) -> Report:
        """Identify inertia and friction from logs of positions and efforts, as ``stiction identify`` does.

        ``options`` is a TOML file that describes the logs, ``filter`` the cut-off frequency in Hz. The report has the
        keys of ``identify.json``, and ``model`` with the text of the identified model, or ``None`` if the fit failed.

        >>> import stiction
        >>> stiction.load("five-bar").identify("no-such-log.csv")  # doctest: +ELLIPSIS
        Traceback (most recent call last):
        ...
        stiction._errors.InputError: cannot read no-such-log.csv: ...
        """
        data, text, model = self._native.identify(
            [_path("logs", log) for log in logs],
            None if options is None else _path("options", options),
            None if filter is None else _number("filter", filter),
        )
        return Report({**json.loads(data), "model": model}, text)

    def breakaway(
        self, motion: str | None = None, *, load: str | None = None, at: float | None = None
    ) -> Report:
        """Compute static friction of the robot at rest at one time of a motion: the efforts at which motion begins.

        >>> import stiction
        >>> report = stiction.load("3rps").breakaway()
        >>> len(report) > 0
        True
        """
        data, text = self._native.breakaway(
            _optional_text("motion", motion),
            _optional_text("load", load),
            None if at is None else _number("at", at),
        )
        return Report(json.loads(data), text)

    # Batches of states

    def _compiled(
        self,
        coordinates: str | Iterable[str] | None,
        motion: str | None,
        load: str | None,
        friction: bool | str | None,
        at: float | None,
    ) -> _native.States:
        if coordinates is not None:
            coordinates = tuple(_texts("coordinates", coordinates))
        # A motion or load may be the name of a file in the working folder.
        folder = None if motion is None and load is None else _working_folder()
        key = (coordinates, motion, load, friction, at, folder)
        try:
            return self._states[key]
        except (KeyError, TypeError):
            pass
        made = self._native.states(
            coordinates=None if coordinates is None else list(coordinates),
            motion=_optional_text("motion", motion),
            load=_optional_text("load", load),
            friction=_friction(friction),
            at=None if at is None else _number("at", at),
        )
        if len(self._states) >= _MOST_STATES:
            self._states.clear()
        self._states[key] = made
        return made

    def coordinates(self, coordinates: str | Iterable[str] | None = None) -> dict[str, str]:
        """Names and units (``m``, ``rad``) of the columns of ``q``, in their order.

        >>> import stiction
        >>> stiction.load("five-bar").coordinates()
        {'left_motor': 'rad', 'right_motor': 'rad'}
        """
        return dict(self._compiled(coordinates, None, None, None, None).coordinates)

    def home(
        self,
        coordinates: str | Iterable[str] | None = None,
        *,
        motion: str | None = None,
        at: float | None = None,
    ) -> Floats:
        """Coordinates of the home position, m and rad, shape (k,); it determines the assembly mode of all states.

        The home position is the first position of the motion, whose loops are closed from the initial guesses of the
        model. Its coordinates alone may belong to several assembly modes: another motion that begins with these
        coordinates begins in the mode that is nearest to the initial guesses, which may be another one.
        :meth:`kinematics` returns the positions of all bodies at home.
        """
        return self._compiled(coordinates, motion, None, None, at).home

    def inverse_dynamics(
        self,
        q: ArrayLike,
        v: ArrayLike | None = None,
        a: ArrayLike | None = None,
        *,
        load: str | None = None,
        friction: bool | str | None = None,
        coordinates: str | Iterable[str] | None = None,
        motion: str | None = None,
        at: float | None = None,
        reactions: bool = False,
        frictions: bool = False,
        motors: bool = False,
        derivatives: bool = False,
        threads: int | None = 1,
    ) -> InverseDynamics:
        """Compute efforts for given positions, rates and accelerations of the coordinates.

        As in :meth:`inverse`, an effort is that at the output of a drive train: it contains neither the reflected
        inertia of the rotor (``rotor_inertia``, ``armature`` of MJCF) nor the losses of motor and gear. The torques of
        the motors contain both; ``motors=True`` computes them.

        Args:
            q: coordinates, m and rad, shape (n, k) for n states or (k,) for one; see the class.
            v: rates, m/s and rad/s, of the shape of ``q``; zero by default. Joints whose surfaces slide
                slower than 1e-9 m/s are at rest and carry no friction.
            a: accelerations, m/s^2 and rad/s^2, of the shape of ``q``; zero by default.
            load: name of a load of the model, or assignments; its value at the time of the home position.
                Default: that of the model. Payloads are fixed to their bodies.
            friction: ``True``, ``False`` or ``"one-pass"``. Default: that of the model.
            coordinates: names of other coordinates, such as ``["platform.x", "platform.y"]``: joint coordinates,
                and coordinates that the motion prescribes.
            motion: motion whose instant ``at``, s, is the home position.
            reactions, frictions, motors: also compute reactions of joints, frictions of friction interfaces, torques
                and speeds of motors. A motor whose output is slower than 1e-9 m/s or rad/s is at rest: its
                torque contains no friction and no losses of the gear.
            derivatives: also compute derivatives of the efforts with respect to ``q``, ``v`` and ``a``, see
                :class:`Derivatives`. Not for ``friction="one-pass"``, nor for mechanisms with gearings of joints.
            threads: number of threads; ``None`` for all cores.

        Raises:
            InputError: an argument has a wrong shape or type. Rows without a result raise no exception: see ``status``.

        >>> import numpy as np, stiction
        >>> m = stiction.load("3rps")
        >>> q = m.home() + np.linspace(0, 1e-3, 100)[:, None]
        >>> r = m.inverse_dynamics(q, v=np.full_like(q, 0.01)).check()
        >>> r.efforts.shape, r.effort["leg1.P"].shape
        ((100, 3), (100,))
        >>> r = m.inverse_dynamics(m.home(), v=[0.01, 0.02, 0.03], derivatives=True)
        >>> r.derivatives.q.shape, r.derivatives.v.shape
        ((3, 3), (3, 3))
        """
        states = self._compiled(coordinates, motion, load, friction, at)
        if threads is not None and not (type(threads) is int and threads == 1):
            threads = _count("threads", threads)
        outputs = bool(reactions), bool(frictions), bool(derivatives), bool(motors)
        rows = (_rows("q", q, states), _rows("v", v, states), _rows("a", a, states))
        raw = states.inverse_dynamics(*rows, threads, *outputs)
        return InverseDynamics(self._names, raw)

    def kinematics(
        self,
        q: ArrayLike,
        v: ArrayLike | None = None,
        a: ArrayLike | None = None,
        *,
        coordinates: str | Iterable[str] | None = None,
        motion: str | None = None,
        at: float | None = None,
        threads: int | None = 1,
    ) -> BodyMotions:
        """Compute poses, velocities and accelerations of all bodies; quaternions are in the order w, x, y, z.

        The arguments are those of :meth:`inverse_dynamics`.

        >>> import stiction
        >>> m = stiction.load("3rps")
        >>> motions = m.kinematics(m.home())
        >>> motions.position["platform"].shape, motions.quaternion["platform"].shape
        ((3,), (4,))
        """
        states = self._compiled(coordinates, motion, None, None, at)
        threads = None if threads is None else _count("threads", threads)
        rows = (_rows("q", q, states), _rows("v", v, states), _rows("a", a, states))
        return BodyMotions(self._names, states.kinematics(*rows, threads))

    def jacobian(
        self,
        q: ArrayLike,
        *,
        coordinates: str | Iterable[str] | None = None,
        motion: str | None = None,
        at: float | None = None,
        threads: int | None = 1,
    ) -> Jacobians:
        """Compute Jacobians of all bodies: velocities of their origins and angular velocities for unit rates of ``q``.

        >>> import stiction
        >>> m = stiction.load("3rps")
        >>> m.jacobian(m.home()).body["platform"].shape
        (6, 3)
        """
        states = self._compiled(coordinates, motion, None, None, at)
        threads = None if threads is None else _count("threads", threads)
        return Jacobians(self._names, states.jacobian(_rows("q", q, states), threads))

    def mass_matrix(
        self,
        q: ArrayLike,
        *,
        load: str | None = None,
        motion: str | None = None,
        at: float | None = None,
        threads: int | None = 1,
    ) -> MassMatrices:
        """Compute mass matrices with respect to the actuators. They include payloads of the load, but not the
        reflected inertia of rotors.

        >>> import numpy as np, stiction
        >>> m = stiction.load("3rps")
        >>> M = m.mass_matrix(m.home()).array
        >>> bool(np.all(np.linalg.eigvalsh(M) > 0))
        True
        """
        states = self._compiled(None, motion, load, None, at)
        threads = None if threads is None else _count("threads", threads)
        return MassMatrices(states.mass_matrix(_rows("q", q, states), threads))


class _Draw:
    """Draws the report of a run, which it computes again. It can be pickled.

    Files that the options name are those of the working folder of the run, whichever folder is the present one.
    """

    def __init__(self, model: Model, method: str, arguments: tuple[Any, ...], options: dict[str, Any]) -> None:
        self._model, self._method, self._options = model, method, options
        self._arguments = (_working_folder(), *arguments)

    def __call__(self) -> str:
        page: str = getattr(self._model._native, self._method)(*self._arguments, **self._options)
        return page


def _working_folder() -> str | None:
    """Path of the working folder, or ``None`` if the folder no longer exists."""
    try:
        return os.getcwd()
    except OSError:
        return None


def _again(parts: tuple[str, str, str | None, list[str], float | None, list[str]]) -> Model:
    """Create a model from its parts, for unpickling."""
    return Model(_native.Model.from_parts(parts))


def _optional_text(name: str, value: str | None) -> str | None:
    return None if value is None else _text(name, value)


def _friction(value: bool | str | None) -> str | None:
    if value is None:
        return None
    if isinstance(value, (bool, np.bool_)):
        return "on" if value else "off"
    return _text("friction", value)


def _progress(value: Progress | None) -> Progress | None:
    if value is not None and not callable(value):
        raise InputError(
            f"`progress` is a {type(value).__name__}, not a function",
            "give a function of two whole numbers: the work done and all work",
        )
    return value


def _law(law: ControlLaw, actuators: list[str]) -> Callable[..., list[float]]:
    """Wrap a control law in a function that the native module calls; check the returned efforts."""

    def efforts(
        time: float, q: Floats, v: Floats, reference: tuple[Floats, Floats, Floats]
    ) -> list[float]:
        found = law(ControlState(time, q, v, *reference))
        if isinstance(found, Mapping):
            unknown = [name for name in found if name not in actuators]
            if unknown:
                raise _unknown("actuator", unknown[0], dict.fromkeys(actuators))
            found = [_number(f"effort of {name}", found.get(name, 0.0)) for name in actuators]
        array = _floats("efforts of the control law", found)
        if array.shape != (len(actuators),):
            raise InputError(
                f"the control law returned the shape {array.shape}",
                f"return ({len(actuators)},): one effort for each of {', '.join(actuators)}",
            )
        numbers: list[float] = array.tolist()
        return numbers

    return efforts


def _stop(condition: StopCondition) -> Callable[..., float]:
    """Wrap a stop condition in a function that the native module calls; check the returned value."""

    def distance(time: float, q: Floats, v: Floats, reference: tuple[Floats, Floats, Floats]) -> float:
        return _number("value of the stop condition", condition(ControlState(time, q, v, *reference)))

    return distance


def _function_name(function: Callable[..., object]) -> str:
    """Name of a function of the caller for events and messages."""
    name = getattr(function, "__name__", type(function).__name__)
    return "function" if name == "<lambda>" else str(name)


def _value(name: str, value: object) -> str:
    """Format a changed value as the text of a model file."""
    if isinstance(value, str):
        return _text(name, value)
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, np.ndarray):
        return _value(name, value.tolist())
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_value(name, one) for one in value) + "]"
    return repr(_number(name, value))


__all__ = ["ControlState", "Model", "gallery", "load"]
