"""Make the concealed robots: recordings for everyone, a sealed key for nobody.

    python3 benchmarks/concealed/generate.py OUT --robots 400 --seed 1

writes OUT/robots/robot-NNN/{run-a,run-b,run-h}/ in the form fsm-calib/recording@1, OUT/key.sealed and OUT/key.sha256.
The key is enciphered with a passphrase that goes to OUT-vault/passphrase (outside OUT), so that a process that is
handed OUT/robots can read no label. Development sets are made with another seed and `--open` (the key in plain text).
"""

from __future__ import annotations

import argparse
import gzip
import hashlib
import json
import secrets
import sys
from pathlib import Path

import numpy as np
from joblib import Parallel, delayed

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from concealed.drives import Drive, make_drive
from concealed.physics import simulate
from concealed.robots import BY_NAME, HIDDEN, OUTSIDE, PAIRS, Sensor, draw_base, draw_sensor, observe
from concealed.sizing import floor, ratio

RUNS = ("run-a", "run-b", "run-h")
LEVELS = {"plain": (1.5, 2.5), "masked": (1.1, 1.5), "faint": (1.02, 1.10)}
"""2 s error of the re-fitted base over the noise floor."""
CLEAN = {"names": [], "level": "none"}
"""The row of a robot that hides nothing."""


def plan(count: int, seed: int) -> list[dict]:
    """Return what each robot will hide, in an order that tells nothing: 65 % one effect, the rest controls."""
    rng = np.random.default_rng([seed, 1])
    single = round(0.65 * count)
    names = [h.name for h in HIDDEN]
    rows = [
        {"names": [names[i % len(names)]], "level": list(LEVELS)[i // len(names) % 3]} for i in range(single)
    ]
    rows += [CLEAN] * round(0.15 * count)
    rows += [
        {"names": [OUTSIDE[i % len(OUTSIDE)].name], "level": ["plain", "plain", "masked"][i % 3]}
        for i in range(round(0.08 * count))
    ]
    rows += [{"names": list(PAIRS[i % len(PAIRS)]), "level": "plain"} for i in range(round(0.08 * count))]
    while len(rows) < count:
        rows.append(
            {
                "names": ["command_delay", "motor_deadband"][len(rows) % 2 : len(rows) % 2 + 1],
                "level": "plain",
                "poor": True,
            }
        )
    rng.shuffle(rows)
    return rows[:count]


def reached(found: float) -> str:
    """The level that a ratio belongs to, which may differ from the one aimed at."""
    return next((level for level, (low, _) in LEVELS.items() if found >= low), "below")


def _parameters(names: list[str], size: float, seed: list[int], base):
    physics, effect = base, {}
    for i, name in enumerate(names):
        hidden = BY_NAME[name]
        physics = physics._replace(**hidden.physics(size, np.random.default_rng([*seed, 10 + i])))
        effect |= hidden.sensor(size, np.random.default_rng([*seed, 20 + i]))
    return physics, effect


def _choose_size(
    row: dict, seed: list[int], base, sensor: Sensor, drive: Drive, start: np.ndarray
) -> tuple[float, float]:
    """Secant search for the size whose ratio lies in the level's band; returns size, ratio."""
    rng = np.random.default_rng([*seed, 3])
    low, high = LEVELS[row["level"]]
    target = rng.uniform(low, high)
    noise = floor(base, sensor, drive, start, rng)
    size, best, below, above = 0.3, (0.3, float("nan"), 1e9), 0.001, 1.0
    for _ in range(8):
        physics, effect = _parameters(row["names"], size, seed, base)
        found = ratio(physics, effect, base, drive, start, noise)
        miss = abs(np.log(max(found**2 - 1, 1e-6)) - np.log(target**2 - 1))
        if miss < best[2]:
            best = (size, found, miss)
        if low <= found <= high or (found < low and size >= 1.0):
            break
        guess = size * np.sqrt((target**2 - 1) / max(found**2 - 1, 1e-6))
        below, above = (max(below, size), above) if found < target else (below, min(above, size))
        size = float(guess) if below < guess < above else float(np.sqrt(below * above))
        size = 1.0 if above == 1.0 and below > 0.5 else size
    return best[0], best[1]


def _write_run(
    folder: Path, name: str, drive: Drive, times, states, sensor: Sensor, rng: np.random.Generator
) -> None:
    folder.mkdir(parents=True)
    n = int((drive.end - 0.1) * sensor.rate)
    stamps = np.sort(
        np.arange(n) / sensor.rate
        + rng.uniform(0, 0.3 / sensor.rate)
        + rng.normal(0, 0.0006, n).clip(-0.002, 0.002)
    )
    stamps = stamps[stamps > 0]
    poses = observe(times, states, stamps, sensor.effect)
    white = rng.standard_normal(poses.shape)
    noise = np.empty_like(white)
    noise[0] = white[0]
    for i in range(1, len(white)):
        noise[i] = sensor.colour * noise[i - 1] + np.sqrt(1 - sensor.colour**2) * white[i]
    noise *= np.where(rng.random((len(poses), 1)) < sensor.outliers, 9.0, 1.0)
    poses = poses + noise * [sensor.sigma_xy, sensor.sigma_xy, sensor.sigma_theta]
    keep = rng.random(len(poses)) > sensor.dropouts
    for start in rng.uniform(5, drive.end - 5, rng.integers(0, 4)):
        keep &= ~((stamps > start) & (stamps < start + rng.uniform(0.3, 0.9)))
    logged = stamps / (1.0 + sensor.effect.get("drift", 0.0))
    theta = np.arctan2(np.sin(poses[:, 2]), np.cos(poses[:, 2]))
    _csv(
        folder / "pose.csv.gz", "t,x,y,theta", zip(logged[keep], poses[keep, 0], poses[keep, 1], theta[keep])
    )
    _csv(folder / "command.csv.gz", "t,left,right", zip(drive.times[1:], drive.left[1:], drive.right[1:]))
    (folder / "state.csv").write_text(
        "t,state\n" + "".join(f"{t:.5f},{s}\n" for t, s in zip(drive.times[1:], drive.states[1:]))
    )
    channels = [
        "command: {file: command.csv.gz, time: t, left: left, right: right, unit: normalized}",
        "pose: {file: pose.csv.gz, time: t, x: x, y: y, theta: theta}",
        "state: {file: state.csv, time: t, state: state}",
    ]
    if sensor.encoders:
        t = np.arange(0, drive.end - 0.05, 1 / 30)
        ticks = [
            np.floor(np.interp(t, times, states[:, 8 + i]) * 135 / (2 * np.pi) + rng.random())
            for i in range(2)
        ]
        _csv(
            folder / "wheel_angle.csv.gz", "t,left,right", zip(t, ticks[0].astype(int), ticks[1].astype(int))
        )
        channels.append(
            "wheel_angle: {file: wheel_angle.csv.gz, time: t, left: left, right: right, unit: tick, ticks_per_turn: 135}"
        )
    head = f"format: fsm-calib/recording@1\nrobot: {{name: {name}, wheel_radius: 0.0318, axle_length: 0.1, max_wheel_rate: 20.0}}\nchannels:\n"
    (folder / "recording.yaml").write_text(head + "".join(f"  {c}\n" for c in channels))


def _csv(path: Path, header: str, rows) -> None:
    text = (
        header
        + "\n"
        + "".join(
            ",".join(f"{v:d}" if isinstance(v, (int, np.integer)) else f"{v:.5f}" for v in row) + "\n"
            for row in rows
        )
    )
    path.write_bytes(gzip.compress(text.encode(), mtime=0))


def _begun(run: str, seed: list[int], physics, profile: str):
    """The robot with its wheels turned as they are when a run begins, what it is told, where it starts, and the draws
    that go on from there.
    """
    g = np.random.default_rng([*seed, 50 + RUNS.index(run)])
    physics = physics._replace(phase_left=g.uniform(0, 6.28), phase_right=g.uniform(0, 6.28))
    x0 = np.array([g.uniform(-0.25, 0.25), g.uniform(-0.25, 0.25), g.uniform(-3.14, 3.14)])
    own = "held_out" if run == "run-h" and profile == "mixed" else profile
    return physics, make_drive(g, physics, x0, own), x0, g


def make_robot(out: Path, index: int, row: dict, seed: int) -> dict:
    """Write one robot's three runs; return its line of the key."""
    s = [seed, 1000 + index]
    rng = np.random.default_rng(s)
    base, sensor = draw_base(rng), draw_sensor(rng)
    profile = "poor" if row.get("poor") else "mixed"
    size, found = 0.0, 1.0
    if row["names"]:
        _, trial, x0, _ = _begun("run-a", s, base, "mixed")
        size, found = _choose_size(row, s, base, sensor, trial, x0)
    physics, effect = _parameters(row["names"], size, s, base)
    once = [n for n in row["names"] if BY_NAME[n].once]
    name = f"robot-{index:03d}"
    for run in RUNS:
        plain, _ = _parameters([n for n in row["names"] if n not in once], size, s, base)
        used = physics if (run == "run-a" or not once) else plain
        used, drive, x0, g = _begun(run, s, used, profile)
        if run == "run-a" and row["names"] and profile == "mixed":
            noise = floor(base, sensor, drive, x0, np.random.default_rng([*s, 3]))
            found = ratio(used, effect, base, drive, x0, noise)
        times, states = simulate(used, *drive.arrays(), x0, drive.end + 0.5, g)
        _write_run(out / "robots" / name / run, name, drive, times, states, _with_effect(sensor, effect), g)
    return {
        "name": name,
        "label": "+".join(row["names"]) or "none",
        "level": reached(found) if row["names"] else "none",
        "poor": bool(row.get("poor")),
        "size": size,
        "ratio": found,
        "physics": physics._asdict(),
        "sensor": effect,
        "encoders": sensor.encoders,
        "rate": sensor.rate,
        "sigma": [sensor.sigma_xy, sensor.sigma_theta],
        "colour": sensor.colour,
        "once_in": "run-a" if once else None,
    }


def _with_effect(sensor: Sensor, effect: dict) -> Sensor:
    from dataclasses import replace

    return replace(sensor, effect=effect)


def keystream(passphrase: str, length: int) -> bytes:
    """Bytes to cover a key with: SHAKE-256 of the passphrase."""
    return hashlib.shake_256(passphrase.encode()).digest(length)


def command_line(summary: str, robots: int, seed: int) -> argparse.ArgumentParser:
    """The options that every generator of robots has."""
    parser = argparse.ArgumentParser(description=summary)
    parser.add_argument("out", type=Path)
    parser.add_argument("--robots", type=int, default=robots)
    parser.add_argument("--seed", type=int, default=seed)
    parser.add_argument("--jobs", type=int, default=1)
    return parser


def key_text(out: Path, lines: list[dict]) -> bytes:
    """Write the hash of the key and return its text."""
    text = json.dumps(sorted(lines, key=lambda line: line["name"]), indent=1).encode()
    (out / "key.sha256").write_text(hashlib.sha256(text).hexdigest() + "\n")
    return text


def main() -> None:
    parser = command_line(__doc__.splitlines()[0], robots=400, seed=1)
    parser.add_argument("--open", action="store_true", help="a development set: the key in plain text")
    parser.add_argument(
        "--clean", action="store_true", help="robots that hide nothing, for the rate of false names"
    )
    a = parser.parse_args()
    rows = [CLEAN] * a.robots if a.clean else plan(a.robots, a.seed)
    lines = Parallel(n_jobs=a.jobs, verbose=5)(
        delayed(make_robot)(a.out, i, row, a.seed) for i, row in enumerate(rows)
    )
    text = key_text(a.out, lines)
    if a.open:
        (a.out / "key.json").write_bytes(text)
        return
    passphrase = secrets.token_hex(16)
    vault = a.out.with_name(a.out.name + "-vault")
    vault.mkdir(parents=True, exist_ok=True)
    (vault / "passphrase").write_text(passphrase)
    (a.out / "key.sealed").write_bytes(bytes(x ^ y for x, y in zip(text, keystream(passphrase, len(text)))))


if __name__ == "__main__":
    main()
