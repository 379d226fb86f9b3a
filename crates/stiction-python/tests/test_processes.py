"""Threads, processes, interruptions."""

import multiprocessing
import os
import signal
import subprocess
import sys
import textwrap
import threading
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest
from conftest import neighbours


def peak(m):
    return float(abs(m.inverse(step=0.1).efforts).max())


def row(m):
    q, v, a = neighbours(m, 300)
    return m.inverse_dynamics(q, v, a, threads=2).check().efforts.tobytes()


def test_python_threads_share_a_model(m):
    expected = row(m)
    with ThreadPoolExecutor(8) as pool:
        assert set(pool.map(row, [m] * 32)) == {expected}
        assert len(set(pool.map(peak, [m] * 8))) == 1


@pytest.mark.parametrize("method", ["fork", "spawn", "forkserver"])
def test_processes(m, method):
    if method not in multiprocessing.get_all_start_methods():
        pytest.skip(f"this system has no {method}")
    expected = row(m)  # Threads must have run before the fork.
    context = multiprocessing.get_context(method)
    with ProcessPoolExecutor(2, mp_context=context) as pool:
        assert set(pool.map(row, [m] * 4)) == {expected}
        assert set(pool.map(peak, [m] * 2)) == {peak(m)}


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork")
def test_a_fork_while_threads_compute(m):
    q, v, a = neighbours(m, 20_000)
    worker = threading.Thread(target=lambda: m.inverse_dynamics(q, v, a, threads=2))
    worker.start()
    time.sleep(0.01)
    child = os.fork()
    if child == 0:
        code = 1
        try:
            code = 0 if m.inverse_dynamics(q[:300], v[:300], a[:300], threads=2).ok else 1
        finally:
            os._exit(code)
    _, status = os.waitpid(child, 0)
    worker.join()
    assert status == 0


def test_other_threads_run_meanwhile(m):
    q, v, a = neighbours(m, 20_000)
    ticks = 0
    done = threading.Event()

    def tick():
        nonlocal ticks
        while not done.wait(0.002):
            ticks += 1

    thread = threading.Thread(target=tick)
    thread.start()
    start = time.perf_counter()
    m.inverse_dynamics(q, v, a)
    duration = time.perf_counter() - start
    done.set()
    thread.join()
    # Even on a busy machine, the other thread runs at least a tenth of its possible ticks.
    assert duration < 0.05 or ticks > 0.1 * duration / 0.002, (ticks, duration)


LONG = {
    "inverse": 'm.inverse("left_motor = 1e-3 rad*sin(t); right_motor = 1.5 rad; duration = 1e6 s", step=0.01)',
    "forward": "m.forward(until=1e6, step=0.01)",
    "states": "m.inverse_dynamics(np.tile(m.home(), (3_000_000, 1)), threads=2)",
}


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
@pytest.mark.parametrize("what", LONG)
def test_ctrl_c_stops_long_computations(what):
    code = f"""
    import numpy as np, signal, stiction, sys
    # A shell ignores the signal for commands in the background.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    m = stiction.load("five-bar")
    m.inverse_dynamics(m.home())
    print("begin", flush=True)
    try:
        {LONG[what]}
    except KeyboardInterrupt:
        print("interrupted")
    except stiction.Error as error:
        print(error)
    else:
        print("done")
    """
    run = subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(code)], stdout=subprocess.PIPE, text=True
    )
    assert run.stdout.readline() == "begin\n"
    time.sleep(1.0)
    run.send_signal(signal.SIGINT)
    try:
        output, _ = run.communicate(timeout=60)
    finally:
        run.kill()
    assert output == "interrupted\n"


def test_arrays_outlive_their_results(m):
    efforts = m.inverse(step=0.5).effort["leg1.P"]
    again = m.inverse(step=0.5).effort["leg1.P"]
    np.testing.assert_array_equal(efforts, again)
