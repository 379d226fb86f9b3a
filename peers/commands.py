"""Processor times of commands, on the core on which all programs of the comparison run."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

CORE = (os.cpu_count() or 1) - 1
#: greatest memory of a command, bytes
MEMORY = 6 << 30
#: exit code of our commands for input that they cannot use
REFUSAL = 2


class TooSlow(Exception):
    """The command needed more processor time than its limit."""


class Refused(RuntimeError):
    """The command ended with the exit code `REFUSAL`."""


def pin() -> None:
    """Keeps this process and its children on one core, where the system permits it."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {CORE})


def cpu_time(command: list[str | Path], limit: int = 600) -> tuple[float, str]:
    """User and system time of a command, s, and its standard output; `limit` is the greatest time, s."""
    words = [str(word) for word in command]

    def limited() -> None:
        resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 1))
        if sys.platform == "linux":
            resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))

    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, preexec_fn=limited)
    text = process.stdout.read().decode()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    taken = usage.ru_utime + usage.ru_stime
    if process.returncode != 0:
        if taken >= limit - 1:
            raise TooSlow(" ".join(words))
        kind = Refused if process.returncode == REFUSAL else RuntimeError
        raise kind(f"{' '.join(words)}: exit code {process.returncode}")
    return taken, text


def alternate(measurements: dict[str, Callable[[], float]], rounds: int) -> dict[str, float]:
    """Least result of each measurement over all rounds; every second round has the reverse order."""
    least = dict.fromkeys(measurements, float("inf"))
    names = list(measurements)
    for number in range(rounds):
        for name in names if number % 2 == 0 else names[::-1]:
            least[name] = min(least[name], measurements[name]())
    return least
