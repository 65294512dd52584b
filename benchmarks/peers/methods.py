"""The peers: the base re-fitted alone, sparse regression (pysindy) with an expert library, a Gaussian process.

All predict dv/dt, dw/dt and the sideways speed; all begin a window at the same smoothed state. A peer names what
carries most of its correction, and nothing where the correction gains less than `CLEAN_GAIN` on a drive left out.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from peers.data import AXLE, HORIZON, RADIUS, STEP, Track, Windows
from peers.library import terms

CLEAN_GAIN = 0.01  # share of the residual's variance on the drive that was left out
THRESHOLDS = (0.02, 0.05, 0.1, 0.2)  # of STLSQ, on columns of unit size
POINTS = 300  # rows of the Gaussian process
SUB = 2  # integration steps in STEP
Rates = Callable[[Mapping[str, np.ndarray]], tuple[np.ndarray, np.ndarray, np.ndarray]]


@dataclass(frozen=True)
class Answer:
    """What a peer says: the name it would give ("" for none) and its equations of motion."""

    name: str
    rates: Rates


def state_of(track: Track) -> dict[str, np.ndarray]:
    """Return the arrays of a drive by name, with the wheels' roll as the smoothed speeds tell it."""
    keys = ("v", "w", "x", "y", "theta", "t", "left", "right", "d_left", "d_right")
    state = {key: getattr(track, key) for key in keys}
    for side, sign in (("left", -1.0), ("right", 1.0)):
        state[f"roll_{side}"] = np.cumsum(track.v + sign * track.w * AXLE / 2.0) * STEP / RADIUS
    return state


def predict(track: Track, windows: Windows, rates: Rates) -> np.ndarray:
    """Integrate all windows side by side by Heun's method; return the poses at their ends, shape (n, 3)."""
    whole = state_of(track)
    s = {key: value[windows.rows].copy() for key, value in whole.items()}
    h = STEP / SUB
    for _ in range(round(HORIZON / h)):
        after = track.commands(s["t"] + h / 2.0)
        s["d_left"], s["d_right"] = (track.commands(s["t"] + 0.1) - track.commands(s["t"] - 0.1)).T / 0.2
        s["left"], s["right"] = after.T
        dv, dw, side = rates(s)
        v, w = s["v"] + h * np.clip(dv, -20, 20), s["w"] + h * np.clip(dw, -200, 200)
        forward, turn = (v + s["v"]) / 2.0 * h, (w + s["w"]) / 2.0 * h
        middle = s["theta"] + turn / 2.0
        s["x"] = s["x"] + forward * np.cos(middle) - side * h * np.sin(middle)
        s["y"] = s["y"] + forward * np.sin(middle) + side * h * np.cos(middle)
        s["theta"], s["t"], s["v"], s["w"] = (
            s["theta"] + turn,
            s["t"] + h,
            np.clip(v, -3, 3),
            np.clip(w, -30, 30),
        )
        for key, sign in (("roll_left", -1.0), ("roll_right", 1.0)):
            s[key] = s[key] + h * (s["v"] + sign * s["w"] * AXLE / 2.0) / RADIUS
    return np.stack([s["x"], s["y"], s["theta"]], axis=1)


def targets(tracks: list[Track]) -> list[np.ndarray]:
    """Return the left sides of the three equations, over all drives."""
    return [np.concatenate([getattr(t, key)[t.good] for t in tracks]) for key in ("dv", "dw", "side")]


def columns(tracks: list[Track], equation: int) -> tuple[list[str], np.ndarray]:
    """Return names and values, shape (n, k), of one equation's terms over all drives."""
    parts = []
    for track in tracks:
        found = [(name, value[track.good]) for name, k, value in terms(state_of(track)) if k == equation]
        parts.append(np.stack([value for _, value in found], axis=1))
        names = [name for name, _ in found]
    return names, np.concatenate(parts)


def base_alone(tracks: list[Track]) -> Answer:
    """Re-fit the base robot's terms by least squares; it has no name to give."""
    weights = _fit_base(tracks)
    return Answer("", lambda s: _base_rates(weights, s))


def _fit_base(tracks: list[Track]) -> list[np.ndarray]:
    fitted = []
    for k, target in enumerate(targets(tracks)[:2]):
        names, values = columns(tracks, k)
        base = values[:, [i for i, name in enumerate(names) if name == "base"]]
        fitted.append(np.linalg.lstsq(base, target, rcond=None)[0])
    return fitted


def _base_rates(weights: list[np.ndarray], s: Mapping[str, np.ndarray]):
    base = np.stack([s["left"], s["right"], s["v"], s["w"]], axis=-1)
    return base @ weights[0], base @ weights[1], np.zeros_like(s["v"])


def sparse(tracks: list[Track]) -> Answer:
    """Sparse regression with the expert library; the threshold is chosen by leaving one drive out."""
    scores = {level: _left_out(tracks, level) for level in (np.inf, *THRESHOLDS)}
    best = max(THRESHOLDS, key=lambda level: scores[level])
    gain = 1.0 - (1.0 - scores[best]) / max(1.0 - scores[np.inf], 1e-12)
    coefficients = _regress(tracks, best)
    if gain < CLEAN_GAIN:
        return Answer("", _library_rates(_regress(tracks, np.inf)))
    return Answer(_strongest(tracks, coefficients), _library_rates(coefficients))


def _regress(tracks: list[Track], threshold: float) -> list[np.ndarray]:
    """Fit the three equations; the base's terms are always in, an infinite threshold leaves only them."""
    import pysindy

    fitted = []
    for k, target in enumerate(targets(tracks)):
        names, values = columns(tracks, k)
        base = np.array([name == "base" for name in names])
        size = np.maximum(np.sqrt(np.mean(values**2, axis=0)), 1e-9)
        unit, goal = values / size, target / max(float(np.std(target)), 1e-9)
        weights = np.zeros(len(names))
        chosen = base.copy()
        if np.isfinite(threshold):
            first = np.linalg.lstsq(unit[:, base], goal, rcond=None)[0] if base.any() else np.zeros(0)
            left = goal - (unit[:, base] @ first if base.any() else 0.0)
            optimizer = pysindy.STLSQ(threshold=threshold, alpha=1e-3, max_iter=20)
            with warnings.catch_warnings():
                warnings.simplefilter(
                    "ignore"
                )  # STLSQ warns where it drops every term, which is an answer here
                optimizer.fit(_without(unit[:, ~base], unit[:, base]), left[:, None])
            chosen[~base] = np.abs(optimizer.coef_[0]) > 0.0
        if chosen.any():
            weights[chosen] = np.linalg.lstsq(unit[:, chosen], goal, rcond=None)[0]
        fitted.append(weights / size * max(float(np.std(target)), 1e-9))
    return fitted


def _without(values: np.ndarray, base: np.ndarray) -> np.ndarray:
    """Return the columns less what the base's columns explain of them, at unit size."""
    if not base.shape[1]:
        return values
    rest = values - base @ np.linalg.lstsq(base, values, rcond=None)[0]
    return rest / np.maximum(np.sqrt(np.mean(rest**2, axis=0)), 1e-3)


def _left_out(tracks: list[Track], threshold: float) -> float:
    """Return the share of variance explained on a drive that was left out, mean over drives and equations."""
    shares = []
    for i, track in enumerate(tracks):
        rest = tracks[:i] + tracks[i + 1 :]
        for k, (weights, target) in enumerate(zip(_regress(rest, threshold), targets([track]), strict=True)):
            left = target - columns([track], k)[1] @ weights
            shares.append(1.0 - float(np.mean(left**2)) / max(float(np.mean(target**2)), 1e-12))
    return float(np.mean(shares))


def _strongest(tracks: list[Track], coefficients: list[np.ndarray]) -> str:
    """Return the effect whose terms carry the largest share of the targets' variance."""
    carried: dict[str, float] = {}
    for k, (weights, target) in enumerate(zip(coefficients, targets(tracks), strict=True)):
        names, values = columns(tracks, k)
        for name in set(names) - {"base"}:
            mine = [i for i, other in enumerate(names) if other == name]
            share = float(np.var(values[:, mine] @ weights[mine]) / max(float(np.var(target)), 1e-12))
            carried[name] = carried.get(name, 0.0) + share
    return max(carried, key=lambda name: carried[name]) if any(carried.values()) else ""


def _library_rates(coefficients: list[np.ndarray]) -> Rates:
    def rates(s: Mapping[str, np.ndarray]):
        sums = [np.zeros_like(s["v"]) for _ in range(3)]
        place = [0, 0, 0]
        for _, k, value in terms(s):
            sums[k] = sums[k] + coefficients[k][place[k]] * value
            place[k] += 1
        return sums[0], sums[1], sums[2]

    return rates


FEATURES = {
    "v": "coulomb_friction", "w": "tyre_scrub", "left": "motor_deadband", "right": "motor_deadband",
    "d_left": "command_delay", "d_right": "command_delay", "c": "floor_tilt", "s": "floor_tilt",
    "x": "rough_floor_patch", "y": "rough_floor_patch", "t": "battery_sag",
}  # fmt: skip
"""What the Gaussian process looks at, and the name given to each when its length scale is the shortest."""


def gaussian_process(tracks: list[Track]) -> Answer:
    """Learn what the base leaves over with a Gaussian process; name by automatic relevance (shortest scale)."""
    weights = _fit_base(tracks)
    gains = [_process_gain(tracks, i) for i in range(len(tracks))]
    process, _, _ = _fit_process(tracks, weights)
    if float(np.mean(gains)) < CLEAN_GAIN:
        return Answer("", lambda s: _base_rates(weights, s))

    def rates(s: Mapping[str, np.ndarray]):
        dv, dw, side = _base_rates(weights, s)
        more = process(s)
        return dv + more[:, 0], dw + more[:, 1], side

    return Answer(process.name, rates)


class Process:
    """Two Gaussian processes (forward, turn) on unit features."""

    def __init__(self, features: np.ndarray, left_over: np.ndarray, seed: int = 0) -> None:
        from sklearn.gaussian_process import GaussianProcessRegressor
        from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

        self.mean, self.size = features.mean(axis=0), np.maximum(features.std(axis=0), 1e-6)
        rows = np.random.default_rng(seed).permutation(len(features))[:POINTS]
        inputs, self.models, relevance = (
            (features[rows] - self.mean) / self.size,
            [],
            np.zeros(features.shape[1]),
        )
        for k in range(2):
            spread = max(float(left_over[:, k].std()), 1e-9)
            kernel = ConstantKernel(0.3) * RBF(np.full(features.shape[1], 3.0), (0.3, 1e3)) + WhiteKernel(0.7)
            with warnings.catch_warnings():
                warnings.simplefilter(
                    "ignore"
                )  # scales at their bounds are an answer: the feature is irrelevant
                model = GaussianProcessRegressor(kernel).fit(inputs, left_over[rows, k] / spread)
            relevance += model.kernel_.k1.k1.constant_value / model.kernel_.k1.k2.length_scale**2
            self.models.append((model, spread))
        self.name = list(FEATURES.values())[int(np.argmax(relevance))]

    def __call__(self, s: Mapping[str, np.ndarray]) -> np.ndarray:
        """Return what the base leaves over, shape (n, 2)."""
        inputs = (features_of(s) - self.mean) / self.size
        return np.stack([spread * model.predict(inputs) for model, spread in self.models], axis=1)


def features_of(s: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return the features, shape (n, k), in the order of FEATURES."""
    more = {**s, "c": np.cos(s["theta"]), "s": np.sin(s["theta"])}
    return np.stack([more[key] for key in FEATURES], axis=1)


def _fit_process(tracks: list[Track], weights: list[np.ndarray]) -> tuple[Process, np.ndarray, np.ndarray]:
    features = np.concatenate([features_of(state_of(t))[t.good] for t in tracks])
    left_over = np.stack(_left_over(tracks, weights), axis=1)
    return Process(features, left_over), features, left_over


def _left_over(tracks: list[Track], weights: list[np.ndarray]) -> list[np.ndarray]:
    goal = targets(tracks)
    found = [np.stack(_base_rates(weights, state_of(t))[:2])[:, t.good] for t in tracks]
    return [goal[k] - np.concatenate([rates[k] for rates in found]) for k in range(2)]


def _process_gain(tracks: list[Track], left_out: int) -> float:
    """Return the share of what the base leaves over that the process explains on the drive left out."""
    rest = tracks[:left_out] + tracks[left_out + 1 :]
    weights = _fit_base(rest)
    process, _, _ = _fit_process(rest, weights)
    track = tracks[left_out]
    left_over = np.stack(_left_over([track], weights), axis=1)
    inside = {key: value[track.good] for key, value in state_of(track).items()}
    better = left_over - process(inside)
    return float(np.mean(1.0 - np.mean(better**2, axis=0) / np.maximum(np.mean(left_over**2, axis=0), 1e-12)))


PEERS: dict[str, Callable[[list[Track]], Answer]] = {
    "base by regression": base_alone,
    "pysindy, expert library": sparse,
    "Gaussian process": gaussian_process,
}
