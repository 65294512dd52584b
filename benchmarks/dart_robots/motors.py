"""Commands to torques: firmware, driver, battery, DC motor, and an on-board speed controller for some robots.

Sources: the torque-speed line of a permanent-magnet DC motor (any drives text); coasting against braking in
the off time of PWM (TI DRV8833 and DRV8871 data sheets: «fast» and «slow decay»); the bridge's saturation
voltage (ST L298 data sheet: 1.8 to 4.9 V in total); copper's +0.39 %/K and ferrite magnets' -0.2 %/K;
Shepherd's cell (*Design of primary and secondary cells*, 1965) for a battery near its end.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from benchmarks.dart_robots.truth import Drive, Moments, Place

COPPER = 0.0039  # 1/K
FERRITE = -0.002  # 1/K
STILL = 6  # samples of a wheel at rest after which the controller lets go
CHATTER = (0.015, 0.06)  # s: how long a loose contact stays as it is


class Battery:
    """Open-circuit voltage that falls as charge is used, behind a resistance."""

    def __init__(self, drive: Drive, seconds: float):
        self.drive = drive
        self.seconds = seconds
        self.used = 0.0
        self.current = 0.0

    def volts(self, current: float, dt: float) -> float:
        """Return the terminal voltage after a step at the motors' `current` [A] (smoothed over 5 ms)."""
        drive = self.drive
        self.current += (current - self.current) * min(1.0, dt / 0.005)
        open_circuit = drive.volts
        if drive.discharge:
            rated = 0.15 * drive.volts / drive.ohm[0]
            self.used += (0.5 + 0.5 * self.current / rated) * dt / self.seconds
            share = min(self.used, 1.1)
            open_circuit *= 1.0 - drive.discharge * (1.0 / (1.0 - 0.8 * share) - 1.0) / 4.0
        return max(open_circuit - drive.cell_ohm * self.current, 0.2 * drive.volts)


class Controller:
    """A PI speed controller with feed-forward that reads an encoder of the motor at its own rate."""

    def __init__(self, drive: Drive, side: int):
        self.drive = drive
        self.free_rate = drive.volts / drive.emf[side]
        self.step = 1.0 / drive.control_hz
        self.next = -math.inf
        self.count: float | None = None
        self.still = 0
        self.rate = 0.0
        self.total = 0.0
        self.duty = 0.0

    def output(self, time: float, setpoint: float, angle: float) -> float:
        """Return the duty for a wanted rate [rad/s], given the motor's angle at the wheel [rad]."""
        if time < self.next:
            return self.duty
        drive = self.drive
        self.next = time + self.step - 1e-9
        count = math.floor(angle * drive.counts / (2 * math.pi))
        if self.count is not None:
            raw = (count - self.count) * 2 * math.pi / drive.counts / self.step
            self.rate += 0.5 * (raw - self.rate)
        self.count = count
        still = abs(setpoint) < 0.003 * self.free_rate and abs(self.rate) < 0.02 * self.free_rate
        self.still = self.still + 1 if still else 0
        if self.still >= STILL:
            self.total, self.duty = 0.0, 0.0
            return 0.0
        error = (setpoint - self.rate) / self.free_rate
        wanted = drive.feed * setpoint / self.free_rate + drive.proportional * error + self.total
        self.duty = max(-1.0, min(1.0, wanted))
        # back-calculation against wind-up (Astrom and Hagglund, *PID Controllers*)
        excess = (self.duty - wanted) / drive.proportional
        self.total += drive.integral * (error + excess) * self.step
        return self.duty


class Channel:
    """One wheel's way from command to torque at the wheel."""

    def __init__(self, drive: Drive, place: Place, moments: Moments, side: int):
        self.drive, self.place, self.moments, self.side = drive, place, moments, side
        self.controller = Controller(drive, side) if drive.mode == "rate" else None
        self.shaped = 0.0
        self.smooth = 0.0
        self.current = 0.0
        self.drawn = 0.0  # A from the battery: the bridge passes the motor's current on for its on time
        self.kelvin = 0.0
        self.turned = 0.0
        self.rng = np.random.default_rng([moments.seed, side])
        self.contact_open = False
        self.contact_until = -math.inf

    def shape(self, command: float, dt: float) -> float:
        """Return the command as the firmware passes it on."""
        drive, side = self.drive, self.side
        if abs(command) < drive.deadzone:
            command = 0.0
        bend = drive.expo[side]
        if bend:
            command = (1.0 - bend) * command + bend * command**3
        command = max(-drive.ceiling, min(drive.ceiling, command))
        slew = drive.slew[side]
        if slew:
            command = self.shaped + max(-slew * dt, min(slew * dt, command - self.shaped))
        self.shaped = command
        if drive.lowpass[side]:
            self.smooth += (command - self.smooth) * dt / (drive.lowpass[side] + dt)
            return self.smooth
        return command

    def faulty(self, time: float) -> bool:
        """Return whether this motor is in its bad stretch."""
        place = self.place
        return bool(
            place.fault
            and place.fault_side == self.side
            and self.moments.fault_start <= time < self.moments.fault_end
        )

    def torque(
        self, time: float, command: float, rate: float, angle: float, battery: float, other: float, dt: float
    ) -> float:
        """Return the torque on the wheel without dry friction [N m]; `other`: the other motor's current."""
        drive, side = self.drive, self.side
        command = self.shape(command, dt)
        if self.controller is not None:
            setpoint = command * drive.top_rate * drive.gain[side]
            duty = self.controller.output(time, setpoint, angle)
        else:
            duty = max(-1.0, min(1.0, command * drive.gain[side]))
        if self.place.fault == "thermal_cutback" and self.faulty(time):
            duty *= 1.0 - self.place.fault_size
        volts = duty * battery
        if drive.crosstalk and side == 1 and duty:
            volts -= math.copysign(drive.crosstalk * drive.ohm[side] * abs(other), duty)
        drop = drive.bridge_drop + (drive.reverse_drop[side] if volts < 0 else 0.0)
        if drop:
            volts = math.copysign(max(abs(volts) - drop, 0.0), volts)
        emf, ohm = drive.emf[side], drive.ohm[side]
        if rate < 0:
            emf *= drive.reverse_emf[side]
        if drive.heat:
            emf *= 1.0 + FERRITE * self.kelvin
            ohm *= 1.0 + COPPER * self.kelvin
        braked = 1.0 - (1.0 - abs(duty)) * drive.coast[side]
        self.current = (volts - braked * emf * rate) / ohm
        if self.place.fault == "loose_contact" and self.faulty(time) and self.is_open(time):
            self.current = 0.0
        self.drawn = max(0.0, duty * self.current)
        if drive.heat:
            target = drive.heat * self.current**2 * ohm / drive.heat_watt
            self.kelvin += (target - self.kelvin) * dt / drive.heat_time
        drag = drive.viscous[side]
        if drive.grease[side]:
            self.turned += abs(rate) * dt
            drag += drive.grease[side] * math.exp(-self.turned / (0.3 * drive.top_rate * drive.grease_time))
        return emf * self.current - drag * rate

    def is_open(self, time: float) -> bool:
        """Return whether the loose contact is open now; it stays so for some tens of ms."""
        if time >= self.contact_until:
            self.contact_open = bool(self.rng.random() < self.place.fault_size)
            self.contact_until = time + float(self.rng.uniform(*CHATTER))
        return self.contact_open

    def dry(self, time: float, rate: float) -> float:
        """Return the torque that dry friction can hold at this rate [N m], by Stribeck's curve if asked."""
        drive = self.drive
        dry = drive.dry[self.side]
        if drive.static_ratio > 1.0:
            dry *= 1.0 + (drive.static_ratio - 1.0) * math.exp(-((rate / drive.stribeck_rate) ** 2))
        if self.place.fault == "jam" and self.faulty(time):
            dry += self.place.fault_size * drive.emf[self.side] * drive.volts / drive.ohm[self.side]
        return dry


class Link:
    """The way of commands to the robot: first in, first out, with a delay and perhaps jitter."""

    def __init__(self, drive: Drive, moments: Moments):
        self.drive = drive
        self.rng = np.random.default_rng([moments.seed, 7])
        self.queue: deque[tuple[float, float, float]] = deque()
        self.last = -math.inf
        self.now = (0.0, 0.0)

    def send(self, time: float, left: float, right: float) -> None:
        """Take a command in."""
        late = self.drive.delay
        if self.drive.jitter:
            late += float(self.rng.exponential(self.drive.jitter))
        self.last = max(self.last, time + late)
        self.queue.append((self.last, left, right))

    def read(self, time: float) -> tuple[float, float]:
        """Return the command that has arrived last."""
        while self.queue and self.queue[0][0] <= time + 1e-9:
            _, left, right = self.queue.popleft()
            self.now = (left, right)
        return self.now
