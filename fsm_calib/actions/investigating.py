"""What the robot does in an investigation: be seen, drive a plan, come back. What is thought about it is not here."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from itertools import pairwise
from statistics import median
from typing import Any

from fsm_calib.actions.bench import Bench
from fsm_calib.actions.floor_tracker import FloorTracker, PoseRow, unwound
from fsm_calib.actions.investigate_settings import InvestigateSettings
from fsm_calib.actions.notebook import Notebook
from fsm_calib.outcome import Outcome
from fsm_calib.perception.floor_map import SeenTag
from fsm_calib.ports import Tracker
from fsm_calib.types import STOP, WheelCommand

FEWEST = 3  # poses of which a median is taken
TICK = 0.004  # s: less is not worth a wait, and a robot's clock may not resolve it
REACH = 0.8  # m: longest single move back, over which a heading that is 0.2 rad wrong does not matter
RETURN_COMMAND = 0.25  # of moves back: slow enough for a tracker, fast enough for a dead zone
IN_THE_MIDDLE = 0.1  # m: nearer than that a move back changes nothing
OTHER_HEADING = 2.4  # rad, the golden angle: headings in a row lie far from one another
SMALLEST_RATE = 0.2  # of the nominal speed: a robot that moved less is taken for that fast
LOOK_TURN = 0.7  # rad between two looks for tags: less than half of what a fisheye sees
NOT_SEEN = {
    "tracker": "The tracker does not see the robot.",
    "camera": "The camera sees no floor marker of the drawing.",
}
NOMINAL_SPEED, NOMINAL_TURN = 0.6, 12.0  # m/s and rad/s at command 1 (DB18)


@dataclass(slots=True)
class Field:
    """One drive as it was made: commands (time, left, right), poses (time, x, y, theta), and the plan as JSON.

    seen : the floor markers that told each pose, where they were told by the robot's own camera.
    """

    commands: list[tuple[float, float, float]]
    poses: list[PoseRow]
    plan: dict[str, Any]
    cut: bool = False
    reached: float | None = None
    beliefs: list[tuple[str, float]] = field(default_factory=list)
    seen: list[tuple[SeenTag, ...]] = field(default_factory=list)


@dataclass(slots=True)
class Findings:
    """What an investigation knows: the pose, the next holds and their plan, drives, distance, and the answers.

    streak : judgements in a row that found the same names sure; names : of the last judgement. speed, turn : of the
    robot at command 1 [m/s, rad/s], learnt from moves back. spent : robot time [s]. designs : how often a drive was
    asked for. camera : where poses of the own camera lie on the robot, x, y [m], yaw [rad], and how late their stamps
    are [s], as diagnoses found it.
    """

    pose: tuple[float, float, float] | None = None
    holds: list[tuple[float, float, float]] = field(default_factory=list)
    plan: dict[str, Any] = field(default_factory=dict)
    drives: list[Field] = field(default_factory=list)
    distance: float = 0.0
    names: list[str] = field(default_factory=list)
    streak: int = 0
    speed: float = NOMINAL_SPEED
    turn: float = NOMINAL_TURN
    designs: int = 0
    spent: float = 0.0
    camera: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)

    def to_state(self) -> dict[str, Any]:
        """Return plain JSON values."""
        return asdict(self)

    @classmethod
    def from_state(cls, state: Mapping[str, Any]) -> Findings:
        """Return the findings that `to_state` wrote."""
        drives = [
            Field(
                [tuple(row) for row in d["commands"]], [tuple(row) for row in d["poses"]], d["plan"],
                d["cut"], d["reached"], [tuple(row) for row in d["beliefs"]],
                [tuple(tuple(tag) for tag in tags) for tags in d["seen"]],
            )
            for d in state["drives"]
        ]  # fmt: skip
        pose = tuple(state["pose"]) if state["pose"] else None
        holds = [tuple(hold) for hold in state["holds"]]
        camera = tuple(state["camera"])
        return cls(**{**state, "drives": drives, "pose": pose, "holds": holds, "camera": camera})


@dataclass(slots=True)
class InvestigationBench(Bench):
    """The bench of an investigation: the tracker, the settings, how far a point is from what ends the area [m]."""

    tracker: Tracker | None = None
    asked: InvestigateSettings = field(default_factory=InvestigateSettings)
    clearance: Callable[[float, float], float] = lambda x, y: math.inf
    findings: Findings = field(default_factory=Findings)

    def to_state(self) -> dict[str, Any]:
        """Return the checkpoint as plain JSON values."""
        return {"findings": self.findings.to_state(), "notebook": self.notebook.to_state()}

    def from_state(self, state: Mapping[str, Any]) -> None:
        """Take everything from a checkpoint."""
        self.findings = Findings.from_state(state["findings"])
        self.notebook = Notebook.from_state(state["notebook"])

    def seen(self) -> list[PoseRow]:
        """Return the tracker's poses since the last call."""
        return self.tracker.poses() if self.tracker is not None else []


def localise(bench: InvestigationBench) -> Outcome:
    """Stand still, and take the median of the tracker's poses."""
    asked = bench.asked
    bench.robot.command(STOP)
    bench.robot.wait(asked.settle)
    bench.seen()
    rows = _looked(bench, asked.settle)
    if len(rows) < FEWEST:
        return Outcome("pose_missing", {"poses": len(rows)}, NOT_SEEN[asked.poses])
    x, y = (median(row[k] for row in rows) for k in (1, 2))
    first = rows[0][3]
    theta = first + median(math.remainder(row[3] - first, math.tau) for row in rows)
    bench.findings.pose = (x, y, theta)
    room = bench.clearance(x, y) - asked.margin
    evidence = {"roomy": room >= asked.room, "x": x, "y": y, "theta": theta, "room": room}
    return Outcome("localised", evidence, f"The robot is at ({x:.2f} m, {y:.2f} m).")


def look_around(bench: InvestigationBench) -> Outcome:
    """Turn on the spot by a part of a turn where the robot looks for itself; wait where it is looked for."""
    if bench.asked.poses == "camera":
        u = min(RETURN_COMMAND, bench.asked.command)
        _hold(bench, WheelCommand(-u, u), LOOK_TURN / (u * bench.findings.turn))
    else:
        bench.robot.wait(bench.asked.settle)
    return Outcome("moved", {}, "Looked elsewhere.")


def return_step(bench: InvestigationBench) -> Outcome:
    """Turn towards the middle of the area and drive there; from what came of it learn how fast the robot is.

    A robot in the middle turns to another heading, from which other drives fit into the area.
    """
    findings, asked = bench.findings, bench.asked
    x, y, theta = findings.pose or (asked.centre_x, asked.centre_y, 0.0)
    way = math.hypot(asked.centre_x - x, asked.centre_y - y)
    azimuth = math.atan2(asked.centre_y - y, asked.centre_x - x)
    turn = math.remainder(azimuth - theta, math.tau) if way > IN_THE_MIDDLE else OTHER_HEADING
    backward = abs(turn) > 0.5 * math.pi and way > IN_THE_MIDDLE
    if backward:
        turn = math.remainder(turn + math.pi, math.tau)
    u = min(RETURN_COMMAND, asked.command)
    side = math.copysign(u, turn)
    _hold(bench, WheelCommand(-side, side), abs(turn) / (u * findings.turn))
    turned = _turned(bench, theta)
    if turned is not None and abs(turn) > 0.3:
        findings.turn *= min(max(abs(turned / turn), 0.5), 2.0)
    rest = abs(turn - (turned or turn))
    ahead = -u if backward else u
    if rest < 0.6 and way > IN_THE_MIDDLE:
        _hold(bench, WheelCommand(ahead, ahead), min(way, REACH) / (u * findings.speed))
    moved = _moved(bench, x, y)
    if moved is not None and rest < 0.6 and way > 0.2:
        findings.speed *= min(max(moved / min(way, REACH), 0.5), 2.0)
        findings.distance += moved
    findings.speed = max(findings.speed, SMALLEST_RATE * NOMINAL_SPEED)
    findings.turn = max(findings.turn, SMALLEST_RATE * NOMINAL_TURN)
    return Outcome("moved", {"way": way, "turn": turn}, "One move back towards the middle.")


def drive_plan(bench: InvestigationBench) -> Outcome:
    """Drive the plan and keep commands and poses; stop where the area ends, or when nobody sees the robot."""
    robot, findings, asked = bench.robot, bench.findings, bench.asked
    bench.seen()
    own = bench.tracker if isinstance(bench.tracker, FloorTracker) else None
    if own is not None:
        own.drained()
    made = Field([(robot.now(), 0.0, 0.0)], [], findings.plan)
    ended = ""
    for seconds, left, right in [(asked.settle, 0.0, 0.0), *findings.holds, (asked.settle, 0.0, 0.0)]:
        robot.command(WheelCommand(left, right))
        made.commands.append((robot.now(), left, right))
        ended = _watched(bench, made, seconds)
        if ended:
            break
    robot.command(STOP)
    made.commands.append((robot.now(), 0.0, 0.0))
    if ended == "edge":
        robot.wait(asked.settle)
        made.poses += bench.seen()
        made.cut = True
    if own is not None:
        made.poses, made.seen = unwound(made.poses, made.commands, findings.turn), own.drained()
    if ended == "blind" or len(made.poses) < FEWEST:
        return Outcome("pose_missing", {"poses": len(made.poses)}, "The tracker lost the robot on the drive.")
    findings.drives.append(made)
    findings.distance += _length(made.poses)
    evidence = {"seconds": made.poses[-1][0] - made.poses[0][0], "poses": len(made.poses)}
    if made.cut:
        return Outcome("drive_cut", evidence, "The drive was stopped at the edge of the area.")
    return Outcome("drive_finished", evidence, "The drive was made to its end.")


def _looked(bench: InvestigationBench, seconds: float) -> list[PoseRow]:
    """Let `seconds` [s] pass and return the poses of them.

    Where too few came, a camera whose frames come late is given up to `blind` [s].
    """
    begin, rows = bench.robot.now(), list[PoseRow]()
    while (left := begin + seconds - bench.robot.now()) > TICK:
        bench.robot.wait(min(left, bench.asked.look_every))
        rows += bench.seen()
    while 0 < len(rows) < FEWEST and bench.robot.now() < begin + bench.asked.blind:
        bench.robot.wait(bench.asked.look_every)
        rows += bench.seen()
    return rows


def _watched(bench: InvestigationBench, made: Field, seconds: float) -> str:
    """Let `seconds` [s] pass with an eye on the tracker; return why they ended early, empty when not.

    A look that took as long as the pause between two needs none.
    """
    begin, asked = bench.robot.now(), bench.asked
    end, looked = begin + seconds, begin
    while (left := end - bench.robot.now()) > TICK:
        pause = min(left, looked + asked.look_every - bench.robot.now())
        if pause > TICK:
            bench.robot.wait(pause)
        looked = bench.robot.now()
        made.poses += bench.seen()
        last = made.poses[-1][0] if made.poses else made.commands[0][0]
        if bench.robot.now() - last > asked.blind:
            return "blind"
        if made.poses and bench.clearance(*_ahead(made.poses, bench.robot.now())) < asked.stop_margin:
            return "edge"
    return ""


def _ahead(poses: list[PoseRow], now: float) -> tuple[float, float]:
    """Return where the robot is by now, going on as between its last two poses."""
    time, x, y, _ = poses[-1]
    if len(poses) < 2 or time - poses[-2][0] > 0.5:
        return x, y
    share = min((now - time) / max(time - poses[-2][0], 1e-3), 3.0)
    return x + share * (x - poses[-2][1]), y + share * (y - poses[-2][2])


def _hold(bench: InvestigationBench, command: WheelCommand, seconds: float) -> None:
    """Hold a command for at most 4 s, then stand."""
    bench.robot.command(command)
    bench.robot.wait(round(min(seconds, 4.0), 3))
    bench.robot.command(STOP)
    bench.robot.wait(bench.asked.settle)


def _turned(bench: InvestigationBench, before: float) -> float | None:
    """Return by how much the robot has turned [rad], None when nobody saw it."""
    rows = bench.seen()[-FEWEST:]
    return math.remainder(median(row[3] for row in rows) - before, math.tau) if rows else None


def _moved(bench: InvestigationBench, x: float, y: float) -> float | None:
    """Return how far the robot is from (x, y) [m], None when nobody saw it."""
    rows = bench.seen()[-FEWEST:]
    return math.hypot(rows[-1][1] - x, rows[-1][2] - y) if rows else None


def _length(poses: list[PoseRow]) -> float:
    """Return the length of a path [m] from poses a quarter of a second apart, so that noise adds little."""
    picked = poses[::4]
    return sum(math.hypot(b[1] - a[1], b[2] - a[2]) for a, b in pairwise(picked))


Deed = Callable[[InvestigationBench], Outcome]


def timed(deed: Deed) -> Deed:
    """Return a deed that adds its robot time to what was spent: a real robot's clock also runs while it is thought."""

    def done(bench: InvestigationBench) -> Outcome:
        begin = bench.robot.now()
        outcome = deed(bench)
        bench.findings.spent += bench.robot.now() - begin
        return outcome

    return done


ACTIVITIES: dict[str, Deed] = {
    "localise": timed(localise),
    "look_around": timed(look_around),
    "return_step": timed(return_step),
    "drive_plan": timed(drive_plan),
}
"""The activities of an investigation that a robot does, by name."""
