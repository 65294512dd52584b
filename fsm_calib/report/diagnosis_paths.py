"""What the report of a diagnosis draws: windows of error, states and paths of one recording, before and after."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fsm_calib.diagnosis.diagnose import Diagnosis
from fsm_calib.diagnosis.fitting.fit import Engine
from fsm_calib.diagnosis.proof.transfer import on_new_recording
from fsm_calib.diagnosis.proof.windows import Windows
from fsm_calib.diagnosis.replay.prepared import Prepared
from fsm_calib.recording.places import MANIFEST_END, MANIFEST_NAME
from fsm_calib.types import FloatArray

SEGMENT = (
    5.0  # s between fresh starts of a predicted path: long enough to see a drift, short enough to follow
)


@dataclass(frozen=True, eq=False)
class Drive:
    """One recording of a report.

    title; judged : it took no part in the fit; states : (start, end, name) spans [s, s]; before, after : errors over
    the horizon; path : (n, 3) measured x, y [m], theta [rad] at `time` (n,) [s]; paths_before, paths_after : lists of
    (m, 2) predicted x, y [m], each from a measured start; is_improved : effects were found, and after is not before.
    """

    title: str
    judged: bool
    placed: bool
    states: tuple[tuple[float, float, str], ...]
    before: Windows
    after: Windows
    time: FloatArray
    path: FloatArray
    paths_before: list[FloatArray]
    paths_after: list[FloatArray]
    is_improved: bool = True

    def track(self, most: int) -> list[list[float | None]]:
        """Return at most so many rows of time [s] and place x, y [m]; None where the place is not known."""
        kept = np.linspace(0, len(self.time) - 1, min(len(self.time), most)).round().astype(int)
        rows = np.column_stack([self.time[kept], self.path[kept, :2]]).round(3).tolist()
        return [row if self.placed else [row[0], None, None] for row in rows]

    def place_of(self, windows: Windows) -> FloatArray:
        """Return where the robot was at the end of each window, shape (w, 2) [m]."""
        return np.column_stack([np.interp(windows.time, self.time, self.path[:, i]) for i in range(2)])


def drives(diagnosis: Diagnosis) -> list[Drive]:
    """Return the recordings that were fitted, then those that were only predicted."""
    decision = diagnosis.decision
    found = []
    for run, simulator in enumerate(decision.engine.simulators):
        windows = diagnosis.train.windows_before[run], diagnosis.train.windows_after[run]
        steps = decision.base.simulated[run], decision.model.fit.simulated[run]
        found.append(_drive(simulator.prepared, windows, steps, judged=False))
    for run, simulator in enumerate(diagnosis.holdout_simulators):
        if diagnosis.holdout is None:
            break
        windows = diagnosis.holdout.windows_before[run], diagnosis.holdout.windows_after[run]
        after = on_new_recording(Engine((simulator,)), decision.model.fit)
        steps = simulator.increments(decision.base.values[:1])[0], simulator.increments(after)[0]
        found.append(_drive(simulator.prepared, windows, steps, judged=True))
    improved = bool(decision.model.effects)
    titles = titles_of([drive.title for drive in found])
    return [replace(d, title=title, is_improved=improved) for d, title in zip(found, titles, strict=True)]


def titles_of(sources: Sequence[str]) -> list[str]:
    """Return what recordings are called by where they lie: their file or folder, and where two share that, both."""
    short = [_file_or_folder(source) for source in sources]
    return [
        title if short.count(title) == 1 else "/".join(_parts(source)[-2:])
        for title, source in zip(short, sources, strict=True)
    ]


def _file_or_folder(source: str) -> str:
    *folders, last = _parts(source)
    return folders[-1] if last == MANIFEST_NAME and folders else last.replace(MANIFEST_END, "")


def _parts(source: str) -> list[str]:
    return source.replace("\\", "/").rstrip("/").split("/")


def _drive(
    p: Prepared, windows: tuple[Windows, Windows], steps: tuple[FloatArray, FloatArray], judged: bool
) -> Drive:
    return Drive(
        p.name, judged, p.poses.placed, state_spans(p), *windows, p.time, p.reference,
        predicted_paths(p, steps[0]), predicted_paths(p, steps[1]),
    )  # fmt: skip


def state_spans(p: Prepared) -> tuple[tuple[float, float, str], ...]:
    """Return the spans of the machine's states; none where none were recorded."""
    track = p.recording.state
    if track is None or not len(track):
        return ()
    ends = np.append(track.time[1:], max(float(p.time[-1]), float(track.time[-1])))
    return tuple((float(a), float(b), name) for a, b, name in zip(track.time, ends, track.path, strict=True))


def predicted_paths(p: Prepared, simulated: FloatArray) -> list[FloatArray]:
    """Chain simulated increments (n, 5) from the measured pose, afresh every `SEGMENT` [s] and after each gap."""
    paths: list[FloatArray] = []
    points: list[tuple[float, float]] = []
    x = y = theta = began = 0.0
    for k in range(len(p.time)):
        if k == 0 or p.restart[k] or p.time[k] - began > SEGMENT:
            if len(points) > 1:
                paths.append(np.array(points))
            x, y, theta = p.reference[k]
            began, points = p.time[k], [(x, y)]
            continue
        c, s = np.cos(theta), np.sin(theta)
        forward, left, turn = simulated[k, :3]
        x, y, theta = x + c * forward - s * left, y + s * forward + c * left, theta + turn
        points.append((x, y))
    return [*paths, np.array(points)] if len(points) > 1 else paths
