"""The camera's shutter: which scene is seen when, which frames arrive, and each frame's own noise."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fsm_calib.errors import InputError
from fsm_calib.types import Frame, Pose2
from fsm_calib.world2d.camera import Renderer
from fsm_calib.world2d.faults import (
    SCENE_FAULTS,
    BlurredCamera,
    DroppedFrames,
    Fault,
    FrozenFrames,
    MissingBoard,
    MissingMarkers,
    Obstacle,
)
from fsm_calib.world2d.scene import SceneSpec
from fsm_calib.world2d.sensor import SensorSettings, expose
from fsm_calib.world2d.surfaces import Scene, build_scene

if TYPE_CHECKING:
    from fsm_calib.world2d.robot import WorldSpec
    from fsm_calib.world2d.truth import Motion

_SCENE_STREAM, _FRAME_STREAM, _DROP_STREAM = 2, 3, 4
_FROZEN_NUMBER = 2**40
"""Stands for the frame's number in the noise of a frozen picture; no run takes so many frames."""


def _changed(scene: SceneSpec, fault: Fault, boards: tuple[int, ...]) -> tuple[SceneSpec, tuple[int, ...]]:
    """Return the scene after a fault, and the original numbers of the boards that are left."""
    if isinstance(fault, MissingBoard):
        if fault.board not in boards:
            raise InputError(
                f"there is no board {fault.board}", where="faults", cure=f"Boards: {list(boards)}."
            )
        place = boards.index(fault.board)
        return scene.without_board(place), boards[:place] + boards[place + 1 :]
    if isinstance(fault, MissingMarkers):
        return scene.without_markers(fault.numbers), boards
    if isinstance(fault, Obstacle):
        return scene.with_wall(fault.wall), boards
    return scene, boards


def scene_stages(spec: WorldSpec) -> list[tuple[float, SceneSpec]]:
    """Return the scene from each time [s] on, in order, the first from time 0."""
    scene, boards = spec.scene, tuple(range(len(spec.scene.boards)))
    stages = [(0.0, scene)]
    for fault in sorted((f for f in spec.faults if isinstance(f, SCENE_FAULTS)), key=lambda f: f.at):
        scene, boards = _changed(scene, fault, boards)
        stages.append((max(0.0, fault.at), scene))
    return stages


class Shutter:
    """Takes frames of the world's scene as it is at the time."""

    def __init__(self, spec: WorldSpec) -> None:
        self._spec = spec
        self._stages = scene_stages(spec)
        self._built: dict[int, tuple[Scene, Renderer]] = {}
        self._frozen: NDArray[np.uint8] | None = None
        self.count = 0

    def _stage(self, time: float) -> tuple[Scene, Renderer]:
        """Return the scene and its renderer at a time; the markers' places are the same in every stage."""
        number = max(i for i, (since, _) in enumerate(self._stages) if since <= time)
        if number not in self._built:
            rng = np.random.default_rng([self._spec.seed, _SCENE_STREAM])
            scene = build_scene(self._stages[number][1], rng)
            self._built[number] = scene, Renderer(scene, self._spec.robot.camera, self._spec.robot.mount)
        return self._built[number]

    def scene_at(self, time: float) -> Scene:
        """Return the scene as it is at `time` [s]."""
        return self._stage(time)[0]

    def _active(self, kind: type, time: float) -> list:
        return [fault for fault in self._spec.faults if isinstance(fault, kind) and fault.at <= time]

    def _optics(self, time: float) -> SensorSettings:
        blurred: list[BlurredCamera] = self._active(BlurredCamera, time)
        return replace(self._spec.optics, defocus=blurred[-1].defocus) if blurred else self._spec.optics

    def _picture(self, time: float, poses: list[Pose2], number: int) -> NDArray[np.uint8]:
        rng = np.random.default_rng([self._spec.seed, _FRAME_STREAM, number])
        light = self._stage(time)[1].light(poses)
        return expose(light, self._spec.robot.camera, self._optics(time), rng)

    def _is_dropped(self, time: float, number: int) -> bool:
        faults: list[DroppedFrames] = self._active(DroppedFrames, time)
        draw = np.random.default_rng([self._spec.seed, _DROP_STREAM, number]).random() if faults else 1.0
        return any(draw < fault.share for fault in faults)

    def capture(self, motion: Motion) -> Frame | None:
        """Return a frame whose exposure ends now, or None when it is dropped."""
        number, time = self.count, motion.time
        self.count += 1
        if self._is_dropped(time, number):
            return None
        if not self._active(FrozenFrames, time):
            return Frame(self._picture(time, list(motion.recent), number), time, number)
        if self._frozen is None:
            when, poses = motion.frozen_view()
            self._frozen = self._picture(when, poses, _FROZEN_NUMBER)
        return Frame(self._frozen.copy(), time, number)
