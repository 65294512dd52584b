"""The focus step (paper, chapter 6): the sharpness now and the best so far, for the person who turns the
lens.
"""

from __future__ import annotations

from fsm_calib.actions.bench import Bench
from fsm_calib.actions.looking import look
from fsm_calib.outcome import Outcome
from fsm_calib.perception.sharpness import sharpness


def measure_sharpness(bench: Bench) -> Outcome:
    """Take a frame and tell its sharpness and the best so far; sharp when near the best and above the
    least.
    """
    settings = bench.settings.camera
    if settings.skip_focus:
        return Outcome("focus_skipped", sentence="The focus step is skipped.")
    frame = look(bench)
    if isinstance(frame, Outcome):
        return frame
    value = sharpness(frame.image)
    bench.notebook.sharpness.append(value)
    best = max(bench.notebook.sharpness)
    sharp = value >= settings.least_sharpness and value >= settings.sharp_share * best
    if not sharp:
        bench.robot.wait(bench.settings.turn.settle)
    evidence = {"sharp": sharp, "sharpness": value, "best": best}
    return Outcome(
        "sharpness_measured",
        evidence,
        f"Sharpness {value:.3f}, best so far {best:.3f}.",
        "Turn the lens's ring.",
    )
