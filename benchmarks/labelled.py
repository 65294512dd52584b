"""Real robots whose hidden effect their makers told: what `diagnose` says of each, beside what is true.

    python3 benchmarks/labelled.py [--only porto-optitrack] [--out FILE.json]

The recordings are not part of this repository (FSM_CALIB_SHARED, default ../shared). All recordings of a letter are
fitted together; `true` is what the folder's README calls true, names that may be said beside the labelled one included.
"""

from __future__ import annotations

import argparse
import json
import os
import time
from dataclasses import dataclass
from pathlib import Path

SHARED = Path(os.environ.get("FSM_CALIB_SHARED", Path(__file__).parents[2] / "shared"))


@dataclass(frozen=True)
class Letter:
    """One label: folder, letter, names that must be said, and names that may be said."""

    folder: str
    letter: str
    must: frozenset[str]
    may: frozenset[str]


def letter(folder: str, name: str, must: str = "", may: str = "") -> Letter:
    return Letter(folder, name, frozenset(must.split()), frozenset(may.split()) | frozenset(must.split()))


LETTERS = (
    letter("porto-optitrack", "k", "", "sensor_yaw sensor_offset"),
    letter("porto-optitrack", "m", "sensor_offset", "sensor_yaw"),
    letter("kobuki-wheels", "b", "observation_delay"),
    letter("kobuki-wheels", "c", "wheel_eccentricity", "observation_delay"),
    letter("husky-terrains", "a", "skid_steer", "observation_delay clock_drift"),
    letter("husky-terrains", "b", "skid_steer", "observation_delay clock_drift"),
    letter("warthog-floors", "a", "skid_steer", "observation_delay"),
    letter("warthog-floors", "e", "skid_steer", "observation_delay"),
)


def judged(case: Letter) -> dict[str, object]:
    """Return what the diagnosis says of one letter."""
    from fsm_calib.diagnosis.diagnose import diagnose
    from fsm_calib.errors import FsmCalibError
    from fsm_calib.recording import read_recording

    paths = sorted((SHARED / "recordings" / case.folder).glob(f"{case.letter}-*.recording.yaml"))
    began = time.perf_counter()
    try:
        verdict = diagnose([read_recording(str(path)) for path in paths]).verdict
    except FsmCalibError as error:
        return {"verdict": f"refused: {error}", "said": {}, "wrong": [], "missed": sorted(case.must)}
    said = {
        e.name: (e.confidence, {n: (p.value, p.sd, p.unit) for n, p in e.parameters.items()})
        for e in verdict.effects
    }
    sets = {name for group in verdict.ambiguous for name in group} | set(said)
    return {
        "verdict": verdict.verdict,
        "reason": verdict.reason,
        "said": said,
        "ambiguous": verdict.ambiguous,
        "wrong": sorted(name for name in said if name not in case.may),
        "missed": sorted(case.must - sets),
        "seconds": time.perf_counter() - began,
    }


def main() -> None:
    """Print a line for each letter."""
    from fsm_calib.report.digits import estimate

    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", help="one folder")
    parser.add_argument("--out", type=Path, help="write the answers as JSON")
    arguments = parser.parse_args()
    answers = {}
    for case in LETTERS:
        if arguments.only and case.folder != arguments.only:
            continue
        answer = answers[f"{case.folder} {case.letter}"] = judged(case)
        said = ", ".join(
            f"{name} {confidence:.2f} ({'; '.join(f'{n} {estimate(*told)}' for n, told in numbers.items())})"
            for name, (confidence, numbers) in answer["said"].items()  # type: ignore[attr-defined]
        )
        print(f"{case.folder} {case.letter}: {answer['verdict']}: {said or '-'}; wrong {answer['wrong']}, "
              f"missed {answer['missed']}", flush=True)  # fmt: skip
    if arguments.out:
        arguments.out.write_text(json.dumps(answers, indent=1, default=str))


if __name__ == "__main__":
    main()
