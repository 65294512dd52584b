"""How honest the standard deviations of `identify` are: simulated robots, and how often 90 % intervals hold the truth.

    python benchmarks/identify_coverage.py {displacement,wheels,position,command} [--seeds 100] [--first 0]

Each seed is another robot on another drive. The simulation integrates the kinematics in 2 ms steps and shares no code
with the fit but the definition of the quantities. The bar is 85 to 95 %.
"""

from __future__ import annotations

import argparse

import numpy as np

from fsm_calib.diagnosis.identify.identify import identify
from fsm_calib.recording import CommandTrack, DisplacementTrack, PoseTrack, Recording, RobotFacts, WheelPair

STEP = 0.002  # s
DURATION = 60.0  # s
INSIDE = 1.645  # standard deviations: 90 % of a normal distribution
RADIUS, AXLE, FULL_RATE = 0.0318, 0.1, 20.0  # a Duckiebot: m, m, rad/s at command 1
TICK = 2.0 * np.pi / 135.0  # rad


def robot(rng: np.random.Generator) -> dict[str, float]:
    """Draw a robot."""
    return {
        "left": RADIUS * rng.uniform(0.95, 1.05),
        "right": RADIUS * rng.uniform(0.95, 1.05),
        "axle_length": AXLE * rng.uniform(0.9, 1.1),
        "sensor.x": rng.normal(0.0, 0.02),
        "sensor.y": rng.normal(0.0, 0.02),
        "sensor.theta": rng.normal(0.0, 0.3),
        "tau_forward": rng.uniform(0.08, 0.2),
        "tau_turn": rng.uniform(0.08, 0.2),
    }


def displacement_drive(truth: dict[str, float], rng: np.random.Generator) -> Recording:
    """Return 300 intervals of 0.4 s, noise 1 mm and 4 mrad, 3 % outliers; exact by composing 3x3 transforms."""
    left, right = rng.uniform(-3.0, 10.0, (2, 300))
    rows = []
    sensor = transform(truth["sensor.x"], truth["sensor.y"], truth["sensor.theta"])
    for a, b in zip(left, right, strict=True):
        v = (truth["left"] * a + truth["right"] * b) / 2.0
        w = (truth["right"] * b - truth["left"] * a) / truth["axle_length"]
        angle = 0.4 * w
        move = transform(v / w * np.sin(angle), v / w * (1.0 - np.cos(angle)), angle)
        seen = np.linalg.inv(sensor) @ move @ sensor
        rows.append((seen[0, 2], seen[1, 2], np.arctan2(seen[1, 0], seen[0, 0])))
    measured = np.array(rows) + rng.normal(0.0, 1.0, (300, 3)) * [0.001, 0.001, 0.004]
    wild = rng.random(300) < 0.03
    measured[wild] += rng.normal(0.0, 1.0, (int(wild.sum()), 3)) * [0.03, 0.03, 0.1]
    lasts = np.full(300, 0.4)
    time = np.arange(300) * 0.4
    return Recording(
        RobotFacts("simulated", RADIUS, AXLE),
        wheel_rate=WheelPair(time, left, right, "rad/s", 0.0, lasts),
        displacement=DisplacementTrack(time, lasts, *measured.T),
    )


def transform(x: float, y: float, theta: float) -> np.ndarray:
    """Return a pose in the plane as a 3x3 matrix."""
    c, s = np.cos(theta), np.sin(theta)
    return np.array([[c, -s, x], [s, c, y], [0.0, 0.0, 1.0]])


def commands(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Return command times [s] and left, right commands, shape (n, 2), that hold for 0.4 to 1.6 s."""
    time = np.round(np.cumsum(rng.uniform(0.4, 1.6, 80)) / STEP) * STEP
    time = np.concatenate([[0.0], time[time < DURATION]])
    return time, rng.uniform(-0.3, 1.0, (len(time), 2))


def speeds(
    truth: dict[str, float], held: np.ndarray, rng: np.random.Generator, noisy: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Return forward speed and turn rate at every step: first order toward what is asked, with random pushes."""
    v, w = np.zeros(len(held)), np.zeros(len(held))
    pushes = rng.normal(0.0, np.sqrt(STEP), (len(held), 2)) * ([0.05, 0.4] if noisy else [0.0, 0.0])
    keep_v, keep_w = np.exp(-STEP / truth["tau_forward"]), np.exp(-STEP / truth["tau_turn"])
    left, right = truth["left"] * FULL_RATE * held[:, 0], truth["right"] * FULL_RATE * held[:, 1]
    asked_v, asked_w = (left + right) / 2.0, (right - left) / truth["axle_length"]
    for k in range(1, len(held)):
        v[k] = asked_v[k - 1] + (v[k - 1] - asked_v[k - 1]) * keep_v + pushes[k, 0]
        w[k] = asked_w[k - 1] + (w[k - 1] - asked_w[k - 1]) * keep_w + pushes[k, 1]
    return v, w


def tracked(
    truth: dict[str, float], v: np.ndarray, w: np.ndarray, rng: np.random.Generator, heading: bool
) -> PoseTrack:
    """Integrate by the trapezoidal rule and return what a tracker at 20 Hz sees: 3 mm, 10 mrad, 0.5 % outliers."""
    theta = 1.0 + np.concatenate([[0.0], np.cumsum((w[1:] + w[:-1]) / 2.0 * STEP)])
    middle, mean = (theta[1:] + theta[:-1]) / 2.0, (v[1:] + v[:-1]) / 2.0
    x = np.concatenate([[0.0], np.cumsum(mean * np.cos(middle) * STEP)])
    y = np.concatenate([[0.0], np.cumsum(mean * np.sin(middle) * STEP)])
    c, s = np.cos(theta), np.sin(theta)
    x, y = (
        x + c * truth["sensor.x"] - s * truth["sensor.y"],
        y + s * truth["sensor.x"] + c * truth["sensor.y"],
    )
    rows = np.arange(0, len(v), int(0.05 / STEP))
    x = x[rows] + rng.normal(0.0, 0.003, len(rows))
    y = y[rows] + rng.normal(0.0, 0.003, len(rows))
    x[rng.random(len(rows)) < 0.005] += 0.2
    angle = theta[rows] + truth["sensor.theta"] + rng.normal(0.0, 0.01, len(rows))
    return PoseTrack(rows * STEP, x, y, angle if heading else np.full(len(rows), np.nan))


def pose_drive(truth: dict[str, float], rng: np.random.Generator, kind: str) -> Recording:
    """Return a drive of 60 s with commands, or with encoders of 135 ticks at 30 Hz."""
    time, asked = commands(rng)
    steps = np.arange(0.0, DURATION, STEP)
    held = asked[np.searchsorted(time, steps, side="right") - 1]
    v, w = speeds(truth, held, rng, noisy=True)
    facts = RobotFacts("simulated", RADIUS, AXLE, FULL_RATE)
    if kind == "command":
        pose = tracked(truth, v, w, rng, heading=True)
        return Recording(facts, command=CommandTrack(time, asked[:, 0], asked[:, 1]), pose=pose)
    # the wheels roll as the robot moves; slip adds noise to the robot's motion, not to the wheels
    rates = [
        (v - w * truth["axle_length"] / 2.0) / truth["left"],
        (v + w * truth["axle_length"] / 2.0) / truth["right"],
    ]
    way = np.sqrt(np.maximum(np.abs(v), 1e-3) * STEP) / STEP
    slip_v, slip_w = rng.normal(0.0, 1.0, (2, len(v))) * way * [[0.001], [0.003]]
    pose = tracked(truth, v + slip_v, w + slip_w, rng, heading=kind == "wheels")
    angles = [np.concatenate([[0.0], np.cumsum((rate[1:] + rate[:-1]) / 2.0 * STEP)]) for rate in rates]
    rows = np.arange(0, len(v), int(0.034 / STEP))
    ticks = [np.floor(angle[rows] / TICK) * TICK for angle in angles]
    return Recording(facts, wheel_angle=WheelPair(rows * STEP, ticks[0], ticks[1], "rad", TICK), pose=pose)


def expected(truth: dict[str, float], kind: str) -> dict[str, float]:
    """Return the truth by the names of `identify`."""
    names = {"axle_length", "sensor.x", "sensor.y"} | ({"sensor.theta"} if kind != "position" else set())
    wanted = {name: truth[name] for name in names}
    for side in ("left", "right"):
        if kind == "command":
            wanted[f"speed_at_full_{side}"] = truth[side] * FULL_RATE
        else:
            wanted[f"wheel_radius_{side}"] = truth[side]
    return wanted | ({n: truth[n] for n in ("tau_forward", "tau_turn")} if kind == "command" else {})


def errors(kind: str, seed: int) -> dict[str, float]:
    """Return (estimate - truth) / standard deviation of every quantity for one robot; NaN where it was not told."""
    rng = np.random.default_rng(seed)
    truth = robot(rng)
    recording = displacement_drive(truth, rng) if kind == "displacement" else pose_drive(truth, rng, kind)
    found = identify([recording]).estimates
    result = {}
    for name, value in sorted(expected(truth, kind).items()):
        estimate = found[name]
        told = estimate.value is not None and estimate.sd
        result[name] = (estimate.value - value) / estimate.sd if told else np.nan  # type: ignore[operator]
    return result


def main() -> None:
    """Print how often the intervals hold the truth."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kind", choices=("displacement", "wheels", "position", "command"))
    parser.add_argument("--seeds", type=int, default=100)
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    arguments = parser.parse_args()
    seeds = range(arguments.first, arguments.first + arguments.seeds)
    rows = [errors(arguments.kind, seed) for seed in seeds]
    print(
        f"{arguments.kind}, {len(rows)} robots: quantity, share inside 90 %, mean and spread of error / sd, not told"
    )
    every = []
    for name in rows[0]:
        z = np.array([row[name] for row in rows])
        every.append(np.abs(z) < INSIDE)
        print(
            f"  {name:20s} {every[-1].mean():.2f}  {np.nanmean(z):+.2f}  {np.nanstd(z):.2f}  {int(np.isnan(z).sum())}"
        )
    print(f"  all together         {np.mean(every):.3f}")


if __name__ == "__main__":
    main()
