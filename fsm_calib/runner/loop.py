"""The loop: run the active state's activity, journal its outcome, fire it, until the machine has ended.

Activities run outside the machine's callbacks, so that an event is complete before the next begins: whatever
kills the program, the journal holds whole events and the checkpoint says where to go on.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

from fsm_calib.actions.bench import Bench
from fsm_calib.errors import RobotLost
from fsm_calib.journal import Journal
from fsm_calib.outcome import Outcome
from fsm_calib.runner.gallery import Gallery
from fsm_calib.runner.logged import LoggedRobot
from fsm_calib.runner.parts import Parts
from fsm_calib.runner.progress import Observer
from fsm_calib.statechart.runtime import Fired, Machine

BETWEEN = "between"
"""The state between two phases."""
Activity = Callable[[Bench], Outcome]


@dataclass
class Run:
    """Everything that a run is made of, while it runs.

    Parameters
    ----------
    machine : Machine
        Where the run stands.
    bench : Bench
        What the activities share.
    robot : LoggedRobot
        The robot, with the log of what it was asked to do.
    journal : Journal
        Where events go.
    activities : mapping of str to callable
        The activities by name.
    pose : callable
        Returns the pose [x, y, theta] that a resumed run must reach again; no activity sees it.
    parts : Parts
        Where wall time is charged.
    observer : Observer
        Who watches.
    gallery : Gallery
        Where frames for the report go.
    heading : mapping
        What every checkpoint begins with: which scenario it belongs to.
    sequence : int
        Number of the next event.
    lost : RobotLost or None
        Why a real robot could not be driven any further.
    begun : dict
        What the present phase of a real robot began with; empty for a simulated one, which resumes at the last event.
    """

    machine: Machine
    bench: Bench
    robot: LoggedRobot
    journal: Journal
    activities: Mapping[str, Activity]
    pose: Callable[[], list[float]]
    parts: Parts
    observer: Observer
    gallery: Gallery
    heading: Mapping[str, Any]
    sequence: int = 0
    lost: RobotLost | None = None
    begun: dict[str, Any] = field(default_factory=dict)


def run_to_end(run: Run) -> None:
    """Run until the machine has ended; the wheels are at zero afterwards, also when an exception passes."""
    try:
        while run.machine.activity is not None:
            step(run)
    finally:
        with suppress(RobotLost):
            run.robot.stop()


def step(run: Run) -> None:
    """Do one event: activity, outcome, transition, journal line, checkpoint."""
    activity = run.machine.activity
    if activity is None:
        return
    before = run.machine.state
    run.bench.briefing = run.machine.briefing
    try:
        with run.parts.part("activities"):
            outcome = run.activities[activity](run.bench)
    except RobotLost as lost:
        run.lost = lost
        step_abort(run, lost_outcome(lost))
        return
    with run.parts.part("machines"):
        fired = run.machine.fire(outcome)
    with run.parts.part("journal"):
        keep_frames(run, before, outcome)
        record(run, activity, outcome, fired)
    phase = run.machine.books.phase
    run.observer.event(run.machine.state, phase, outcome, run.robot.now())


def lost_outcome(lost: RobotLost) -> Outcome:
    """Return the loss of a real robot as an outcome: it ends the run like the operator's wish."""
    return Outcome("abort", {"lost": type(lost).__name__}, f"{lost.problem}.", lost.cure)


def step_abort(run: Run, outcome: Outcome) -> None:
    """End the run at the operator's wish, or because the robot is lost.

    A journal line, but no checkpoint, so that it can still go on.
    """
    if run.machine.is_terminal:
        return
    with suppress(RobotLost):  # the guard has stopped the wheels, or nothing here can
        run.robot.stop()
    fired = run.machine.fire(outcome)
    run.journal.append(event_record(run, "", outcome, fired))
    run.observer.event(run.machine.state, "", outcome, run.robot.now())


def keep_frames(run: Run, path: str, outcome: Outcome) -> None:
    """Move the frames that the activity kept from memory to the disk."""
    for kept in run.bench.frames:
        run.gallery.add(kept, path, outcome.sentence)
    run.bench.frames.clear()


def record(run: Run, activity: str, outcome: Outcome, fired: Fired) -> None:
    """Write an event to the journal and replace the checkpoint; the end of a phase is made durable."""
    run.journal.append(event_record(run, activity, outcome, fired))
    run.sequence += 1
    state = {
        **run.heading,
        "sequence": run.sequence,
        "time": run.robot.now(),
        "frames": run.robot.frames,
        "state": run.machine.state,
        "books": run.machine.books.to_dict(),
        "bench": run.bench.to_state(),
        "gallery": run.gallery.to_state(),
        "seen_frames": run.bench.seen_frames,
    }
    if run.begun:
        if fired.dest == BETWEEN:
            run.begun = begun_of(run)
        state["begun"] = run.begun
    run.journal.checkpoint(state, durable=fired.dest.split("/")[0] != fired.source.split("/")[0])


def begun_of(run: Run) -> dict[str, Any]:
    """Return what a phase begins with: a real robot's run goes on from there, not in the middle of a phase."""
    return {"state": run.machine.state, "books": run.machine.books.to_dict(), "bench": run.bench.to_state()}


def event_record(run: Run, activity: str, outcome: Outcome, fired: Fired) -> dict[str, Any]:
    """Return an event as the journal keeps it; times are the robot's, never the wall's."""
    return {
        "seq": run.sequence,
        "tick": run.machine.books.ticks,
        "time": run.robot.now(),
        "phase": run.machine.books.phase,
        "board": run.machine.briefing.get("board"),
        "path": fired.source,
        "activity": activity,
        "trigger": fired.trigger,
        "guards": dict(fired.guards),
        "actions": list(fired.actions),
        "dest": fired.dest,
        "evidence": dict(outcome.evidence),
        "sentence": outcome.sentence,
        "cure": outcome.cure,
        "commands": [list(command) for command in run.robot.drain()],
        "frames": run.robot.frames,
        "pose": run.pose(),
    }
