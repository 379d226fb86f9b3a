"""Results by name, as NumPy arrays."""

from __future__ import annotations

import difflib
import html
import json
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._errors import Error, InputError, UnknownNameError, _floats, _text, _unwritable, _writable

if TYPE_CHECKING:
    import os

    import pandas
    import polars
    import pyarrow

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
_Value = TypeVar("_Value")
_RawTable = tuple[str, list[str], Floats]
_RawResults = tuple[list[_RawTable], str, str]


class ByName(Mapping[str, _Value], Generic[_Value]):
    """Values by name, in the order of the model. The error for an unknown name suggests similar ones."""

    def __init__(self, what: str, values: dict[str, _Value]) -> None:
        self._what = what
        self._values = values

    def __getitem__(self, name: str) -> _Value:
        try:
            return self._values[name]
        except (KeyError, TypeError):
            raise _unknown(self._what, name, self._values) from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __repr__(self) -> str:
        return f"<{self._what}s: {', '.join(self._values) or 'none'}>"


def _unknown(what: str, name: object, known: Mapping[str, object]) -> UnknownNameError:
    """Create the exception for an unknown name, with similar known names."""
    text = name if isinstance(name, str) else repr(name)
    near = difflib.get_close_matches(text, known, n=3, cutoff=0.5)
    if near:
        help = f"did you mean {' or '.join(f'`{one}`' for one in near)}?"
    elif known:
        help = f"known are: {', '.join(list(known)[:12])}{', ...' if len(known) > 12 else ''}"
    else:
        help = f"the results have no {what}"
    return UnknownNameError(f"there is no {what} `{text[:200]!s}`", help)


class Table:
    """A table of a run: the columns of a CSV file of the command line, with the same numbers.

    ``table["leg1.P.drive [N]"]`` or ``table["leg1.P.drive"]`` returns a column, an array of shape (n,).

    Attributes:
        name: name of the file without its extension.
        columns: headers with units in square brackets, SI units and radians.
        array: all numbers, shape (n, columns).
    """

    def __init__(self, name: str, columns: list[str], values: Floats) -> None:
        self.name = name
        self.columns = columns
        self._values = values
        self._places = {header: place for place, header in enumerate(columns)}
        for place, header in enumerate(columns):
            self._places.setdefault(header.rpartition(" [")[0] or header, place)

    @property
    def array(self) -> Floats:
        """All numbers, shape (n, columns)."""
        values: Floats = self._values.T
        return values

    def __getitem__(self, column: str) -> Floats:
        place = self._places.get(column)
        if place is None:
            raise _unknown("column", column, self._places)
        values: Floats = self._values[place]
        return values

    def __contains__(self, column: object) -> bool:
        return column in self._places

    def __len__(self) -> int:
        return int(self._values.shape[1])

    def to_pandas(self) -> pandas.DataFrame:
        """Convert the table to a pandas DataFrame."""
        try:
            import pandas
        except ImportError as error:
            raise _missing("pandas") from error
        return pandas.DataFrame(dict(zip(self.columns, self._values, strict=True)))

    def to_polars(self) -> polars.DataFrame:
        """Convert the table to a polars DataFrame."""
        try:
            import polars
        except ImportError as error:
            raise _missing("polars") from error
        return polars.DataFrame(dict(zip(self.columns, self._values, strict=True)))

    def to_arrow(self) -> pyarrow.Table:
        """Convert the table to a pyarrow Table. The metadata of a field contain the unit of its column."""
        try:
            import pyarrow
        except ImportError as error:
            raise _missing("pyarrow") from error
        fields = [
            pyarrow.field(header, pyarrow.float64(), metadata={"unit": _unit(header)})
            for header in self.columns
        ]
        columns = [pyarrow.array(np.ascontiguousarray(values)) for values in self._values]
        return pyarrow.Table.from_arrays(columns, schema=pyarrow.schema(fields))

    def __repr__(self) -> str:
        return f"<table {self.name}: {len(self)} rows, {len(self.columns)} columns>"


def _unit(header: str) -> str:
    """Unit in the square brackets of a header."""
    _, bracket, rest = header.rpartition(" [")
    return rest.removesuffix("]") if bracket else ""


def _missing(package: str) -> InputError:
    return InputError(f"the package `{package}` is not installed", f"run: pip install {package}")


class JointMotion(NamedTuple):
    """Motion of a joint coordinate, arrays of shape (n,); angles count full turns."""

    position: Floats
    """m or rad"""
    rate: Floats
    """m/s or rad/s"""
    acceleration: Floats
    """m/s^2 or rad/s^2"""


class JointFriction(NamedTuple):
    """Friction in a friction interface of a joint, arrays of shape (n,)."""

    speed: Floats
    """Sliding speed at the surface, m/s."""
    load: Floats
    """Normal load, N."""
    force: Floats
    """Friction force at the surface, N."""
    power: Floats
    """Dissipated power, W."""
    flag: Bools
    """Inverse dynamics: true if statics determines the normal load. Simulations: true while the interface sticks."""


class Results:
    """Results of a run along a motion or through time.

    Attributes:
        time: instants, s, shape (n,).
        tables: all tables of the command line by name, such as ``tables["joints"]``.
        summary: the contents of ``summary.json``.
        text: the summary that the command line prints.
    """

    _main = ""

    def __init__(
        self, model: str, raw: _RawResults, summary: dict[str, Any], draw: Callable[[], str] | None = None
    ) -> None:
        tables, _, text = raw
        self.model = model
        all_tables = [(file.rpartition(".")[0], header, values) for file, header, values in tables]
        self.tables: ByName[Table] = ByName(
            "table", {name: Table(name, header, values) for name, header, values in all_tables}
        )
        self.summary: dict[str, Any] = summary
        self.text = text
        self._draw = draw

    @property
    def time(self) -> Floats:
        """Instants, s, shape (n,)."""
        times: Floats = self._table()._values[0]
        return times

    @property
    def cautions(self) -> list[str]:
        """Cautions about the results, one sentence each."""
        return list(self.summary.get("cautions", []))

    def __len__(self) -> int:
        return len(self._table())

    def _table(self, name: str | None = None) -> Table:
        return self.tables[name or self._main]

    def _named(self, what: str, table: str, quantity: str) -> ByName[Floats]:
        """Columns ``NAME.quantity`` of a table by ``NAME``."""
        found = self.tables.get(table)
        end = f".{quantity}"
        values = {}
        if found is not None:
            for header, column in zip(found.columns, found._values, strict=True):
                name = header.rpartition(" [")[0] or header
                if name.endswith(end):
                    values[name[: -len(end)]] = column
        return ByName(what, values)

    def _blocks(
        self,
        what: str,
        table: str,
        first: str,
        make: Callable[[Floats], _Value],
        before: int = 0,
    ) -> ByName[_Value]:
        """Blocks of consecutive columns by ``NAME``. A block begins ``before`` columns before ``NAME.first``."""
        found = self._table(table)
        end = f".{first}"
        heads = [header.rpartition(" [")[0] or header for header in found.columns]
        places = [place for place, head in enumerate(heads) if head.endswith(end)]
        return ByName(
            what, {heads[place][: -len(end)]: make(found._values[place - before :]) for place in places}
        )

    @property
    def effort(self) -> ByName[Floats]:
        """Force, N, or torque, N m, of each actuator, shape (n,)."""
        return self._named("actuator", self._main, "drive")

    @property
    def efforts(self) -> Floats:
        """Forces and torques of all actuators, shape (n, actuators)."""
        return _stacked(self.effort, len(self))

    @property
    def reaction(self) -> ByName[Floats]:
        """Complete wrench that a joint's predecessor exerts on its successor, shape (n, 6): force, N, and
        moment about the joint's origin, N m, world axes; constraint, actuator and friction together.
        """
        return self._blocks("joint", "reactions", "fx", lambda values: values[:6].T)

    @property
    def reaction_determined(self) -> ByName[Bools]:
        """True at samples at which statics determines all components of a joint's reaction, shape (n,)."""
        return self._blocks("joint", "reactions", "fx", lambda values: values[6] != 0.0)

    @property
    def joint(self) -> ByName[JointMotion]:
        """Position, rate and acceleration of each scalar joint coordinate."""
        table = "joints" if "joints" in self.tables else self._main
        return self._blocks(
            "joint coordinate",
            table,
            "position",
            lambda values: JointMotion(values[0], values[1], values[2]),
        )

    @property
    def position(self) -> ByName[Floats]:
        """Position of each body's origin, m, world axes, shape (n, 3)."""
        return self._blocks("body", "bodies", "qw", lambda values: values[:3].T, before=3)

    @property
    def quaternion(self) -> ByName[Floats]:
        """Orientation of each body as a unit quaternion in the order w, x, y, z, shape (n, 4)."""
        return self._blocks("body", "bodies", "qw", lambda values: values[:4].T)

    def to_pandas(self, table: str | None = None) -> pandas.DataFrame:
        """Convert a table to a pandas DataFrame; the main table if no name is given."""
        return self._table(None if table is None else _text("table", table)).to_pandas()

    def to_polars(self, table: str | None = None) -> polars.DataFrame:
        """Convert a table to a polars DataFrame; the main table if no name is given."""
        return self._table(None if table is None else _text("table", table)).to_polars()

    def to_arrow(self, table: str | None = None) -> pyarrow.Table:
        """Convert a table to a pyarrow Table; the main table if no name is given."""
        return self._table(None if table is None else _text("table", table)).to_arrow()

    def report(self, path: str | os.PathLike[str] | None = None) -> str:
        """Draw the report of the run, ``report.html`` of the command line: a page of HTML with tables, plots and the
        moving robot. Return its text, and write it to the file ``path`` if it is given.

        The run is computed again for its report. A simulation under a control law that is a function has none, because
        the function may have a state.

        Raises:
            InputError: ``path`` is not a path, or the run has no report.
            OutputError: the file cannot be written.

        >>> import stiction
        >>> stiction.load("five-bar").inverse(step=0.1).report().startswith("<!DOCTYPE html>")
        True
        """
        target = None if path is None else _writable("path", path)
        if self._draw is None:
            raise InputError(
                "a simulation with a function as control law or stop condition has no report",
                "give the controller as a text such as `computed-torque`, and stop conditions as texts",
            )
        page = self._draw()
        if target is not None:
            part = target.with_name(target.name + ".part")
            try:
                part.write_text(page, encoding="utf-8")
                part.replace(target)
            except (OSError, ValueError) as error:
                raise _unwritable(target, error) from error
        return page

    def to_parquet(self, folder: str | os.PathLike[str]) -> list[Path]:
        """Write each table to a Parquet file in a folder; return the paths.

        The metadata of each file contain the summary of the run as JSON, those of its fields the units.
        Each file is written under a temporary name and then renamed, so that no incomplete file appears.

        Raises:
            InputError: ``folder`` is not a path, or pyarrow is not installed.
            OutputError: a file cannot be written.
        """
        place = _writable("folder", folder)
        tables = {name: table.to_arrow() for name, table in self.tables.items()}
        import pyarrow.parquet

        try:
            place.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise _unwritable(place, error) from error
        summary = {"stiction.summary": json.dumps(self.summary)}
        written = []
        for name, table in tables.items():
            path = place / f"{name}.parquet"
            part = path.with_suffix(".parquet.part")
            try:
                pyarrow.parquet.write_table(table.replace_schema_metadata(summary), part)
                part.replace(path)
            except OSError as error:
                raise _unwritable(path, error) from error
            written.append(path)
        return written

    def __repr__(self) -> str:
        return f"<{type(self).__name__} of {self.model}: {len(self)} samples>"

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(self.text)}</pre>"


def _stacked(columns: Mapping[str, Floats], rows: int) -> Floats:
    return np.column_stack(list(columns.values())) if columns else np.empty((rows, 0))


class InverseResults(Results):
    """Inverse dynamics along a motion; see :meth:`stiction.Model.inverse`.

    The numbers equal those in the CSV files of the command line, in SI units and radians, along world axes.

    >>> import stiction
    >>> r = stiction.load("3rps").inverse()
    >>> r.effort["leg1.P"].shape == r.time.shape
    True
    >>> r.reaction["leg1.S"].shape == (len(r), 6)
    True
    >>> float(abs(r.power_residual).max()) < 1e-9
    True
    """

    _main = "inverse"

    @property
    def effort_frictionless(self) -> ByName[Floats]:
        """Effort of each actuator without friction, N or N m, shape (n,)."""
        return self._named("actuator", "inverse", "drive_frictionless")

    @property
    def effort_low(self) -> ByName[Floats]:
        """Least effort that static friction permits at rest, N or N m, shape (n,)."""
        return self._named("actuator", "inverse", "drive_low")

    @property
    def effort_high(self) -> ByName[Floats]:
        """Greatest effort that static friction permits at rest, N or N m, shape (n,)."""
        return self._named("actuator", "inverse", "drive_high")

    @property
    def friction(self) -> ByName[JointFriction]:
        """Friction of each friction interface; ``flag`` is true if statics determines the normal load."""
        return self._blocks("friction interface", "friction", "speed", _friction(3))

    @property
    def contribution(self) -> ByName[ByName[Floats]]:
        """Contribution of each friction interface to each actuator's effort, N or N m, shape (n,):
        ``contribution["leg1.P"]["leg2.S"]``.
        """
        parts = {}
        for name in self.effort if "contributions" in self.tables else ():
            begin = f"{name}.from."
            table = self.tables["contributions"]
            heads = [header.rpartition(" [")[0] for header in table.columns]
            found = {
                head[len(begin) :]: values
                for head, values in zip(heads, table._values, strict=True)
                if head.startswith(begin)
            }
            parts[name] = ByName("friction interface", found)
        return ByName("actuator", parts)

    @property
    def power_residual(self) -> Floats:
        """Residual of the power balance, W, shape (n,); zero up to rounding."""
        return self._table()["power.residual"]

    @property
    def closure_error(self) -> Floats:
        """Largest loop-closure error, m, shape (n,); angles are multiplied by the characteristic length."""
        return self._table()["closure"]

    @property
    def actuation_distance(self) -> Floats:
        """Singularity index of actuation (type 2), shape (n,); zero at a singular position."""
        return self._table()["distance.actuation"]

    @property
    def constraint_distance(self) -> Floats:
        """Singularity index of the constraints, shape (n,); zero at a singular position."""
        return self._table()["distance.constraint"]

    @property
    def motor_torque(self) -> ByName[Floats]:
        """Torque of the motor of each drive train, N m, shape (n,)."""
        return self._named("drive train", "inverse", "motor_torque")

    @property
    def motor_speed(self) -> ByName[Floats]:
        """Speed of the motor of each drive train, rad/s, shape (n,)."""
        return self._named("drive train", "inverse", "motor_speed")

    @property
    def current(self) -> ByName[Floats]:
        """Current of each motor with a torque constant, A, shape (n,)."""
        return self._named("motor with a torque constant", "inverse", "current")


def _friction(power: int) -> Callable[[Floats], JointFriction]:
    """Create a reader of the columns of a friction interface; ``power`` is the place of the power, before the flag."""

    def make(values: Floats) -> JointFriction:
        flag = values[power + 1] != 0.0
        return JointFriction(values[0], values[1], values[2], values[power], flag)

    return make


class Event(NamedTuple):
    """Event of a simulation."""

    time: float
    """s"""
    event: str
    """Kind as one word, such as ``sticks``, ``slides``, ``stop``."""
    at: str
    """Friction interface, joint or condition; may be empty."""
    detail: str
    """Details; may be empty."""


class ForwardResults(Results):
    """A simulation; see :meth:`stiction.Model.forward`.

    Attributes:
        events: all events, in the order of time.
        ended: ``None`` if the simulation reached its end or a stop condition, else the reason.

    >>> import stiction
    >>> r = stiction.load("five-bar").forward(until=0.1)
    >>> float(r.time[-1])
    0.1
    >>> r.ended is None
    True
    """

    _main = "forward"

    def __init__(
        self,
        model: str,
        raw: _RawResults,
        summary: dict[str, Any],
        events: list[tuple[float, str, str, str]],
        ended: Error | None,
        draw: Callable[[], str] | None = None,
    ) -> None:
        super().__init__(model, raw, summary, draw)
        self.events: list[Event] = [Event(*event) for event in events]
        self.ended: Error | None = ended

    def joint_at(self, times: ArrayLike) -> ByName[JointMotion]:
        """Joint coordinates at any times, s, of the simulation; each array has the shape of ``times``.

        Between samples, positions are the cubic polynomials that have the positions and rates of the samples; rates
        and accelerations are their derivatives. Where no event lies between two samples, the error of positions
        decreases with the fourth power of ``step``, down to the error of the integration.

        Raises:
            InputError: a time is outside of the simulation.

        >>> import stiction
        >>> r = stiction.load("five-bar").forward(until=0.1)
        >>> r.joint_at([0.012, 0.0137])["left_motor"].position.shape
        (2,)
        """
        at = _floats("times", times)
        time = self.time
        if not np.all((at >= time[0]) & (at <= time[-1])):
            raise InputError(
                f"`times` are not all from {time[0]:g} s to {time[-1]:g} s", "give times of the simulation", "times"
            )
        if len(time) < 2:
            return ByName("joint coordinate", {k: JointMotion(*(x[0] + 0 * at for x in j)) for k, j in self.joint.items()})
        place = np.clip(np.searchsorted(time, at, side="right") - 1, 0, len(time) - 2)
        width = time[place + 1] - time[place]
        s = (at - time[place]) / width

        def between(joint: JointMotion) -> JointMotion:
            start = joint.position[place]
            change = joint.position[place + 1] - start
            before, after = joint.rate[place] * width, joint.rate[place + 1] * width
            square, cube = 3 * change - 2 * before - after, before + after - 2 * change
            return JointMotion(
                start + s * (before + s * (square + s * cube)),
                (before + s * (2 * square + 3 * s * cube)) / width,
                (2 * square + 6 * s * cube) / width**2,
            )

        return ByName("joint coordinate", {name: between(joint) for name, joint in self.joint.items()})

    @property
    def reference(self) -> ByName[Floats]:
        """Reference position of each actuator that follows a motion, m or rad, shape (n,)."""
        return self._named("actuator that follows a motion", "forward", "reference")

    @property
    def friction(self) -> ByName[JointFriction]:
        """Friction of each friction interface, including shafts of motors; ``flag`` is true while it sticks."""
        return self._blocks("friction interface", "friction", "speed", _friction(4))

    @property
    def friction_limit(self) -> ByName[Floats]:
        """Static friction limit of each friction interface, N, shape (n,)."""
        return self._named("friction interface", "friction", "limit")

    @property
    def work(self) -> ByName[Floats]:
        """Work of each actuator since the start, and of all loads (name ``loads``), J, shape (n,)."""
        return self._named("actuator", "energy", "work")

    @property
    def dissipated(self) -> ByName[Floats]:
        """Energy dissipated since the start in each friction interface, and in dampers (``dampers``), J, shape (n,)."""
        return self._named("friction interface", "energy", "dissipated")

    @property
    def kinetic_energy(self) -> Floats:
        """Kinetic energy, J, shape (n,)."""
        return self._table("energy")["kinetic"]

    @property
    def potential_energy(self) -> Floats:
        """Potential energy of gravity and springs, J, shape (n,)."""
        return self._table("energy")["potential"]

    @property
    def energy_error(self) -> Floats:
        """Error of the energy balance since the start, J, shape (n,); due to numerical errors."""
        return self._table("energy")["error"]


class Report(Mapping[str, Any]):
    """Report as a mapping with the keys of the command line's JSON. ``print(report)`` prints its text.

    >>> import stiction
    >>> report = stiction.load("five-bar").check()
    >>> report["mobility"]["instantaneous"]
    2
    """

    def __init__(self, data: dict[str, Any], text: str) -> None:
        self.data = data
        self.text = text

    def __getitem__(self, key: str) -> Any:
        try:
            return self.data[key]
        except (KeyError, TypeError):
            raise _unknown("key", key, self.data) from None

    def __iter__(self) -> Iterator[str]:
        return iter(self.data)

    def __len__(self) -> int:
        return len(self.data)

    def __str__(self) -> str:
        return self.text

    def __repr__(self) -> str:
        return f"<report: {', '.join(self.data)}>"

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(self.text)}</pre>"
