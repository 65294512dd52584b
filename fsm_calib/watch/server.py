"""Serves the page of a run on this machine: files, events as they come (server-sent events), a stop button.

Standard library only. Every page has a thread of its own that reads the run's files; a page that takes nothing for
`PATIENCE` is let go and asks again by itself.
"""

from __future__ import annotations

import json
import re
import secrets
import time
from collections.abc import Callable
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.resources import files
from pathlib import Path
from threading import Thread
from typing import Any

from fsm_calib.errors import InputError
from fsm_calib.shipped import shipped_folder
from fsm_calib.watch.follow import Follower

LOOK_EVERY = 0.2
"""Time between two looks at the run's files for a page [s]."""
PATIENCE = 5.0
"""A page that takes nothing for so long is let go [s]."""
MOST_AT_ONCE = 200
"""Events sent at one time; a page that is further behind gets the newest and asks for the others."""
PAGES = {"/": "page.html", "/page.css": "page.css", "/page.js": "page.js", "/draw.js": "draw.js"}
KINDS = {".html": "text/html", ".css": "text/css", ".js": "text/javascript", ".svg": "image/svg+xml"}
KINDS |= {".jpg": "image/jpeg", ".json": "application/json"}
FRAME = re.compile(r"/frames/([\w-]+\.jpg)")
DIAGRAM = re.compile(r"/diagrams/([\w-]+\.svg)")


class WatchServer(ThreadingHTTPServer):
    """A web server for one run.

    Parameters
    ----------
    directory : Path
        The run's folder.
    port : int
        0 for any that is free.
    stop : callable or None
        What the stop button does; None where there is nothing to stop, and no button.
    host : str
        127.0.0.1 unless the user wants others to look.
    """

    daemon_threads = True

    def __init__(
        self, directory: Path, port: int = 0, stop: Callable[[], None] | None = None, host: str = "127.0.0.1"
    ) -> None:
        self.follower = Follower(directory)
        self.stop = stop
        self.token = secrets.token_urlsafe(16)
        self.ending = False
        try:
            super().__init__((host, port), _Handler)
        except OSError as error:
            raise InputError(f"cannot be served on: {error.strerror}", where=f"{host}:{port}") from error

    @property
    def address(self) -> str:
        """The page's address."""
        host, port = self.server_address[:2]
        return f"http://{host!s}:{port}/"

    def start(self) -> None:
        """Serve from a thread until `close`."""
        Thread(target=self.serve_forever, name="watch", daemon=True).start()

    def close(self) -> None:
        """Stop serving."""
        self.ending = True
        self.shutdown()
        self.server_close()

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Say nothing: a page that went away is no error of the run."""


class _Handler(BaseHTTPRequestHandler):
    """Answers one page's requests."""

    server: WatchServer
    timeout = PATIENCE
    protocol_version = "HTTP/1.1"

    def log_message(self, format: str, *args: Any) -> None:
        """Write no log: standard error belongs to the run."""

    def do_GET(self) -> None:
        """Send the page, a file of the run, or the stream of events."""
        path = self.path.split("?")[0]
        follower = self.server.follower
        if not self._is_local():
            self._send(b"", HTTPStatus.FORBIDDEN)
        elif path in PAGES:
            self._send_file(files("fsm_calib.watch").joinpath(PAGES[path]).read_bytes(), PAGES[path])
        elif path == "/favicon.ico":
            self._send(b"", HTTPStatus.NO_CONTENT)
        elif path == "/run.json":
            self._send_json(self._about())
        elif path == "/events.json":
            self._send_json(follower.read())
        elif path == "/pictures.json":
            self._send_json(follower.pictures())
        elif path == "/stream":
            self._stream()
        elif match := FRAME.fullmatch(path):
            self._send_path(follower.directory / "frames" / match[1])
        elif match := DIAGRAM.fullmatch(path):
            self._send_path(shipped_folder("diagrams") / match[1])
        else:
            self._send(b"", HTTPStatus.NOT_FOUND)

    def do_POST(self) -> None:
        """Stop the run, for a page that knows the token: no other site's page does."""
        known = secrets.compare_digest(self.headers.get("X-Token", ""), self.server.token)
        if self.path != "/stop" or self.server.stop is None or not known or not self._is_local():
            self._send(b"", HTTPStatus.FORBIDDEN)
            return
        self.server.stop()
        self._send(b"")

    def _is_local(self) -> bool:
        """Tell whether the page was asked for by the name it is served under, not by another site's (rebinding)."""
        host = self.headers.get("Host", "").rsplit(":", 1)[0]
        served = str(self.server.server_address[0])
        return served not in ("127.0.0.1", "::1") or host in ("127.0.0.1", "localhost", "[::1]")

    def _about(self) -> dict[str, Any]:
        """Return what the page asks first."""
        follower = self.server.follower
        about = follower.area() | {"folder": follower.directory.name, "result": follower.result()}
        return about | {"can_stop": self.server.stop is not None, "token": self.server.token}

    def _stream(self) -> None:
        """Send new events for as long as the page takes them; `Last-Event-ID` is the last one it has."""
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", "text/event-stream")
        self.send_header("Cache-Control", "no-store")
        self.send_header("Connection", "close")
        self.end_headers()
        sent, ended, last = int(self.headers.get("Last-Event-ID") or 0), False, time.monotonic()
        while not self.server.ending:
            events = self.server.follower.read()
            if len(events) < sent:
                self._push("again", {}, 0)
                return
            if len(events) > sent:
                news = {"from": max(sent, len(events) - MOST_AT_ONCE), "total": len(events)}
                self._push("events", news | {"events": events[news["from"] :]}, len(events))
                sent, last = len(events), time.monotonic()
            elif time.monotonic() - last > PATIENCE:
                self._push("alive", {}, sent)
                last = time.monotonic()
            result = self.server.follower.result()
            if result and not ended:
                self._push("result", result, sent)
                ended = True
            time.sleep(LOOK_EVERY)

    def _push(self, kind: str, data: Any, number: int) -> None:
        self.wfile.write(f"id: {number}\nevent: {kind}\ndata: {json.dumps(data)}\n\n".encode())
        self.wfile.flush()

    def _send_path(self, path: Path) -> None:
        if path.is_file():
            self._send_file(path.read_bytes(), path.name)
        else:
            self._send(b"", HTTPStatus.NOT_FOUND)

    def _send_json(self, data: Any) -> None:
        self._send_file(json.dumps(data).encode(), "x.json")

    def _send_file(self, content: bytes, name: str) -> None:
        self._send(content, HTTPStatus.OK, KINDS[Path(name).suffix])

    def _send(self, content: bytes, status: HTTPStatus = HTTPStatus.OK, kind: str = "text/plain") -> None:
        self.send_response(status)
        self.send_header("Content-Type", f"{kind}; charset=utf-8" if kind.startswith("text") else kind)
        self.send_header("Content-Length", str(len(content)))
        self.send_header("Cache-Control", "no-store")
        self.send_header("Content-Security-Policy", "default-src 'self'; style-src 'self' 'unsafe-inline'")
        self.end_headers()
        self.wfile.write(content)
