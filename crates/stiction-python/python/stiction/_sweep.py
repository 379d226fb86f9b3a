"""Studies of many designs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ._errors import InputError, _count, _number, _text, _texts
from ._model import Model, Progress, _friction, _optional_text, _progress, _value


def sweep(
    model: Model,
    table: Any,
    objectives: str | Iterable[str],
    *,
    motion: str | None = None,
    load: str | None = None,
    friction: bool | str | None = None,
    step: float | None = None,
    threads: int = 1,
    progress: Progress | None = None,
) -> Any:
    """Statistics of inverse dynamics for many designs, as ``stiction sweep`` computes them.

    The function is pure: a row depends only on the model, its design and the options, to the last bit. A large table
    may therefore be divided in any way, and computed in any process. Model, function and tables can be pickled.

    Args:
        model: the robot.
        table: the designs: a mapping of keys to lists of values, one for each design, or a pandas or polars table. A
            key is the path of a key of the model or the name of a parameter, with the unit of its numbers:
            ``"mu"``, ``"tool.mass [kg]"``, ``"motion.platform.z [mm]"``. Without a unit, numbers of a parameter are in
            its SI unit, as in :meth:`Model.with_`. Values are numbers or texts (``"20 mm"``); ``None``
            keeps the value of the model.
        objectives: statistics to compute, such as ``"peak(leg1.P.effort)"``, ``"min(distance.actuation)"``.
        motion: name of a motion of the model, a file, or assignments. Default: that of the model. Other processes find
            a file by its absolute path.
        load: name of a load of the model, or assignments.
        friction: as in :meth:`Model.inverse`.
        step: time between samples, s.
        threads: number of threads.
        progress: called at intervals with the number of designs done and the number of all designs.

    Returns:
        A table of the same kind as ``table`` (a dictionary of arrays for a mapping; a pandas table keeps its index). It
        has the columns of the designs, one column for each objective with its unit, NaN if a design has no value, and
        the column ``status``: ``"ok"``, or the reason why there are no results.

    Raises:
        InputError: a key, objective or motion is unknown, or ``table`` is not a table of designs.

    >>> import stiction
    >>> rows = stiction.sweep(stiction.load("five-bar"), {"crank [mm]": [200, 220]}, "peak(left_motor.effort)")
    >>> [round(float(x), 3) for x in rows["peak(left_motor.effort) [N m]"]], rows["status"].tolist()
    ([6.07, 6.87], ['ok', 'ok'])
    """
    if not isinstance(model, Model):
        raise InputError("`model` is not a Model", "create one with `stiction.load`")
    names, values = _columns(table)
    units = model.parameter_units
    columns = [(_with_unit(name, units), _cells(name, column)) for name, column in zip(names, values)]
    headers, measured, statuses = model._native.sweep(
        columns,
        _texts("objectives", objectives),
        motion=_optional_text("motion", motion),
        load=_optional_text("load", load),
        friction=_friction(friction),
        step=None if step is None else _number("step", step),
        threads=_count("threads", threads),
        progress=_progress(progress),
    )
    added: dict[str, Any] = dict(zip(headers, measured))
    added["status"] = statuses
    kind = _kind(table)
    if kind == "pandas":
        return table.assign(**added)
    if kind == "polars":
        import polars

        return table.with_columns([polars.Series(name, column) for name, column in added.items()])
    whole = {name: np.asarray(column) for name, column in zip(names, values)}
    return {**whole, **{name: np.asarray(column) for name, column in added.items()}}


def _kind(table: object) -> str:
    """Name of the library from which a table comes."""
    return type(table).__module__.split(".")[0]


def _columns(table: Any) -> tuple[list[str], list[Any]]:
    """Keys and values of a table of designs."""
    if isinstance(table, Mapping):
        names = list(table)
    elif _kind(table) in ("pandas", "polars") and hasattr(table, "columns"):
        names = list(table.columns)
    else:
        raise InputError(
            f"`table` is a {type(table).__name__}, not a table of designs",
            'give a mapping of keys to values, such as {"mu": [0.1, 0.2]}, or a table of pandas or polars',
        )
    names = [_text("table", name) for name in names]
    if not names:
        raise InputError("`table` has no columns", 'give keys with values, such as {"mu": [0.1, 0.2]}')
    try:
        return names, [list(table[name]) for name in names]
    except Exception as error:
        raise InputError(f"`table` cannot be read: {error}", "give a sequence of values for each key") from error


def _with_unit(name: str, units: Mapping[str, str]) -> str:
    """Key of a column; numbers of a parameter without a unit are in its SI unit, as in :meth:`Model.with_`."""
    unit = units.get(name.strip(), "")
    return f"{name.strip()} [{unit}]" if unit else name


def _cells(name: str, values: list[Any]) -> list[float] | list[str]:
    """Values of a key as numbers, or as texts if some value is not a number."""

    def is_number(value: object) -> bool:
        return isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)

    for row, value in enumerate(values):
        if is_number(value) and not np.isfinite(float(value)):
            raise InputError(
                f"`{name}` is {value} in design {row + 1}", "give a finite number, or None to keep the value of the model"
            )
    if all(is_number(value) for value in values):
        return [float(value) for value in values]

    def cell(value: object) -> str:
        if value is None:
            return ""
        return repr(float(value)) if is_number(value) else _value(name, value)  # type: ignore[arg-type]

    return [cell(value) for value in values]
