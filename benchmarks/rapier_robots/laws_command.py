"""Laws of what happens to commands before they reach the motors."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable

from benchmarks.rapier_robots.engine import STEP
from benchmarks.rapier_robots.laws import Draw, law
from benchmarks.rapier_robots.setup import CommandHook, Setup, State

Bend = Callable[[float], float]


def _both(bend: Bend) -> Callable[[int], CommandHook]:
    """Return a maker of a hook that bends both commands alike."""

    def hook(st: State, left: float, right: float) -> tuple[float, float]:
        return bend(left), bend(right)

    return lambda run: hook


@law(
    "command_delay",
    "s",
    0.01,
    0.6,
    "fixed latency of a serial bridge with a software queue (tty latency timers)",
)
def constant(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """Every command acts later by `size` [s]."""
    n = max(round(size / STEP), 1)

    def make(run: int) -> CommandHook:
        line: deque[tuple[float, float]] = deque([(0.0, 0.0)] * n)

        def hook(st: State, left: float, right: float) -> tuple[float, float]:
            line.append((left, right))
            return line.popleft()

        return hook

    s.commands.append(make)
    return {"delay_s": n * STEP}


@law("command_delay", "s", 0.03, 1.2, "Wi-Fi power save: frames wait for the next beacon, IEEE 802.11 DTIM")
def beacon_bunches(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """Commands come in bunches, one every `size` [s]; only the last of a bunch acts."""

    def make(run: int) -> CommandHook:
        now = [0.0, 0.0, float(d.rng(run).uniform(0.0, size))]

        def hook(st: State, left: float, right: float) -> tuple[float, float]:
            if st.t >= now[2]:
                now[:] = [left, right, now[2] + size]
            return now[0], now[1]

        return hook

    s.commands.append(make)
    return {"period_s": size}


@law(
    "command_delay",
    "s",
    0.03,
    1.2,
    "bufferbloat: a queue drained slower than it fills, flushed when full (Gettys 2011)",
)
def filling_queue(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """The delay grows from 0 to `size` [s] in a few seconds and starts again."""
    period = d.between(0, 3.0, 6.0)

    def make(run: int) -> CommandHook:
        line: list[tuple[float, float]] = []
        phase = float(d.rng(run).uniform())

        def hook(st: State, left: float, right: float) -> tuple[float, float]:
            line.append((left, right))
            late = size * ((st.t / period + phase) % 1.0)
            row = len(line) - 1 - round(late / STEP)
            return line[row] if row >= 0 else (0.0, 0.0)

        return hook

    s.commands.append(make)
    return {"longest_s": size, "period_s": period}


@law(
    "command_saturation",
    "1",
    0.03,
    0.8,
    "mixers scale both wheels alike to keep the curve (ROS diff-drive limiters)",
)
def kept_curvature(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """Where one wheel is beyond 1 - `size`, both are scaled down together."""
    limit = 1.0 - size

    def hook(st: State, left: float, right: float) -> tuple[float, float]:
        most = max(abs(left), abs(right))
        return (left * limit / most, right * limit / most) if most > limit else (left, right)

    s.commands.append(lambda run: hook)
    return {"limit": limit}


@law(
    "command_saturation",
    "1",
    0.03,
    0.85,
    "current-limited stage runs out of voltage softly (motor driver data sheets)",
)
def running_out(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """Above the knee 1 - `size` a command approaches knee + 0.08 and no more."""
    knee, room = 1.0 - size, 0.08

    def bend(u: float) -> float:
        over = abs(u) - knee
        return u if over <= 0 else math.copysign(knee + room * (1.0 - math.exp(-over / room)), u)

    s.commands.append(_both(bend))
    return {"knee": knee, "room": room}


@law(
    "command_saturation",
    "1",
    0.1,
    0.97,
    "largest turn rate in a base's firmware (Create, Kobuki command limits)",
)
def turn_limit(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """Half the difference of the commands is held within 1 - `size`; their mean is kept."""
    limit = 1.0 - size

    def hook(st: State, left: float, right: float) -> tuple[float, float]:
        mean, half = 0.5 * (left + right), 0.5 * (right - left)
        half = min(max(half, -limit), limit)
        return mean - half, mean + half

    s.commands.append(lambda run: hook)
    return {"limit": limit}


@law("motor_deadband", "1", 0.02, 0.6, "sleep comparator of a bridge with hysteresis (TI DRV88xx auto-sleep)")
def sleeping_bridge(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """A wheel's stage wakes above `size` and falls asleep below 0.6 of it."""

    def make(run: int) -> CommandHook:
        awake = [False, False]

        def hook(st: State, left: float, right: float) -> tuple[float, float]:
            for k, u in enumerate((left, right)):
                awake[k] = abs(u) > (0.6 * size if awake[k] else size)
            return left if awake[0] else 0.0, right if awake[1] else 0.0

        return hook

    s.commands.append(make)
    return {"wake": size, "sleep": 0.6 * size}


@law(
    "motor_deadband",
    "1",
    0.003,
    0.4,
    "bridge dead time eats short pulses (Mohan: Power Electronics, blanking time)",
    needs="duty",
)
def blanking_time(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """Pulses lose `size` of the period; of the shortest ones a part passes through the diodes."""

    def bend(u: float) -> float:
        a = abs(u)
        return math.copysign(a - size * (1.0 - math.exp(-a / size)), u)

    s.commands.append(_both(bend))
    return {"width": size}


@law(
    "motor_gain_curve",
    "1",
    0.02,
    1.0,
    "cubic expo of a transmitter, blended with the straight line (radio manuals)",
)
def cubic_expo(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """u becomes (1 - c) u + c u^3."""
    s.commands.append(_both(lambda u: (1.0 - size) * u + size * u**3))
    return {"share": size}


@law(
    "motor_gain_curve",
    "1",
    0.1,
    1.0,
    "sine table as speed map (sinusoidal drive tables in gimbal and BLDC firmware)",
)
def sine_table(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """u becomes sin(c u pi/2) / sin(c pi/2)."""
    turn = 0.5 * math.pi * size
    top = math.sin(turn)
    s.commands.append(_both(lambda u: math.sin(turn * u) / top))
    return {"bend": size}


@law(
    "motor_reverse_asymmetry",
    "1",
    0.01,
    0.6,
    "'reverse speed' setting of electronic speed controllers (ESC manuals)",
)
def reverse_percent(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """Backwards a command counts 1 - `size`."""
    s.commands.append(_both(lambda u: u if u > 0 else u * (1.0 - size)))
    return {"loss": size}


@law(
    "motor_reverse_asymmetry",
    "1",
    0.01,
    0.9,
    "charge pump that runs dry at high duty of one direction (gate driver notes)",
    needs="duty",
)
def dry_charge_pump(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """Backwards a duty loses `size` of its square."""
    s.commands.append(_both(lambda u: u if u > 0 else u + size * u * u))
    return {"loss": size}


def _lagging(rise: float, fall: float, order: int) -> Callable[[int], CommandHook]:
    """Return a maker of a low-pass (time constants [s]) that is of another speed up than down."""

    def make(run: int) -> CommandHook:
        chain = [[0.0] * order, [0.0] * order]

        def hook(st: State, left: float, right: float) -> tuple[float, float]:
            for k, u in enumerate((left, right)):
                last = chain[k][-1]
                tau = rise if abs(u) > abs(last) and u * last >= 0 else fall
                for n in range(order):
                    chain[k][n] += (u - chain[k][n]) * STEP / (STEP + tau)
                    u = chain[k][n]
            return chain[0][-1], chain[1][-1]

        return hook

    return make


@law(
    "motor_asymmetric_lag",
    "s",
    0.01,
    1.0,
    "S-ramp when speeding up, direct stop (motion profile of stair-lift drives)",
)
def jerk_limited(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """Speeding up passes two low-passes of `size` [s]; slowing down hardly any."""
    s.commands.append(_lagging(size, 0.1 * size, 2))
    return {"rise_s": size, "fall_s": 0.1 * size}


@law(
    "motor_asymmetric_lag",
    "s",
    0.01,
    1.0,
    "drag brake off: a controller that lets the motor run down (ESC manuals)",
)
def drag_brake_off(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """Slowing down follows with a time constant of `size` [s]; speeding up at once."""
    s.commands.append(_lagging(0.05 * size, size, 1))
    return {"rise_s": 0.05 * size, "fall_s": size}
