"""The same from Python: `fsm_calib.run`, `identify`, `diagnose`, `investigate`, `calibrate_camera`, and what they read.

Each takes paths or what was read from them, does what the command of its name does without printing, and returns an
answer with plain values in `json` (the command's `--json`) that shows itself as a table in a notebook. Wrong input is
an `InputError`, data that cannot answer a `DataError`, each with the place and the cure (`fsm_calib.errors`).
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fsm_calib.answers import Answer, CameraAnswer, DiagnosisAnswer, RunAnswer
from fsm_calib.recording import read_recording as read_recording
from fsm_calib.report import digits

if TYPE_CHECKING:
    from fsm_calib.recording.recording import Recording
    from fsm_calib.scenario.models import Scenario
    from fsm_calib.world2d.spec import WorldSpec


def load_world(scenario: str | Path) -> WorldSpec:
    """Return robot, area, start, sensor and faults of a scenario, for `fsm_calib.world2d.robot.make_world` to drive.

    Parameters
    ----------
    scenario : str or Path
        A YAML file, or the name of a shipped scenario.

    Raises
    ------
    InputError
        The file is no scenario; with ``file:line:column``.
    """
    from fsm_calib.scenario.world import world_of

    return world_of(_scenario(scenario))


def run(scenario: str | Path, out: str | Path = "out", *, seed: int | None = None) -> RunAnswer:
    """Calibrate a simulated robot as a scenario says: camera, wheels, lane.

    Parameters
    ----------
    scenario : str or Path
        A YAML file, or the name of a shipped scenario.
    out : str or Path
        The folder of the run's files; those of an earlier run are replaced.
    seed : int, optional
        In place of the scenario's own: another robot, other noise.

    Raises
    ------
    InputError
        The file is no scenario, or cannot be built.
    """
    from fsm_calib.report.run_report import run_report
    from fsm_calib.runner.run import run_scenario

    loaded = _scenario(scenario)
    if seed is not None:
        loaded = loaded.model_copy(update={"seed": seed})
    finished = run_scenario(loaded, Path(out), draw=run_report)
    result, rows = finished.result, [("outcome", str(finished.result["outcome"]))]
    camera, wheels = result.get("camera") or {}, result.get("wheels") or {}
    if camera.get("predicted_px") is not None:
        rows.append(("camera", f"{camera['predicted_px']:.2f} px predicted, {camera['views_used']} views"))
    if wheels.get("wheel_ratio") is not None:
        rows.append(("wheel ratio k", f"{wheels['wheel_ratio']:.4f} after {wheels['iterations']} iterations"))
    if result.get("failure"):
        rows.append(("failure", f"{result['failure']['reason']} {result['failure']['cure']}"))
    return RunAnswer(f"run of {loaded.name}", result, (*rows, ("files", str(out))), Path(out))


def identify(*recordings: str | Path | Recording) -> Answer:
    """Fit the base robot alone to recordings: radii, axle, gains, time constants, sensor pose, with deviations.

    Parameters
    ----------
    *recordings : str, Path or Recording
        Manifests, bags, .mcap files, or what `read_recording` returned; drives of one robot.

    Raises
    ------
    InputError, DataError
        A recording cannot be read, or tells nothing of the robot.
    """
    from fsm_calib.diagnosis.identify.identify import identify as identified
    from fsm_calib.diagnosis.identify.result import SENSOR, told_once

    loaded = _read(recordings)
    found = identified(loaded)
    plain = found.to_json()
    rows = [
        (name, _estimate(value)) for name, value in told_once(found, loaded).items() if name not in SENSOR
    ]
    return Answer(f"{plain['robot']}, from {plain['method']}", plain, tuple(rows))


def diagnose(
    recordings: Sequence[str | Path | Recording],
    holdout: Sequence[str | Path | Recording] = (),
    *,
    without: Sequence[str] = (),
    seed: int = 0,
    jobs: int = 1,
) -> DiagnosisAnswer:
    """Compare recordings with the simulation and say which physics it leaves out.

    Parameters
    ----------
    recordings : sequence of str, Path or Recording
        The drives that are fitted together.
    holdout : sequence of str, Path or Recording
        Drives that only judge the result.
    without : sequence of str
        Names to leave out of the catalogue.
    seed : int
        Of the significance test.
    jobs : int
        Fits side by side, in processes forked from this one; the answer does not depend on it.

    Raises
    ------
    InputError, DataError
        A recording cannot be read, or has too few poses or no commands.
    """
    from fsm_calib.diagnosis.diagnose import diagnose as diagnosed
    from fsm_calib.diagnosis.replay.settings import Settings

    settings = Settings(processes=jobs)
    found = diagnosed(_read(recordings), _read(holdout), without=without, settings=settings, seed=seed)
    plain = found.verdict.as_json()
    rows = [(e["name"], f"{e['sentence']} ({100 * e['confidence']:.0f} % sure)") for e in plain["effects"]]
    errors = plain["fit"]["holdout"] or plain["fit"]["train"]
    for key, words in (("before", "error before"), ("after", "error after"), ("floor", "noise alone")):
        if errors[key]["xy_m"] is not None:
            rows.append((words, f"{1e3 * errors[key]['xy_m']:.1f} mm after {plain['fit']['horizon_s']:g} s"))
    title = f"{plain['verdict']}: {plain['reason']}"
    return DiagnosisAnswer(title, plain, (*rows, ("next", plain["next_manoeuvre"])), found)


def investigate(
    scenario: str | Path, out: str | Path = "out", *, given: Sequence[str | Path | Recording] = ()
) -> RunAnswer:
    """Drive a simulated robot, diagnose, and design the next drive, until it is settled what is missing.

    Parameters
    ----------
    scenario : str or Path
        A YAML file, or the name of a shipped scenario.
    out : str or Path
        The folder of its files; those of an earlier run are replaced.
    given : sequence of str, Path or Recording
        Recordings of the robot that are there already.

    Raises
    ------
    InputError
        The file is no scenario, or its robot has no tracker.
    """
    from fsm_calib.commands.investigate import write_files
    from fsm_calib.runner.investigation.run import investigate as investigated

    going, result = investigated(_scenario(scenario), Path(out), given=_read(given))
    write_files(going, result, Path(out))
    rows = [(effect["name"], str(effect["sentence"])) for effect in result.get("effects", ())]
    rows += [("drives", str(len(result["drives"]))), ("files", str(out))]
    return RunAnswer(f"investigation: {result['ended']}", result, tuple(rows), Path(out))


def calibrate_camera(
    photos: Sequence[str | Path], columns: int, rows: int, square: float, *, kind: str = "chessboard"
) -> CameraAnswer:
    """Calibrate a camera from photos, folders or videos of one board.

    Parameters
    ----------
    photos : sequence of str or Path
        Files, folders or videos.
    columns : int
        As the board's makers count: inner corners, ChArUco's squares, tags or circles in a row.
    rows : int
        The same, in a column.
    square : float
        Side of a square or tag, pitch of circles [m].
    kind : str
        chessboard, charuco, aprilgrid, circles or asymmetric_circles.

    Raises
    ------
    InputError, DataError
        A file cannot be read or is of another size; too few photos show the board.
    """
    from fsm_calib.errors import UnknownNameError
    from fsm_calib.perception.camera_files import calibration_json
    from fsm_calib.perception.grid_boards import KINDS, BoardRequest
    from fsm_calib.perception.intrinsics import calibrate
    from fsm_calib.perception.photo_sources import photo_files
    from fsm_calib.perception.photos import find_in_photos
    from fsm_calib.perception.solve_settings import ANY_CAMERA

    named = next((one for one in KINDS if one == kind), None)
    if named is None:
        raise UnknownNameError("kind of board", kind, KINDS, where="kind")
    asked = BoardRequest(named, columns, rows, square)
    finder = None if named == "chessboard" else asked.finder()
    files = photo_files([Path(photo) for photo in photos])
    found = find_in_photos(files, asked.spec(), finder=finder)
    result = calibrate(found.views, asked.spec(), found.image_size, may_be_bent=True, settings=ANY_CAMERA)
    told = (
        ("lens model", result.camera.model),
        ("on views left out", f"{result.cross_validated_px:.3f} px"),
        ("predicted over the image", f"{result.predicted_px:.2f} px"),
        ("fx, fy", f"{result.camera.matrix[0, 0]:.2f}, {result.camera.matrix[1, 1]:.2f} px"),
        ("cx, cy", f"{result.camera.matrix[0, 2]:.2f}, {result.camera.matrix[1, 2]:.2f} px"),
    )
    title = f"refused: {result.reason}" if result.refused else f"camera from {result.views_used} views"
    return CameraAnswer(title, calibration_json(result), told, result)


def _scenario(path: str | Path) -> Scenario:
    from fsm_calib.scenario.load import load_scenario
    from fsm_calib.shipped import scenario_path

    return load_scenario(scenario_path(Path(path)))


def _read(given: Sequence[str | Path | Recording]) -> list[Recording]:
    return [read_recording(one) if isinstance(one, str | Path) else one for one in given]


def _estimate(value: dict[str, Any]) -> str:
    if value["value"] is None:
        return f"not told: {value['reason']}"
    return digits.estimate(value["value"], value["sd"], value["unit"])
