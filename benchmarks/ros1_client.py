"""What it costs to receive a camera over ROS 1: this project's own node beside rospy, in one run.

    python benchmarks/ros1_client.py --seconds 30

Debian's master; one publisher (this project's) sends a frame of 48 kB thirty times a second; both clients listen to it at
the same time, each a process of its own, in turn the first that is served. rospy runs under Debian's python3 (apt-get install
ros-core python3-sensor-msgs). Latency is from the stamp, just before sending, to the listener's call with the image's bytes at hand; the cost is the
processor time of the client's whole process after its first frame.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from ros_rig import debian_master, until

from fsm_calib.robots.ros1.messages import IMAGE, message_type, stamp_of
from fsm_calib.robots.ros1.node import Node

TOPIC = "/duckie/camera_node/image/compressed"
RATE, SIZE = 30.0, 48_307
ROSPY = """
import sys, time, json, rospy
from sensor_msgs.msg import CompressedImage
rows, busy = [], []
def hear(message):
    rows.append(time.time() - message.header.stamp.to_sec())
    busy.append(time.process_time())
    len(message.data)
rospy.init_node("rospy_client", disable_signals=True)
rospy.Subscriber("{topic}", CompressedImage, hear, queue_size=1, buff_size=2**24, tcp_nodelay=True)
sys.stdin.readline()
print(json.dumps([rows, busy[-1] - busy[0]]), flush=True)
"""


def own_client(master: str) -> None:
    """Listen as the program does, until a line comes on standard input; print latencies and processor time."""
    rows: list[float] = []
    busy: list[float] = []
    kind = message_type(IMAGE)

    def hear(body: bytes) -> None:
        message = kind.decode(body)
        data = np.asarray(message.data).tobytes()
        rows.append(time.time() - stamp_of(message))
        busy.append(time.process_time())
        len(data)

    node = Node("/own_client", master)
    node.subscribe(TOPIC, IMAGE, hear)
    sys.stdin.readline()
    print(json.dumps([rows, busy[-1] - busy[0]]), flush=True)
    node.close()


def started(command: list[str], master: str) -> subprocess.Popen[str]:
    """Start a client."""
    environment = {**os.environ, "ROS_MASTER_URI": master, "ROS_HOSTNAME": "127.0.0.1"}
    if command[0] != sys.executable:
        environment.pop("PYTHONPATH", None)
    return subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment
    )


def publish(master: str, seconds: float, listeners: int) -> int:
    """Publish frames for `seconds` [s] once all listen; return how many."""
    node, kind = Node("/publisher", master), message_type(IMAGE)
    publisher = node.publish(TOPIC, IMAGE)
    until(lambda: len(publisher.listeners) >= listeners, "all clients listen")
    data = np.random.default_rng(1).integers(0, 256, SIZE, dtype=np.uint8)
    begin, sent = time.monotonic(), 0
    while (now := time.monotonic() - begin) < seconds:
        time.sleep(max(sent / RATE - now, 0.0))
        publisher._links.reverse()  # in turn: who is served second waits for the first
        publisher.publish(kind.stamped(time.time(), sent, format="jpeg", data=data))
        sent += 1
    time.sleep(1.0)
    node.close()
    return sent


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=30.0)
    parser.add_argument("--own", default="", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.own:
        own_client(given.own)
        return
    with debian_master() as master:
        clients = {
            "own": started([sys.executable, __file__, "--own", master], master),
            "rospy": started(["/usr/bin/python3", "-c", ROSPY.replace("{topic}", TOPIC)], master),
        }
        sent = publish(master, given.seconds, len(clients))
        print(f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores; {sent} frames of {SIZE} bytes")
        for name, client in clients.items():
            latencies, busy = json.loads(client.communicate("end\n", timeout=60.0)[0])
            p50, p90, p99 = (1e3 * float(q) for q in np.quantile(latencies, (0.5, 0.9, 0.99)))
            print(
                f"{name:6s} latency {p50:6.2f} / {p90:6.2f} / {p99:6.2f} ms (p50 / p90 / p99),"
                f" lost {sent - len(latencies)}, {100.0 * busy / given.seconds:.2f} % of a core"
            )


if __name__ == "__main__":
    main()
