"""Reads MCAP logs that ROS 2's writer in Python wrote, in each compression, and compares the results with those of
the same numbers as CSV: `python mcap_logs.py PROGRAM`."""

import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

from mcap.writer import CompressionType
from mcap_ros2.writer import Writer

JOINT_STATE = """std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""
# A time since 1970, at which a double has no nanoseconds.
START = 1_700_000_000_123_456_789
STEP = 10_000_000
ROWS = 200


def position(k):
    return 1.0 + 0.5 * math.sin(0.02 * k)


def write_log(path, compression):
    with open(path, "wb") as file:
        writer = Writer(file, compression=compression)
        schema = writer.register_msgdef("sensor_msgs/msg/JointState", JOINT_STATE)
        for k in range(ROWS):
            time = START + k * STEP
            message = {
                "header": {"stamp": {"sec": time // 10**9, "nanosec": time % 10**9}, "frame_id": "base"},
                "name": ["A"],
                "position": [position(k)],
                "velocity": [],
                "effort": [0.5 * k],
            }
            writer.write_message("/joint_states", schema, message, log_time=time, publish_time=time, sequence=k)
        writer.finish()


def peaks(program, motion):
    run = [program, "inverse", "four-bar", "--motion", str(motion), "--json"]
    done = subprocess.run(run, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(run)} failed:\n{done.stderr}")
    return json.loads(done.stdout)["drives"]["A"]


def main():
    program = sys.argv[1]
    with tempfile.TemporaryDirectory() as folder:
        table = Path(folder, "motion.csv")
        rows = (f"{k * STEP * 1e-9!r},{position(k)!r}\n" for k in range(ROWS))
        table.write_text("time [s],A\n" + "".join(rows))
        expected = peaks(program, table)
        for compression in CompressionType:
            log = Path(folder, f"{compression.name}.mcap")
            write_log(log, compression)
            found = peaks(program, log)
            if found != expected:
                sys.exit(f"{compression.name}: {found}, as CSV {expected}")
            print(f"{compression.name}: the same results as CSV")


main()
