"""Values of many types for any option."""

import collections
import datetime
import pathlib

import numpy as np


class Angry:
    """Value whose conversions raise exceptions."""

    def __fspath__(self):
        raise RuntimeError("no path")

    def __float__(self):
        raise RuntimeError("no number")

    def __str__(self):
        return "angry"

    def __iter__(self):
        raise TypeError("not iterable")

    def __array__(self, *_, **__):
        raise RuntimeError("no array")


def hostile_values():
    return [
        "", " ", "\0", "\n", "=", "\ud800", "\u202e", "none", "x" * 100_000, "a = b = c", "[" * 5000, "1e999",
        "t/0", "leg1.P = 1e308 N", "platform.x = 1/t; duration = 1 s", "../../etc/passwd", "/dev/null", "-",
        0, 1, -1, 2**70, -(2**70), 0.0, 1e-300, 1e300, float("nan"), float("inf"), 1j, True, b"", b"\xff",
        [], [1], ["a", None], (), {}, {"a": 1}, {1: 2}, {"leg1.P": "\ud800"}, {"leg1.P": float("nan")},
        {"leg1.P": Angry()}, set(), object(), Angry(), Angry, print, range(3), iter(()), np.float64(0.5),
        np.int64(3), np.bool_(True), np.zeros(3), np.zeros((0, 3)), np.array("text"), np.datetime64("nat"),
        datetime.datetime(2020, 1, 1), pathlib.Path(), pathlib.PurePosixPath("nothing.toml"),
        collections.OrderedDict(a=Angry()), lambda done, of: None, lambda: None, Ellipsis, NotImplemented,
    ]  # fmt: skip
