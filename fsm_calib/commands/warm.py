"""`fsm-calib warm`: compile ahead what the other commands would compile when they are first used."""

from __future__ import annotations

import multiprocessing
import time

import typer

from fsm_calib.commands.options import EffectsOption
from fsm_calib.errors import FsmCalibError

SECONDS = 12.0
"""Length of a drive that is diagnosed to have the diagnosis compiled [s]: as short as it can be."""


class CompilerDied(FsmCalibError):
    """The process that compiles beside this one was ended from outside."""

    exit_code = 1


def register(app: typer.Typer) -> None:
    """Add `warm` to the command line."""
    app.command("warm")(warm)


def warm(effects: EffectsOption = None) -> None:
    """Compile the physics and the diagnosis now, once after an installation, so that no later command has to."""
    from fsm_calib.demo import drive_demo
    from fsm_calib.diagnosis.diagnose import diagnose
    from fsm_calib.diagnosis.identify.identify import identify
    from fsm_calib.world2d.ahead import compile_world

    begin = time.perf_counter()
    typer.echo("compiling the physics and the diagnosis, once for this installation ...", err=True)
    helper = multiprocessing.get_context("spawn").Process(target=compile_world)
    helper.start()
    drives = drive_demo(0, seconds=SECONDS)
    identify(drives.learned)
    helper.join()
    if helper.exitcode:
        raise CompilerDied(
            f"The process that compiles the roll-out ended with code {helper.exitcode}. Run `fsm-calib warm` "
            "again; the other commands compile what they need themselves."
        )
    diagnose(drives.learned, (drives.judged,))
    typer.echo(f"compiled in {time.perf_counter() - begin:.0f} s")
