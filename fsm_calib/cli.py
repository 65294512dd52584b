"""The command line: `fsm-calib COMMAND`. Results on standard output, progress and errors on standard error.

Exit codes: 0 done; 1 the robot or the data failed, with the reason and the cure; 2 wrong use or bad input. A
`FsmCalibError` becomes its sentence, never a traceback, and so does what nobody foresaw (`main`). Rooms with heavy
libraries are imported inside the commands that need them, so that `--help` answers at once.
"""

from __future__ import annotations

import errno
import importlib
import os
import sys
import tempfile
import traceback
from pathlib import Path
from typing import Annotated, Any

import typer

from fsm_calib.commands.files import check_places, write_file
from fsm_calib.commands.help import WholeSentences
from fsm_calib.commands.machine import tell_checked
from fsm_calib.commands.options import EffectsOption, MachinesOption, machinery_of
from fsm_calib.commands.strangers import refuse_settings_of_others
from fsm_calib.errors import LONGEST_PART, FsmCalibError, InputError, shown
from fsm_calib.stops import Interrupted, on_stop_signals

COMMAND_MODULES: tuple[str, ...] = (
    "run",
    "robot",
    "machine",
    "recording",
    "camera",
    "extrinsics",
    "diagnosis",
    "effects",
    "investigate",
    "study",
    "fleet",
    "begin",
    "warm",
    "targets",
    "watch",
)
"""Modules of `fsm_calib.commands` with `register(app)`; each adds its commands to the command line."""

LINEAR_ALGEBRA_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")
"""Variables that every command sets to one thread unless the user has; numpy reads them when it is first imported.

The matrices here are small, so that threads gain nothing, and where the cores have other work they wait for each other
six times as long as one computes; how a sum is shared out among them changes its last digits, so that one seed would
give other digits on a machine with other cores.
"""

LARGEST_IMAGE = str(1 << 27)
"""Pixels of an image that OpenCV unpacks (134 million): a small file may otherwise take all memory."""


class Commands(WholeSentences):
    """A command group that turns this project's errors into one clear message and their exit code."""

    def invoke(self, ctx: Any) -> Any:
        """Run the chosen command."""
        try:
            refuse_settings_of_others(Path())
            return super().invoke(ctx)
        except FsmCalibError as error:
            typer.echo(f"fsm-calib: {error}", err=True)
            raise typer.Exit(error.exit_code) from error


app = typer.Typer(
    name="fsm-calib",
    cls=Commands,
    help="Robots that calibrate themselves, and simulations that know what they are missing.",
    no_args_is_help=True,
    add_completion=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _show_version(wanted: bool) -> None:
    """Print the version and stop."""
    if wanted:
        from importlib.metadata import version

        typer.echo(f"fsm-calib {version('fsm-calib')}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Robots that calibrate themselves, and simulations that know what they are missing."""


@app.command()
def validate(
    scenario: Annotated[
        Path | None,
        typer.Argument(
            metavar="FILE", help="A scenario, a study or a recording's manifest.", show_default=False
        ),
    ] = None,
    effects: EffectsOption = None,
    machines: MachinesOption = None,
) -> None:
    """Check a scenario, a study, a manifest or a machine: every error at once, each with file:line:column."""
    from fsm_calib.commands.manifests import is_recording, validate_manifest_command
    from fsm_calib.scenario.load import scenario_from
    from fsm_calib.scenario.yaml_source import read_yaml
    from fsm_calib.shipped import scenario_path
    from fsm_calib.study.load import is_study, study_from

    machinery = machinery_of(machines)
    if machines is not None:
        tell_checked(machinery, machines)
    elif scenario is None:
        raise InputError(
            "nothing to check",
            cure="Give a scenario, a study, a recording's manifest, or --machines FILE.py.",
        )
    if scenario is None:
        return
    if is_recording(scenario):
        validate_manifest_command(scenario)
        return
    document = read_yaml(scenario_path(scenario))
    if is_study(document):
        study = study_from(document)
        typer.echo(f"{scenario}: valid ({study.name}: a study of {study.robots} robots)")
        return
    loaded = scenario_from(document, machinery)
    typer.echo(f"{scenario}: valid ({loaded.name}: {', '.join(loaded.plan) or machinery.root.name})")


@app.command()
def schema(
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write to this file instead of standard output.")
    ] = None,
    study: Annotated[bool, typer.Option("--study", help="The schema of study files instead.")] = False,
    recording: Annotated[
        bool, typer.Option("--recording", help="The schema of recordings' manifests instead.")
    ] = False,
    effects: EffectsOption = None,
) -> None:
    """Print the JSON Schema of scenario files, of study files or of manifests, for editors."""
    from fsm_calib.recording.manifest_schema import manifest_schema_text
    from fsm_calib.scenario.schema import schema_text
    from fsm_calib.study.schema import study_schema_text

    if study and recording:
        raise InputError(
            "two schemas are asked for", where="--study", cure="Leave out --study or --recording."
        )
    check_places(out)
    text = manifest_schema_text() if recording else study_schema_text() if study else schema_text()
    if out is None:
        typer.echo(text, nl=False)
    else:
        write_file(out, text)


for _variable in LINEAR_ALGEBRA_THREADS:
    os.environ.setdefault(_variable, "1")
os.environ.setdefault("OPENCV_IO_MAX_IMAGE_PIXELS", LARGEST_IMAGE)
os.environ.setdefault("NUMBA_CACHE_DIR", "")  # beside its source: no file of a working directory has a say
os.environ.setdefault("OPENCV_LOG_LEVEL", "OFF")  # what is wrong with an image is said by our own sentence
for _module in COMMAND_MODULES:
    importlib.import_module(f"fsm_calib.commands.{_module}").register(app)


def main() -> None:
    """Run the command line; what nobody foresaw becomes a sentence too, with the details in a file of their own.

    ``FSM_CALIB_TRACEBACK=1`` shows the details instead. Calls of `app`, as tests make them, see the exception itself.
    """
    try:
        with on_stop_signals(Interrupted):
            app()
    except Interrupted as stopped:
        typer.echo(f"fsm-calib: {STOPPED.format(stopped)}", err=True)
        sys.exit(1)
    except Exception as error:
        if os.environ.get("FSM_CALIB_TRACEBACK"):
            raise
        code, sentence = _unforeseen(error)
        typer.echo(f"fsm-calib: {sentence}", err=True)
        sys.exit(code)


STOPPED = (
    "stopped by {} before the end. What is on disk is whole: a run goes on with --resume DIR, a study with the same "
    "command; anything else begins again."
)
FULL = (errno.ENOSPC, errno.EDQUOT, errno.EIO, errno.EMFILE, errno.ENFILE, errno.ENOMEM)
"""Errors of the machine, not of what the user asked for: exit code 1."""


def _unforeseen(error: Exception) -> tuple[int, str]:
    """Return the exit code and the sentence of an exception that no room turned into one."""
    if isinstance(error, OSError) and error.errno is not None:
        place = "" if error.filename is None else f"{shown(str(error.filename), LONGEST_PART)}: "
        cure = "Make room there, or" if error.errno in FULL else "Check its rights, or"
        return (1 if error.errno in FULL else 2), f"{place}{error.strerror}. {cure} give another place."
    if isinstance(error, MemoryError):
        return 1, "the memory does not suffice. Give less data at a time."
    said = shown(f"{type(error).__name__}: {error}", LONGEST_PART)
    try:
        handle, path = tempfile.mkstemp(prefix="fsm-calib-", suffix=".log")
        with os.fdopen(handle, "w", encoding="utf-8", errors="backslashreplace") as file:
            traceback.print_exception(error, file=file)
        details = f"The details are in {path}"
    except OSError:
        details = "FSM_CALIB_TRACEBACK=1 shows the details"
    return 2, f"this input is not foreseen ({said}). {details}; please report them with the input."


if __name__ == "__main__":
    main()
