"""The wheels of a Duckiebot with ROS 1: commands out, acknowledgements, encoders and stops in."""

from __future__ import annotations

import math
import os
import socket
import threading
import time
from queue import Queue

from fsm_calib.errors import EmergencyStopped, LinkLost
from fsm_calib.robots.address import RobotAddress
from fsm_calib.robots.guard.outlet import Event
from fsm_calib.robots.ros1.messages import BOOL, TEXT, TICK, WHEELS, message_type
from fsm_calib.robots.ros1.node import Node
from fsm_calib.robots.ros1.publisher import Publisher
from fsm_calib.robots.ros1.subscriber import Listener
from fsm_calib.robots.ros1.topics import OTHER_DRIVERS, Topics
from fsm_calib.robots.stepper import Stepper
from fsm_calib.types import WheelCommand

CONNECT = 10.0
"""Longest wait for the wheel driver to connect to us [s]."""
STEPS = 60.0
"""Longest wait for a served robot in lockstep to be connected [s]."""
PROGRAM_NAME = "fsm_calib"
"""The program's node, which can put the wheels to zero when its guard dies."""
GUARD_NAME = "fsm_calib_guard"


class Ros1Outlet:
    """A node that publishes wheel commands and listens to what becomes of them.

    Raises
    ------
    LinkLost
        No master, or no wheel driver that connects to us.
    EmergencyStopped
        Another node publishes wheel commands.
    """

    def __init__(self, address: RobotAddress, inbox: Queue[Event]) -> None:
        self._inbox, self._topics, self._seq = inbox, Topics(address.vehicle), 0
        self._node = Node(f"/{address.vehicle}/{GUARD_NAME}_{os.getpid()}", address.url)
        try:
            self.check_alone()
            self._publisher = self._node.publish(self._topics.wheels, WHEELS)
            self._listen()
            self._wait_for_driver()
        except BaseException:
            self._node.close()
            raise
        threading.Thread(target=self._watch_master, args=(address,), daemon=True).start()

    def _listen(self) -> None:
        """Hear acknowledgements, encoders and stops."""
        wheels, topics = message_type(WHEELS), self._topics

        def executed(body: bytes) -> None:
            message = wheels.decode(body)
            command = WheelCommand(float(message.vel_left), float(message.vel_right))
            self._inbox.put(("executed", command, int(message.header.seq)))

        def stopped(body: bytes) -> None:
            if message_type(BOOL).decode(body).data:
                self._inbox.put(("estop", "The emergency stop was pressed"))

        self._node.subscribe(topics.executed, WHEELS, executed, self._lost)
        for side, topic in (("left", topics.left_tick), ("right", topics.right_tick)):
            self._node.subscribe(topic, TICK, self._encoder(side))
        for topic in (topics.emergency_stop, topics.estop):
            self._node.subscribe(topic, BOOL, stopped)

    def _encoder(self, side: str) -> Listener:
        """Return the listener of one wheel's encoder."""

        def ticked(body: bytes) -> None:
            message = message_type(TICK).decode(body)
            self._inbox.put(("angle", side, message.data * 2.0 * math.pi / max(message.resolution, 1)))

        return ticked

    def _lost(self) -> None:
        self._inbox.put(("lost", "The wheel driver has gone"))

    def _wait_for_driver(self) -> None:
        """Wait until the driver listens to us: what is sent before is lost.

        Raises
        ------
        LinkLost
            It does not connect.
        """
        end = time.monotonic() + CONNECT
        while not self._publisher.listeners:
            if time.monotonic() > end:
                raise LinkLost(
                    f"no wheel driver has connected to {self._node.uri} within {CONNECT:g} s",
                    cure="Check that the robot's wheel driver runs, and that no firewall here blocks it; ROS_IP "
                    "tells the robot another address of this computer.",
                )
            time.sleep(0.02)

    def send(self, command: WheelCommand) -> None:
        """Publish a command; nobody to take it is a lost link."""
        self._seq += 1
        message = message_type(WHEELS).stamped(
            time.time(), self._seq, vel_left=command.left, vel_right=command.right
        )
        if self._publisher.publish(message) == 0:
            self._inbox.put(("lost", "The wheel driver's connection has ended"))

    def check_alone(self) -> None:
        """Refuse when another node publishes wheel commands.

        Raises
        ------
        EmergencyStopped
            It does; with its name.
        """
        mine = f"/{self._topics.vehicle}/"
        known = {mine + name for name in OTHER_DRIVERS}
        known |= {self._node.name, f"{mine}{PROGRAM_NAME}_{os.getppid()}"}
        publishers = self._node.publishers_of(self._topics.wheels)
        others = [name for name in publishers if name not in known and self._node.is_alive(name)]
        if others:
            names = ", ".join(others)
            raise EmergencyStopped(
                f"{names} publishes wheel commands too",
                cure=f"End it first, for instance: rosnode kill {names}.",
            )

    def _watch_master(self, address: RobotAddress) -> None:
        """Hold a connection to the master: its end is the master's."""
        try:
            with socket.create_connection((address.host, address.port), timeout=3.0) as link:
                link.settimeout(None)
                link.recv(1)
        except OSError:
            pass  # an end as good as any
        self._inbox.put(("lost", "The ROS master has gone"))

    @property
    def sent(self) -> int:
        """Commands sent so far."""
        return self._publisher.sent

    def stepper(self) -> Stepper:
        """Return what lets a served robot's time pass; see `guard.outlet.Outlet`.

        Raises
        ------
        LinkLost
            Nobody serves steps.
        """
        node, topics, text = self._node, self._topics, message_type(TEXT)
        asking = node.publish(topics.step, TEXT)
        stepper = Stepper(lambda question: _ask(asking, question))
        node.subscribe(topics.stepped, TEXT, lambda body: stepper.hear(text.decode(body).data))
        end = time.monotonic() + STEPS
        heard = (topics.stepped, topics.executed)
        while not (asking.listeners and all(node.subscribers[topic].connected for topic in heard)):
            if time.monotonic() > end:
                cure = "Start it with: fsm-calib robot serve --lockstep"
                raise LinkLost("the robot serves no steps", cure=cure)
            time.sleep(0.01)
        return stepper

    def close(self) -> None:
        """Leave the graph."""
        self._node.close()


def _ask(publisher: Publisher, question: str) -> None:
    """Publish a question of a stepper."""
    publisher.publish(message_type(TEXT).make(data=question))
