"""Models described in Python."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from . import _native
from ._errors import InputError, _number, _text
from ._model import Model

_BARE = re.compile(r"[A-Za-z0-9_-]+")
_DOTTED = re.compile(r"[A-Za-z0-9_-]+(\.[A-Za-z0-9_-]+)*")
#: Largest depth of nested values.
_DEEPEST = 8


class Builder:
    """Describes a model step by step, with the keys of the model file.

    A value is a text with units (``"2 kg"``), a number without a unit, a list of values, a mapping, or a pair of
    numbers and their unit: ``(2.0, "kg")``, ``([0, 0, 0.1], "m")``. A trailing underscore of a key is removed.

    >>> import stiction
    >>> b = stiction.Builder("pendulum", gravity=([0, -9.81, 0], "m/s^2"))
    >>> b = b.body("bob", mass=(2.0, "kg"), com=([0, -0.4, 0], "m"), inertia=[0, 0, 0])
    >>> b = b.joint("pivot", "R", "ground", "bob", axis="z", actuated=True)
    >>> m = b.motion("hold", pivot=(0.5, "rad"), duration=0).build()
    >>> float(m.inverse().effort["pivot"][0].round(4))   # 2 kg * 9.81 m/s^2 * 0.4 m * sin(0.5)
    3.7625
    """

    def __init__(self, name: str, **keys: Any) -> None:
        self._top: dict[str, Any] = {"name": _text("name", name), **keys}
        self._tables: dict[tuple[str, str], dict[str, Any]] = {}

    def _table(self, kind: str, name: str, keys: dict[str, Any]) -> Builder:
        place = (kind, _text("name", name))
        if place in self._tables:
            raise InputError(f"there is already a table [{kind}.{name}]", "choose another name")
        self._tables[place] = keys
        return self

    def body(self, name: str, /, **keys: Any) -> Builder:
        """Add a body with ``mass``, ``com``, ``inertia`` and other keys of ``[bodies.NAME]``."""
        return self._table("bodies", name, keys)

    def joint(self, name: str, type: str, from_: str, to: str, /, **keys: Any) -> Builder:
        """Add a joint from one body to another, with keys of ``[joints.NAME]``."""
        return self._table("joints", name, {"type": type, "from": from_, "to": to, **keys})

    def actuator(self, name: str, /, **keys: Any) -> Builder:
        """Add a motor and its gear, with keys of ``[actuators.NAME]``."""
        return self._table("actuators", name, keys)

    def spring(self, name: str, /, **keys: Any) -> Builder:
        """Add a spring with keys of ``[springs.NAME]``."""
        return self._table("springs", name, keys)

    def motion(self, name: str, /, keys: Mapping[str, Any] | None = None, **more: Any) -> Builder:
        """Add a motion: signals of coordinates. Names with dots, such as ``"platform.x"``, are given in a mapping."""
        return self._table("motions", name, {**(keys or {}), **more})

    def load(self, name: str, /, keys: Mapping[str, Any] | None = None, **more: Any) -> Builder:
        """Add a load with keys of ``[loads.NAME]``."""
        return self._table("loads", name, {**(keys or {}), **more})

    @property
    def text(self) -> str:
        """Text of the model file."""
        lines = [f"{_key(key)} = {_toml(key, value)}" for key, value in self._top.items()]
        for (kind, name), keys in self._tables.items():
            quoted = name if _BARE.fullmatch(name) else json.dumps(name)
            lines.append(f"\n[{kind}.{quoted}]")
            lines += [f"{_key(key)} = {_toml(key, value)}" for key, value in keys.items()]
        return "\n".join(lines) + "\n"

    def build(self) -> Model:
        """Read the described model.

        Raises:
            ModelError: the description is defective; the text lists all defects with their places.
        """
        return Model(_native.Model.parse(self.text))

    def __repr__(self) -> str:
        return f"<Builder of {self._top['name']}: {len(self._tables)} tables>"


def _key(key: object) -> str:
    text = _text("key", key)
    text = text[:-1] if text.endswith("_") else text
    return text if _DOTTED.fullmatch(text) else json.dumps(text)


def _toml(key: str, value: Any, depth: int = 0) -> str:
    """Format a value as TOML."""
    if depth > _DEEPEST:
        raise InputError(f"`{key}` is nested too deeply", f"use at most {_DEEPEST} levels")
    if isinstance(value, np.ndarray):
        return _toml(key, value.tolist(), depth)
    if isinstance(value, str):
        return json.dumps(_text(key, value), ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, Mapping):
        parts = (f"{_key(k)} = {_toml(f'{key}.{k}', v, depth + 1)}" for k, v in value.items())
        return "{ " + ", ".join(parts) + " }" if value else "{}"
    if isinstance(value, tuple) and len(value) == 2 and isinstance(value[1], str):
        return _with_unit(key, value[0], _text(key, value[1]), depth + 1)
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_toml(key, one, depth + 1) for one in value) + "]"
    number = _number(key, value)
    return repr(int(number)) if number.is_integer() and abs(number) < 1e15 else repr(number)


def _with_unit(key: str, value: Any, unit: str, depth: int) -> str:
    """Format numbers with their unit as TOML."""
    if depth > _DEEPEST:
        raise InputError(f"`{key}` is nested too deeply", f"use at most {_DEEPEST} levels")
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_with_unit(key, one, unit, depth + 1) for one in value) + "]"
    return json.dumps(f"{_number(key, value)!r} {unit}", ensure_ascii=False)
