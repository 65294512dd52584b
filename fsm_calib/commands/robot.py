"""`fsm-calib robot`: a simulated Duckiebot on a network, and an owner's first test of a real one."""

from __future__ import annotations

import contextlib
import threading
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from fsm_calib.commands.help import WholeSentences
from fsm_calib.commands.options import ScenarioArgument, SeedOption
from fsm_calib.errors import InputError, LinkLost

if TYPE_CHECKING:
    from fsm_calib.robots.address import RobotAddress
    from fsm_calib.robots.ros1.master import Master
    from fsm_calib.scenario.models import Scenario

robot_app = typer.Typer(
    cls=WholeSentences, no_args_is_help=True, help="Serve a simulated Duckiebot; check a real one."
)


def register(app: typer.Typer) -> None:
    """Add `robot` to the command line."""
    app.add_typer(robot_app, name="robot")


@robot_app.command()
def serve(
    scenario: ScenarioArgument,
    host: Annotated[str, typer.Option(metavar="HOST", help="Where to listen.")] = "127.0.0.1",
    port: Annotated[
        int | None,
        typer.Option(
            metavar="PORT", help="Port of the ROS master (11311) or switchboard (11511).", show_default=False
        ),
    ] = None,
    seed: SeedOption = None,
    lockstep: Annotated[
        bool, typer.Option("--lockstep", help="Let time pass only when a client asks for it.")
    ] = False,
    dtps: Annotated[
        bool, typer.Option("--dtps", help="Speak DTPS, as robots with ente do, in place of ROS 1.")
    ] = False,
) -> None:
    """Serve the scenario's simulated robot as a Duckiebot; `robot.serve` holds its delays and losses."""
    from fsm_calib.commands.run import read_scenario, with_seed
    from fsm_calib.robots.address import PORTS, RobotAddress
    from fsm_calib.runner.run import Stopped, stop_on_signals

    loaded = with_seed(read_scenario(scenario), seed)
    vehicle = (loaded.robot.vehicle or loaded.robot.name).replace("-", "_")
    kind: Literal["ros1", "dtps"] = "dtps" if dtps else "ros1"
    address = RobotAddress(kind, host, port or PORTS[kind], vehicle)
    with contextlib.ExitStack() as serving:
        own = (
            _serve_dtps(serving, loaded, address, lockstep)
            if dtps
            else _serve_ros1(serving, loaded, address, lockstep)
        )
        typer.echo(f"{vehicle} stands in {loaded.name}{own}. Drive it with:", err=True)
        typer.echo(f"fsm-calib run {scenario} --robot {address}")
        with contextlib.suppress(Stopped), stop_on_signals():
            threading.Event().wait()


def _serve_ros1(
    serving: contextlib.ExitStack, scenario: Scenario, address: RobotAddress, lockstep: bool
) -> str:
    """Begin to serve with ROS 1; return what to say of its master."""
    from fsm_calib.perception.encoded import encode_jpeg
    from fsm_calib.robots.ros1.served_node import ServedNode
    from fsm_calib.scenario.world import world_of
    from fsm_calib.world2d.robot import make_world

    master = _own_master(address.host, address.port)
    if master is not None:
        serving.callback(master.close)
    world, settings = make_world(world_of(scenario)), scenario.robot.serve.build()
    served = ServedNode(world, settings, address.url, address.vehicle, encode_jpeg, lockstep)
    serving.callback(served.close)
    return "" if master is None else " with its own ROS master"


def _serve_dtps(
    serving: contextlib.ExitStack, scenario: Scenario, address: RobotAddress, lockstep: bool
) -> str:
    """Begin to serve with DTPS; return what to say of its switchboard."""
    from fsm_calib.perception.encoded import encode_jpeg
    from fsm_calib.robots.dtps.served_node import DtpsServedNode
    from fsm_calib.scenario.world import world_of
    from fsm_calib.world2d.robot import make_world

    world, settings = make_world(world_of(scenario)), scenario.robot.serve.build()
    served = DtpsServedNode(
        world, settings, address.host, address.port, address.vehicle, encode_jpeg, lockstep
    )
    serving.callback(served.close)
    return " with its own switchboard"


@robot_app.command()
def check(
    robot: Annotated[
        str,
        typer.Option(metavar="ADDRESS", help="ros1:// or dtps://HOST[:PORT]/VEHICLE.", show_default=False),
    ],
    json_file: Annotated[
        Path | None, typer.Option("--json", metavar="FILE", help="Write the figures here, too.")
    ] = None,
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask before the wheels turn.")] = False,
) -> None:
    """Test a robot before its first run: camera, delays, least command, emergency stop. Its wheels turn a little."""
    import json

    from fsm_calib.commands.files import check_places, write_file
    from fsm_calib.perception.encoded import decode_image
    from fsm_calib.robots.address import parse_address
    from fsm_calib.robots.check import Check
    from fsm_calib.robots.guard.setup import GuardSetup
    from fsm_calib.runner.run import Stopped, stop_on_signals

    check_places(json_file)
    address = parse_address(robot)
    typer.echo("The robot will turn and move by some centimetres. Stand it on the floor.", err=True)
    if not yes and not typer.confirm("Start?", err=True):
        raise InputError("the check was not agreed to", where="--robot", cure="Answer y, or give --yes.")
    tested, findings = Check(GuardSetup(address), decode_image), []
    try:
        with stop_on_signals():
            for finding in tested.findings():
                findings.append(finding)
                typer.echo(f"{'good' if finding.good else 'BAD ':4s}  {finding.sentence}")
    except Stopped as stopped:
        typer.echo(f"fsm-calib: {stopped}", err=True)
        raise typer.Exit(1) from stopped
    finally:
        tested.close()
    if json_file is not None:
        write_file(json_file, json.dumps({item.name: item.value for item in findings}, indent=2) + "\n")
    bad = [finding for finding in findings if not finding.good]
    typer.echo(
        "The robot can calibrate itself." if not bad else f"{len(bad)} of {len(findings)} need a look first."
    )
    if bad:
        raise typer.Exit(1)


def _own_master(host: str, port: int) -> Master | None:
    """Return a master of our own where none answers."""
    from fsm_calib.robots.ros1.calls import Caller
    from fsm_calib.robots.ros1.master import Master

    try:
        Caller(f"http://{host}:{port}/", "the ROS master").call("getPid", "/fsm_calib")
    except LinkLost:
        return Master(host, port)
    return None
