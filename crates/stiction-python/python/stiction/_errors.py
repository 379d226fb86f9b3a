"""Exceptions of the package, and checks of arguments."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "ComputationError",
    "Error",
    "InputError",
    "InternalError",
    "InterruptedRun",
    "ModelError",
    "OutputError",
    "UnknownNameError",
]


class Error(Exception):
    """Reason why a computation has no result.

    ``str(error)`` is the text that the command line prints: the message with its place, and a suggestion.

    Attributes:
        message: the message without the suggestion.
        help: the suggestion, or ``None``.
        option: name of the argument that can avoid the error, or ``None``.
        details: the relevant numbers in SI units, such as ``{"time": 0.2}``.
        result: results up to the failure of a simulation, else ``None``.

    >>> import stiction
    >>> try:
    ...     stiction.load("gouhg")
    ... except stiction.Error as error:
    ...     print(error.message)
    there is no built-in model `gouhg`
    """

    def __init__(
        self,
        message: str,
        help: str | None = None,
        option: str | None = None,
        details: dict[str, Any] | None = None,
    ) -> None:
        super().__init__(message)
        self.message = message
        self.help = help
        self.option = option
        self.details: dict[str, Any] = details or {}
        self.result: Any = None

    def __str__(self) -> str:
        if self.help is None:
            return self.message
        option = f" (argument `{self.option}`)" if self.option else ""
        return f"{self.message}\nhelp: {self.help}{option}"

    def __reduce__(self) -> Any:
        return type(self), (self.message, self.help, self.option, self.details)


class InputError(Error, ValueError):
    """The input cannot be used: an unknown option, a wrong shape, a file that cannot be read."""


class UnknownNameError(InputError, KeyError):
    """There is no actuator, joint, body or column of this name."""

    __str__ = Error.__str__


class ModelError(InputError):
    """A model, motion or load is defective. The text lists every defect with its place, as the command line does.

    Attributes:
        diagnostics: one dictionary for each message: severity, code, message, line and column.
    """

    @property
    def diagnostics(self) -> list[dict[str, Any]]:
        """One dictionary for each message, with its place."""
        found = self.details.get("diagnostics", [])
        return list(found) if isinstance(found, list) else []


class ComputationError(Error):
    """The problem has no solution: a singular position, a mechanism that jams, a loop that cannot close."""


class InterruptedRun(Error):
    """The computation was stopped."""


class OutputError(Error):
    """A receiver of the results failed."""


class InternalError(Error):
    """A defect of this package. Please report it with the input that caused it."""


_KINDS: dict[str, type[Error]] = {
    "model": ModelError,
    "input": InputError,
    "no-answer": ComputationError,
    "interrupted": InterruptedRun,
    "output": OutputError,
    "internal": InternalError,
}


def _from_native(
    kind: str, message: str, help: str | None, option: str | None, details: str
) -> Error:
    """Create the exception for an error of the native module."""
    content = json.loads(details)
    numbers = content.get("details")
    if kind == "model":
        numbers = {"diagnostics": content.get("diagnostics", [])}
    return _KINDS.get(kind, Error)(message, help, option, numbers if isinstance(numbers, dict) else {})


def _floats(name: str, value: object) -> NDArray[np.float64]:
    """Convert an argument to an array of floating-point numbers; an exception contains the argument's name."""
    if isinstance(value, np.ma.MaskedArray):
        if np.ma.is_masked(value):
            raise InputError(
                f"`{name}` has {int(np.ma.getmaskarray(value).sum())} masked values",
                "remove their rows, or give every value: `array.filled(...)`",
            )
        value = value.data
    try:
        array = np.asarray(value)
    except Exception as error:
        raise InputError(f"`{name}` is not an array: {error}", "give an array of numbers") from error
    if array.dtype.kind not in "fiub":
        raise InputError(
            f"`{name}` contains values of the type `{array.dtype}`",
            "give floating-point numbers in SI units",
        )
    return np.array(array, dtype=np.float64, order="C", copy=True)


def _text(name: str, value: object) -> str:
    """Check that an argument is a text; an exception contains the argument's name."""
    if not isinstance(value, str):
        raise InputError(f"`{name}` is a {type(value).__name__}, not a text", "give a str")
    try:
        value.encode()
    except UnicodeEncodeError as error:
        raise InputError(
            f"`{name}` is not valid text: {value!r}: {error.reason}", "give a text of Unicode characters"
        ) from error
    return value


def _path(name: str, value: object) -> str:
    """Check that an argument is a path whose name is valid text; an exception contains the argument's name."""
    if not isinstance(value, (str, os.PathLike)):
        raise InputError(f"`{name}` is a {type(value).__name__}, not a path", "give a str or a pathlib.Path")
    try:
        path = os.fspath(value)
    except Exception as error:
        raise InputError(f"`{name}` is not a path: {error}") from error
    return _text(name, path)


def _writable(name: str, value: object) -> Path:
    """Check that an argument is a path to which this package can write; an exception contains the argument's name."""
    path = _path(name, value)
    if "\0" in path:
        raise InputError(f"`{name}` contains a null character: {path!r:.60}", "give the name of a file or folder")
    return Path(path)


def _unwritable(path: Path, error: Exception) -> OutputError:
    """Create the exception for a file that cannot be written."""
    reason = getattr(error, "strerror", None) or str(error)
    return OutputError(f"cannot write {path}: {reason}", "give a folder in which you can write")


def _items(name: str, values: object) -> list[Any]:
    """Elements of an argument that must be a sequence."""
    try:
        items: list[Any] = list(values)  # type: ignore[call-overload]
    except Exception as error:
        raise InputError(
            f"`{name}` is a {type(values).__name__}, not a sequence of texts", "give a list of str"
        ) from error
    return items


def _texts(name: str, values: object) -> list[str]:
    """Check that an argument is a text or a sequence of texts."""
    if isinstance(values, str):
        return [_text(name, values)]
    return [_text(name, value) for value in _items(name, values)]


def _number(name: str, value: object) -> float:
    """Check that an argument is a finite number; an exception contains the argument's name."""
    try:
        number = float(value)  # type: ignore[arg-type]
    except Exception as error:
        raise InputError(
            f"`{name}` is {value!r:.60}, not a number", "give a number in SI units"
        ) from error
    if not np.isfinite(number):
        raise InputError(f"`{name}` is {number}, not a finite number", "give a finite number in SI units")
    return number


def _count(name: str, value: object) -> int:
    """Check that an argument is a whole number from 1 to 1024; an exception contains the argument's name."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)):
        raise InputError(f"`{name}` is {value!r:.60}, not a whole number", "give a number such as 4")
    if not 1 <= value <= 1024:
        raise InputError(f"`{name}` is {value!s:.60}, not from 1 to 1024", "give a number from 1 to 1024")
    return int(value)
