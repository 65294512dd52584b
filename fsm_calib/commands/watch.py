"""`fsm-calib watch`: a page to look at a run while it runs, or to replay one that has ended."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Event
from typing import Annotated

import typer

from fsm_calib.errors import InputError
from fsm_calib.journal import JOURNAL_NAME


def register(app: typer.Typer) -> None:
    """Add `watch` to the command line."""
    app.command("watch")(watch)


def watch(
    directory: Annotated[Path, typer.Argument(metavar="DIR", help="The --out folder of a run.")],
    port: Annotated[
        int, typer.Option(min=0, max=65535, metavar="PORT", help="Port of the page; 0 for one that is free.")
    ] = 0,
    is_opened: Annotated[
        bool, typer.Option("--open/--no-open", help="Open the page in a browser (on a terminal only).")
    ] = True,
    mcap: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="Write the run as MCAP for Foxglove in place of a page.", show_default=False
        ),
    ] = None,
    foxglove: Annotated[
        int | None,
        typer.Option(
            metavar="PORT",
            help="Serve Foxglove in place of a page; it looks at 8765.",
            min=0,
            max=65535,
            show_default=False,
        ),
    ] = None,
) -> None:
    """Serve a page that shows a run, live or replayed, on this machine until Ctrl-C; or to Foxglove; or write MCAP."""
    from fsm_calib.watch.server import WatchServer

    if mcap is not None:
        from fsm_calib.watch.mcap_file import write_mcap

        typer.echo(f"{write_mcap(directory, mcap)} messages in {mcap}")
        return
    if directory.is_dir() and not (directory / JOURNAL_NAME).exists():
        cure = "Give the --out folder of a run that has begun."
        raise InputError("holds no run", where=str(directory), cure=cure)
    if foxglove is not None:
        serve_foxglove(directory, foxglove)
        return
    server = WatchServer(directory, port)
    server.start()
    tell(server.address, is_opened)
    try:
        Event().wait()
    except KeyboardInterrupt:
        typer.echo("", err=True)
    finally:
        server.close()


def serve_foxglove(directory: Path, port: int) -> None:
    """Serve a run to Foxglove until Ctrl-C."""
    from fsm_calib.watch.live import LiveView

    view = LiveView(directory, port)
    typer.echo(f"foxglove: {view.address}  (Ctrl-C ends it)", err=True)
    try:
        view.serve(Event())
    except KeyboardInterrupt:
        typer.echo("", err=True)
    finally:
        view.close()


def tell(address: str, is_opened: bool) -> None:
    """Say where the page is, and open it where somebody sits at a terminal."""
    typer.echo(f"watch: {address}  (Ctrl-C ends it)", err=True)
    if is_opened and sys.stderr.isatty():
        import webbrowser

        webbrowser.open(address)


@contextmanager
def watched(directory: Path, is_wanted: bool) -> Iterator[None]:
    """Serve the page of a run while the `with` block runs it; on a terminal the page stays until Ctrl-C.

    The stop button does what Ctrl-C does: the machine goes to `aborted`, the wheels to zero.
    """
    if not is_wanted:
        yield
        return
    from fsm_calib.watch.server import WatchServer

    server = WatchServer(directory, stop=lambda: os.kill(os.getpid(), signal.SIGINT))
    server.start()
    tell(server.address, is_opened=True)
    try:
        yield
        if sys.stderr.isatty():
            typer.echo("The page stays until Ctrl-C.", err=True)
            Event().wait()
    except KeyboardInterrupt:
        typer.echo("", err=True)
    finally:
        server.close()
