"""What a form without a name is made of: a recording's situation, and how a speed error there reaches the poses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit

from fsm_calib.diagnosis.fitting.fit import Fit
from fsm_calib.diagnosis.replay.simulator import Simulator
from fsm_calib.diagnosis.replay.situation import Situation, situations_of
from fsm_calib.diagnosis.shapes.features import apart_columns, body_columns
from fsm_calib.diagnosis.shapes.wheel_response import driven
from fsm_calib.types import FloatArray
from fsm_calib.world2d.parameters import parameter_table

DRY_SPEED = 0.02  # m/s: dry friction has its full size above (roll-out: creep speed)


@dataclass(frozen=True, eq=False)
class Frame:
    """One recording's situation with the base robot's lags [s], full speed [m/s] and the speeds' usual size.

    simulator, values : what carries a wheel's speed error on to the poses; parameters (p,).
    """

    s: Situation
    simulator: Simulator
    values: FloatArray
    lag_forward: float
    lag_turn: float
    full: float
    speed: float
    spin: float

    @property
    def rims(self) -> tuple[FloatArray, FloatArray]:
        """Rim speeds (n, 1) [m/s] of the left and the right wheel."""
        turn = self.s.half * self.s.omega
        return (self.s.v - turn)[:, None], (self.s.v + turn)[:, None]

    def drive(self, left: FloatArray, right: FloatArray) -> FloatArray:
        """Return columns of wheel speed errors (n, m) [m/s] ahead of the motors, carried on by the roll-out."""
        return driven(self.simulator, self.values, left, right)

    def each(self, left: FloatArray, right: FloatArray) -> FloatArray:
        """Return the same with numbers of its own for each wheel."""
        none = np.zeros_like(left)
        return np.concatenate([self.drive(left, none), self.drive(none, right)], axis=2)

    def forward(self, f: FloatArray) -> FloatArray:
        """Return columns of forward speeds that a force would bring about (n, m) [m/s]."""
        return body_columns(self.s, forward=lagged(f, self.s.dt, self.lag_forward))

    def turn(self, f: FloatArray) -> FloatArray:
        """Return columns of turning speeds that a moment would bring about (n, m) [rad/s]."""
        return body_columns(self.s, turn=lagged(f, self.s.dt, self.lag_turn))

    def sensed(self, **speeds: FloatArray) -> FloatArray:
        """Return columns that only the pose sensor shows."""
        columns = body_columns(self.s, **speeds)
        columns[:, 3:] = 0.0
        return columns

    def every_way(self, forward: FloatArray, turn: FloatArray) -> FloatArray:
        """Return columns of errors of both speeds apart, together, and together for the pose sensor alone."""
        together = body_columns(self.s, forward=forward, turn=turn)
        apart = apart_columns(self.s, forward, turn)
        return np.concatenate([apart, together, self.sensed(forward=forward, turn=turn)], axis=2)


@njit(cache=True)
def lagged(f, dt, tau):  # type: ignore[no-untyped-def]
    """Return `f` (n, m) after a first-order lag tau [s], held over intervals dt (n,) [s]."""
    out = np.empty_like(f)
    now = np.zeros(f.shape[1])
    for k in range(len(f)):
        keep = np.exp(-dt[k] / tau)
        for j in range(f.shape[1]):
            now[j] = keep * now[j] + (1.0 - keep) * f[k, j]
            out[k, j] = now[j]
    return out


def sign(speed: FloatArray) -> FloatArray:
    """Return the sign of a speed [m/s], smooth about zero."""
    return np.asarray(np.tanh(speed / DRY_SPEED))


def powers(x: FloatArray, count: int) -> FloatArray:
    """Return x, x^2, ... of `x` (n,), shape (n, count)."""
    return np.column_stack([x ** (k + 1) for k in range(count)])


def frames_of(simulators: Sequence[Simulator], fit: Fit) -> list[Frame]:
    """Return the frame of every recording, speeds and lags of `fit`."""
    table, values, full = parameter_table(), fit.values[0], simulators[0].full_speed
    situations = situations_of(simulators, fit.values)
    forward, turn = (float(values[table.place(name)]) for name in ("tau_forward", "tau_turn"))
    speed = max(float(np.quantile(np.abs(s.v), 0.98)) for s in situations) or 0.1
    spin = max(float(np.quantile(np.abs(s.omega), 0.98)) for s in situations) or 0.1
    return [
        Frame(s, simulator, own, forward, turn, full, speed, spin)
        for s, simulator, own in zip(situations, simulators, fit.values, strict=True)
    ]
