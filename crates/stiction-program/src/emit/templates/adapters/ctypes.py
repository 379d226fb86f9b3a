"""Feed-forward of @NAME@ in Python: the C code by ctypes.

`make library` builds the library; `python3 @NAME@.py vectors.csv` reproduces the test vectors.
The comment at the beginning of @NAME@.h lists names, units and order of all numbers.
"""

import ctypes
import os
import sys

COORDINATES = @COORDINATES@
ACTUATORS = @DRIVES@
# Return codes.
OK, UNDETERMINED, FRICTIONLESS = 0, 1, 2
BAD_INPUT, OPEN, SINGULAR, NOT_READY = -1, -2, -3, -4
# Friction at rest.
HELD, FADED, ZERO = 0, 1, 2

Real = ctypes.c_@REAL@
Coordinates = Real * COORDINATES
Efforts = Real * ACTUATORS


class Params(ctypes.Structure):
    """Parameters that can be changed between calls."""

    _fields_ = [
@PYTHON_FIELDS@        ("rest_rate", Real),
        ("fade", Real),
        ("rest", ctypes.c_int),
    ]


class State(ctypes.Structure):
    """State that is kept from one call to the next."""

    _fields_ = [
        ("tree", Real * @TREE@),
        ("tau", Efforts),
        ("direction", Coordinates),
        ("weight", Real),
        ("weakest", Real * (12 * @BODIES@)),
        ("ready", ctypes.c_uint),
    ]


class Info(ctypes.Structure):
    """Details of a call."""

    _fields_ = [
        ("residual", Real),
        ("singularity_index", Real),
        ("determinant", Real),
        ("coupling", Real),
        ("reaction", Real),
        ("joint", ctypes.c_int),
        ("corrections", ctypes.c_int),
        ("steps", ctypes.c_int),
        ("index_passes", ctypes.c_int),
        ("undetermined", ctypes.c_int),
        ("fallback", ctypes.c_int),
    ]


def _library():
    end = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")
    return os.path.join(os.path.dirname(os.path.abspath(__file__)), "lib@NAME@" + end)


def _fitting(path):
    """Loads the library. Code of another model or precision would write beyond the structures of this file."""
    code = ctypes.CDLL(path)
    expected = [@PYTHON_FINGERPRINT@] + [ctypes.sizeof(part) for part in (Real, Params, State, Info)]
    try:
        code.@NAME@_identity.restype = ctypes.c_uint
        found = [code.@NAME@_identity(item) for item in range(len(expected))]
    except AttributeError:
        found = None
    if found != expected:
        raise ValueError(
            f"{path} and {__file__} are from different exports (fingerprint and sizes are {found}, expected "
            f"{expected}): run `make library` in the folder of this file"
        )
    return code


def _coordinates(row):
    # An array of C fills missing numbers with zeros.
    if len(row) != len(Coordinates()):
        raise ValueError(f"{len(Coordinates())} numbers are needed, one for each coordinate, not {len(row)}")
    return Coordinates(*row)


class Robot:
    """Feed-forward that starts at the positions q."""

    def __init__(self, q, library=None):
        self._code = _fitting(library or _library())
        self.params, self.info, self._state = Params(), Info(), State()
        self._code.@NAME@_defaults(ctypes.byref(self.params))
        code = self._code.@NAME@_init(ctypes.byref(self._state), _coordinates(q))
        if code != OK:
            raise ValueError(f"the loops cannot be closed at {list(q)}: code {code}")

    def _call(self, function, *motion):
        tau = Efforts()
        code = function(
            ctypes.byref(self.params),
            ctypes.byref(self._state),
            *(None if row is None else _coordinates(row) for row in motion),
            tau,
            ctypes.byref(self.info),
        )
        return code, list(tau)

    def ff(self, q, qd, qdd, direction=None):
        """Returns the code and the efforts of a motion; details are in `info`."""
        return self._call(self._code.@NAME@_ff_towards, q, qd, qdd, direction)

    def hold(self, q, direction=None):
        """Returns the code and the efforts that hold a position, or begin a motion in a direction."""
        return self._call(self._code.@NAME@_hold, q, direction)


def main(path):
    """Reproduces the test vectors; returns the number of failures."""
    rows = failures = 0
    worst = 0.0
    with open(path, encoding="ascii") as file:
        next(file)
        for line in file:
            row = [float(number) for number in line.split(",")]
            q, qd, qdd = (row[k * COORDINATES : (k + 1) * COORDINATES] for k in range(3))
            expected = row[3 * COORDINATES :]
            code, tau = Robot(q).ff(q, qd, qdd)
            apart = max(abs(a - b) for a, b in zip(tau, expected)) / max(map(abs, expected))
            worst = max(worst, apart)
            rows += 1
            failures += code != OK or not apart <= @TOLERANCE@
    print(f"@NAME@: {rows} test vectors, {failures} failures, largest relative difference {worst:.1e}")
    return failures if rows else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1] if len(sys.argv) > 1 else "vectors.csv") != 0)
