"""XML-RPC as ROS uses it: every answer is [code, message, value]; a master that does not answer is a lost link."""

from __future__ import annotations

import contextlib
import http.client
import socket
import threading
import xmlrpc.client
from socketserver import ThreadingMixIn
from typing import Any
from urllib.parse import urlsplit
from xmlrpc.server import SimpleXMLRPCRequestHandler, SimpleXMLRPCServer

from fsm_calib.errors import LinkLost

TIMEOUT = 10.0
"""Longest wait for an answer [s]: a master on a busy machine takes seconds."""


class _Transport(xmlrpc.client.Transport):
    """Connections that give up."""

    def make_connection(self, host: Any) -> http.client.HTTPConnection:
        """Return a connection with a timeout."""
        connection = super().make_connection(host)
        connection.timeout = TIMEOUT
        return connection


class Caller:
    """Calls one XML-RPC server, a master or another node; safe for threads.

    Parameters
    ----------
    url : str
        Where it listens.
    who : str
        What an error calls it.
    """

    def __init__(self, url: str, who: str) -> None:
        self.url, self._who = url, who
        self._lock = threading.Lock()
        self._proxy = xmlrpc.client.ServerProxy(url, transport=_Transport(), allow_none=True)

    def call(self, name: str, *arguments: Any) -> Any:
        """Return the value of a call.

        Raises
        ------
        LinkLost
            No answer, or one that says no.
        """
        cure = "Check that the robot is on, that its name resolves, and that both are in one network."
        try:
            with self._lock:
                code, message, value = getattr(self._proxy, name)(*arguments)  # type: ignore[misc]
        except (OSError, http.client.HTTPException, xmlrpc.client.Error, ValueError, TypeError) as error:
            raise LinkLost(f"{self._who} at {self.url} does not answer ({error})", cure=cure) from error
        if code != 1:
            raise LinkLost(f"{self._who} at {self.url} refuses {name}: {message}", cure=cure)
        return value


class _Handler(SimpleXMLRPCRequestHandler):
    """ROS clients call ``/`` or ``/RPC2``."""

    rpc_paths = ("/", "/RPC2")


class CallServer(ThreadingMixIn, SimpleXMLRPCServer):
    """An XML-RPC server in a daemon thread; every public method of `instance` can be called."""

    daemon_threads = True
    allow_reuse_address = True

    def __init__(self, host: str, port: int, instance: object) -> None:
        super().__init__((host, port), requestHandler=_Handler, logRequests=False, allow_none=True)
        self.register_instance(instance)
        self._ending = False
        self._thread = threading.Thread(target=self._serve, daemon=True, name="xmlrpc")
        self._thread.start()

    def _serve(self) -> None:
        """Answer one call after the other; between two nothing wakes up, which would hold up a message."""
        while not self._ending:
            self.handle_request()

    @property
    def port(self) -> int:
        """The port that it listens on."""
        return int(self.server_address[1])

    def close(self) -> None:
        """End it: a connection of our own wakes the thread that waits for one."""
        self._ending = True
        with contextlib.suppress(OSError):
            socket.create_connection((str(self.server_address[0]), self.port), timeout=TIMEOUT).close()
        self._thread.join(TIMEOUT)
        self.server_close()


def address_towards(url: str) -> str:
    """Return this machine's address on the way to `url`: the one by which a robot reaches us.

    Raises
    ------
    LinkLost
        The host's name does not resolve.
    """
    parts = urlsplit(url)
    try:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.connect((parts.hostname or "localhost", parts.port or 11311))
            return str(probe.getsockname()[0])
    except OSError as error:
        cure = "Check the name; NAME.local needs mDNS (libnss-mdns), else give the robot's number."
        raise LinkLost(f"{parts.hostname} cannot be reached ({error})", cure=cure) from error
