"""The camera's shutter: which scene is seen when, which frames arrive, and each frame's own noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fsm_calib.types import Frame, Pose2
from fsm_calib.world2d.camera import Renderer
from fsm_calib.world2d.faults import BlurredCamera, DroppedFrames, FrozenFrames
from fsm_calib.world2d.motion import Motion
from fsm_calib.world2d.sensor import SensorSettings, expose
from fsm_calib.world2d.spec import WorldSpec
from fsm_calib.world2d.stages import scene_stages
from fsm_calib.world2d.surfaces import Scene, build_scene

_SCENE_STREAM, _FRAME_STREAM, _DROP_STREAM = 2, 3, 4
_FROZEN_NUMBER = 2**40
"""Stands for the frame's number in the noise of a frozen picture; no run takes so many frames."""


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
            return Frame(self._picture(time, motion.recent, number), time, number)
        if self._frozen is None:
            when, poses = motion.frozen_view()
            self._frozen = self._picture(when, poses, _FROZEN_NUMBER)
        return Frame(self._frozen.copy(), time, number)
