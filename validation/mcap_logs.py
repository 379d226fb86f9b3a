"""Exchanges MCAP logs with other programs: `python mcap_logs.py PROGRAM`.

Logs that ROS 2's writer in Python wrote, in each compression, must give the results of the same numbers as CSV.
Logs of `inverse` and `forward` must have the numbers of their tables for the MCAP reader in Python.
"""

import csv
import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

from mcap.reader import make_reader
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


def columns(path):
    """Columns of a table by header without unit."""
    with open(path, newline="") as file:
        rows = list(csv.reader(file))
    headers = [header.split(" [")[0] for header in rows[0]]
    return {header: [float(row[k]) for row in rows[1:]] for k, header in enumerate(headers)}


def rotated(q, point):
    """The point turned by the unit quaternion `q`, real part first."""
    w, u = q[0], q[1:]
    cross = lambda a, b: [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    t = [2 * x for x in cross(u, point)]
    return [p + w * x + y for p, x, y in zip(point, t, cross(u, t))]


def check_written_log(program, command, tables):
    """Compares the log of a run with its tables."""
    with tempfile.TemporaryDirectory() as folder:
        run = [program, *command, "-o", folder, "--format", "csv,mcap", "--report", "off"]
        subprocess.run(run, check=True, capture_output=True)
        joints, efforts = (columns(Path(folder, name)) for name in tables)
        bodies = columns(Path(folder, "bodies.csv"))
        states = updates = 0
        # Points of each body in its frame, from the first message: they must not change.
        fixed = {}
        with open(Path(folder, f"{command[0]}.mcap"), "rb") as file:
            for schema, channel, message in make_reader(file).iter_messages():
                assert schema.encoding == "jsonschema" and json.loads(schema.data)["title"] == schema.name
                value = json.loads(message.data)
                if channel.topic == "/joint_states":
                    stamp = value["timestamp"]
                    time = stamp["sec"] + stamp["nsec"] * 1e-9
                    assert abs(time - joints["time"][states]) <= 1e-9 and message.log_time == round(time * 1e9)
                    assert value["joints"], "no joints"
                    for joint in value["joints"]:
                        name = joint["name"]
                        assert joint["position"] == joints[f"{name}.position"][states]
                        assert joint["velocity"] == joints[f"{name}.rate"][states]
                        assert joint["acceleration"] == joints[f"{name}.acceleration"][states]
                        drive = efforts.get(f"{name}.drive")
                        assert ("effort" in joint) == (drive is not None)
                        assert drive is None or joint["effort"] == drive[states]
                    states += 1
                    continue
                assert channel.topic == "/scene" and schema.name == "foxglove.SceneUpdate"
                for entity in value["entities"]:
                    name = entity["id"]
                    if f"{name}.x" not in bodies:
                        assert not entity["lines"], "the ground has lines"
                        continue
                    q = [bodies[f"{name}.q{part}"][updates] for part in "wxyz"]
                    place = [bodies[f"{name}.{part}"][updates] for part in "xyz"]
                    inverse = [q[0], -q[1], -q[2], -q[3]]
                    for k, ball in enumerate(entity["spheres"]):
                        point = [ball["pose"]["position"][part] for part in "xyz"]
                        local = rotated(inverse, [a - b for a, b in zip(point, place)])
                        known = fixed.setdefault((name, k), local)
                        assert max(abs(a - b) for a, b in zip(known, local)) < 1e-12, (name, k)
                updates += 1
        assert states == updates == len(joints["time"]) > 2 and fixed
        print(f"{' '.join(command)}: {states} rows, all numbers those of the tables")


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
    for model in ["3rps", "delta", "five-bar"]:
        check_written_log(program, ["inverse", model], ["joints.csv", "inverse.csv"])
    check_written_log(program, ["forward", "3rps", "--until", "0.1"], ["forward.csv", "forward.csv"])


main()
