"""The scene over time: faults that take away boards or markers or put up a wall change it."""

from __future__ import annotations

from fsm_calib.errors import InputError
from fsm_calib.world2d.faults import SCENE_FAULTS, Fault, MissingBoard, MissingMarkers, Obstacle
from fsm_calib.world2d.scene import SceneSpec
from fsm_calib.world2d.spec import WorldSpec


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
