"""The laws of one time step outside the engine's own bodies and contacts: command chain, DC motors,
gears, forces.

Called once before each step of the engine (numba). Joint order of the robot's tree (engine.py): x,
y, z, yaw, pitch,
roll, left wheel, right wheel, then casters; `force` are the generalised forces of these joints.
Sources: DC motor and gear: Maxon formulae handbook; rolling and scrub: Pacejka, Tyre and Vehicle
Dynamics, ch. 1-3, 9;
Stribeck: Armstrong-Helouvry 1994; supply: Plett, Battery Management Systems I, ch. 2.
"""

from __future__ import annotations

import math

import numba
import numpy as np

G = 9.81


@numba.njit(cache=True)
def _command_chain(p, s, i, u, other, t):
    """Command u of wheel i after the firmware's shaping (deadband, limit, curve, direction, lag, slew,
    fault).
    """
    u = u - p.couple * other
    mag = abs(u)
    sign = 1.0 if u >= 0.0 else -1.0
    if mag < p.dead[i]:
        mag = 0.0
    elif p.dead_subtract > 0.5:
        mag -= p.dead[i]
    mag = mag**p.curve_power if mag > 0.0 else 0.0
    mag = mag * (1.0 + p.curve_bridge) / (1.0 + p.curve_bridge * mag)
    if p.limit_soft > 0.0:  # knee: the last share of the range is lost gradually
        mag = mag if mag < 1e-9 else mag / (1.0 + (mag * p.limit_soft) ** 4) ** 0.25
    mag = min(mag, p.limit)
    if sign < 0.0:
        mag *= p.reverse[i]
    want = sign * mag
    step = want - s.filtered[i]
    if p.lag[i] > 0.0:
        step *= 1.0 - math.exp(-p.dt / p.lag[i])
    top = p.slew[i] * p.dt
    s.filtered[i] += min(max(step, -top), top)
    out = s.filtered[i]
    if p.fault_loss > 0.0 and p.fault_side == i:
        for k in range(p.fault_from.size):
            if p.fault_from[k] <= t < p.fault_to[k]:
                s.active = 1.0
                if p.fault_chop <= 0.0 or (t - p.fault_from[k]) % p.fault_chop < 0.5 * p.fault_chop:
                    out *= 1.0 - p.fault_loss
    return out


@numba.njit(cache=True)
def _duty(p, s, i, u, angle):
    """Duty in -1..1: the command itself, or a PI on the quantised encoder's rate (held between samples)."""
    if p.rate_control < 0.5:
        return u
    if s.step % p.control_steps == 0:
        period = p.control_steps * p.dt
        count = math.floor(angle * p.counts / (2.0 * math.pi))
        rate = (count - s.count[i]) * 2.0 * math.pi / p.counts / period
        s.count[i] = count
        goal = u * p.rate_max
        if abs(goal) < 1e-6 and abs(rate) < 1e-6:
            s.integral[i] *= 0.9
        error = (goal - rate) / p.rate_max
        raw = p.kff * u + p.kp * error + s.integral[i]
        if abs(raw) < 1.0 or raw * error < 0.0:
            s.integral[i] += p.ki * period * error
        s.duty[i] = min(max(p.kff * u + p.kp * error + s.integral[i], -1.0), 1.0)
    return s.duty[i]


@numba.njit(cache=True)
def _motor(p, s, i, duty, rate):
    """Torque (N m at the wheel) of a DC motor: T = Ts (V - w/w0), with supply and winding heat."""
    supply = 1.0 - p.battery_fall * s.step * p.dt - s.polarised - p.battery_r * s.current
    free = p.free[i] * (p.reverse_brush[i] if duty < 0.0 else 1.0)
    free *= 1.0 + p.magnet * (1.0 - math.exp(-s.step * p.dt / p.magnet_tau))
    stall = p.stall[i] / (1.0 + p.heat * s.warm[i])
    share = duty * max(supply, 0.2) - rate / free
    if p.heat > 0.0:  # warm = 1: what a steady fifth of the stall current reaches
        s.warm[i] += p.dt / p.heat_tau * (min(share * share / 0.04, 4.0) - s.warm[i])
    return stall * share


@numba.njit(cache=True)
def _stick(limit, wanted):
    """Dry friction: as much as would stop the motion in this step, at most the limit."""
    return min(max(wanted, -limit), limit)


@numba.njit(cache=True)
def _wheel_place(p, q, i):
    y = 0.5 * p.axle * (1.0 if i == 0 else -1.0)
    return q[0] - y * math.sin(q[3]), q[1] + y * math.cos(q[3])


@numba.njit(cache=True)
def _drive(p, s, q, v, cmd, t, load, speed, force):
    """Motor and gear torques of both wheels into force[6], force[7]."""
    current = 0.0
    for i in range(2):
        w = v[6 + i]
        u = _command_chain(p, s, i, cmd[i], cmd[1 - i], t)
        px, py = _wheel_place(p, q, i)
        warm = 1.0 - p.grease * (1.0 - math.exp(-t / p.grease_tau))
        viscous = p.viscous[i] * warm
        dry = p.dry[i] * warm * (1.0 + p.static_extra * math.exp(-abs(w) / p.static_rate))
        dry += p.mesh * abs(s.motor_torque[i])
        floor = p.rolling * load[i] * p.radius[i]
        if p.rough + p.rough_viscous > 0.0 and (px - p.rough_x) ** 2 + (py - p.rough_y) ** 2 < p.rough_r**2:
            floor += (p.rough + p.rough_viscous * abs(w) * p.radius[i]) * load[i] * p.radius[i]
            s.active = 1.0
        if p.play_on > 0.5:
            n = 10
            h = p.dt / n
            phi = q[6 + i]
            mean = 0.0
            inertia = 0.5 * p.rotor_inertia[i]  # the other half is the gear's last stage, on the wheel
            duty = _duty(p, s, i, u, q[6 + i] if p.encoder_at_wheel > 0.5 else s.rotor[i])
            for _ in range(n):
                phi += h * w
                torque = _motor(p, s, i, duty, s.rotor_rate[i]) - viscous * s.rotor_rate[i]
                gap = s.rotor[i] - phi
                half = 0.5 * p.play[i]
                through = 0.0
                if abs(gap) > half:
                    through = p.play_k * (gap - half if gap > 0.0 else gap + half)
                    through += p.play_c * (s.rotor_rate[i] - w)
                torque -= through
                stop = torque + s.rotor_rate[i] * inertia / h
                torque -= _stick(dry, stop)
                s.rotor_rate[i] += h * torque / inertia
                s.rotor[i] += h * s.rotor_rate[i]
                mean += through / n
            s.motor_torque[i] = mean
            torque = mean
            drag = floor
        else:
            s.rotor[i] = q[6 + i]
            duty = _duty(p, s, i, u, q[6 + i])
            torque = _motor(p, s, i, duty, w)
            s.motor_torque[i] = torque
            torque -= viscous * w
            drag = dry + floor
        current += abs(duty * s.motor_torque[i] / p.stall[i])
        force[6 + i] = torque - _stick(drag, torque + w * p.inertia_stick[i] / p.dt)
        # what the engine's contacts take over
        phase = q[6 + i] + p.off_phase[i]
        s.disc_radius[i] = p.radius[i] + p.off_centre[i] * math.cos(phase) + p.oval[i] * math.cos(2.0 * phase)
        s.disc_grip[i] = p.grip
        s.disc_zone[i] = max(p.zone, p.creep * abs(speed))
        if p.slick > 0.0 and (px - p.slick_x) ** 2 + (py - p.slick_y) ** 2 < p.slick_r**2:
            s.disc_grip[i] = p.grip * (1.0 - p.slick)
            s.disc_zone[i] = max(s.disc_zone[i], p.slick_film)
            s.active = 1.0
    s.current += (current - s.current) * min(1.0, p.dt / 0.005)
    s.polarised += p.dt / p.battery_tau * (p.battery_pol * s.current - s.polarised)


@numba.njit(cache=True)
def _push_force(force, x, y, fx, fy):
    """A force (world, N) at a point x, y (world, m, from the axle's middle) into the planar joints."""
    force[0] += fx
    force[1] += fy
    force[3] += x * fy - y * fx


@numba.njit(cache=True)
def _floor(p, s, q, v, load, forward, force):
    """Tilt, nap, caster drag of a place, scrub."""
    c, si = math.cos(q[3]), math.sin(q[3])
    speed = math.hypot(v[0], v[1])
    weight = p.mass * G
    s.gravity_x = G * (p.tilt_x + p.dish * (q[0] - p.dish_x))
    s.gravity_y = G * (p.tilt_y + p.dish * (q[1] - p.dish_y))
    nx, ny = math.cos(p.nap_angle), math.sin(p.nap_angle)
    if p.nap_pull != 0.0 or p.nap_drag != 0.0:
        soft = speed / (speed + 0.01)
        force[0] += p.nap_pull * weight * nx * soft
        force[1] += p.nap_pull * weight * ny * soft
        if speed > 0.0:
            against = 0.5 * (1.0 - (v[0] * nx + v[1] * ny) / speed)
            drag = p.nap_drag * weight * against * soft / speed
            force[0] -= drag * v[0]
            force[1] -= drag * v[1]
    if p.nap_carry != 0.0:
        s.drift_x += p.dt * p.nap_carry * abs(forward) * nx
        s.drift_y += p.dt * p.nap_carry * abs(forward) * ny
    for k in range(p.casters):
        rx = c * p.caster_x[k] - si * p.caster_y[k]
        ry = si * p.caster_x[k] + c * p.caster_y[k]
        mu = 0.0
        if p.rough > 0.0 and (q[0] + rx - p.rough_x) ** 2 + (q[1] + ry - p.rough_y) ** 2 < p.rough_r**2:
            mu += p.rough
            s.active = 1.0
        if p.caster_stick > 0.0 and s.rolled % p.caster_stick_period < (
            p.caster_stick_share * p.caster_stick_period
        ):
            mu += p.caster_stick
        if mu > 0.0:
            vx, vy = v[0] - v[3] * ry, v[1] + v[3] * rx
            size = math.hypot(vx, vy)
            pull = _stick(mu * p.caster_load, 0.1 * p.mass * size / p.dt)
            if size > 1e-9:
                _push_force(force, rx, ry, -pull * vx / size, -pull * vy / size)
    turn = v[3]
    if p.scrub_grip > 0.0 or p.scrub_viscous > 0.0:
        for i in range(2):
            along = abs(forward - turn * 0.5 * p.axle * (1.0 if i == 0 else -1.0))
            quarter = 0.25 * p.scrub_width
            spin = abs(turn) * quarter
            part = spin / (math.hypot(spin, along) + 1e-4)
            top = p.scrub_grip * load[i] * quarter * part
            inertia = 0.05 * p.mass * p.axle**2
            force[3] -= _stick(top, turn * inertia / p.dt) + p.scrub_viscous * load[i] * turn


@numba.njit(cache=True)
def _others(p, s, q, v, t, force):
    """Push of a moment, and what no label describes."""
    c, si = math.cos(q[3]), math.sin(q[3])
    if p.push != 0.0 and p.push_from <= t < p.push_from + p.push_time:
        s.active = 1.0
        size = p.push
        if p.push_flat < 0.5:
            size *= math.sin(math.pi * (t - p.push_from) / p.push_time)
        a = p.push_angle + q[3]
        _push_force(force, c * p.push_arm, si * p.push_arm, size * math.cos(a), size * math.sin(a))
    if p.tether_k > 0.0:
        dx, dy = p.tether_x - q[0], p.tether_y - q[1]
        d = math.hypot(dx, dy)
        if d > p.tether_l:
            pull = p.tether_k * (d - p.tether_l) / d
            _push_force(force, 0.0, 0.0, pull * dx, pull * dy)
    if p.wind != 0.0:
        wx, wy = math.cos(p.wind_angle), math.sin(p.wind_angle)
        across = (q[0] - p.wind_x) * -wy + (q[1] - p.wind_y) * wx
        jet = p.wind * math.exp(-0.5 * (across / p.wind_width) ** 2)
        _push_force(force, 0.03 * c, 0.03 * si, jet * wx, jet * wy)
    if p.compass != 0.0:
        force[3] -= p.compass * math.sin(q[3] - p.compass_angle)
    if p.trailer > 0.0:
        hx, hy = -p.hitch * c, -p.hitch * si
        vx, vy = v[0] - v[3] * hy, v[1] + v[3] * hx
        ct, st = math.cos(s.trailer_angle), math.sin(s.trailer_angle)
        s.trailer_angle += p.dt * (vy * ct - vx * st) / p.trailer_l
        along = vx * ct + vy * st
        pull = _stick(p.trailer, 0.2 * p.mass * along / p.dt)
        _push_force(force, hx, hy, -pull * ct, -pull * st)
    if p.slosh > 0.0:
        ax = p.slosh_rate**2 * (q[0] - s.slosh_x) + 2.0 * p.slosh_damp * p.slosh_rate * (v[0] - s.slosh_vx)
        ay = p.slosh_rate**2 * (q[1] - s.slosh_y) + 2.0 * p.slosh_damp * p.slosh_rate * (v[1] - s.slosh_vy)
        s.slosh_vx += p.dt * ax
        s.slosh_vy += p.dt * ay
        s.slosh_x += p.dt * s.slosh_vx
        s.slosh_y += p.dt * s.slosh_vy
        force[0] -= p.slosh * ax
        force[1] -= p.slosh * ay


@numba.njit(cache=True)
def step(par: np.ndarray, state: np.ndarray, q, v, cmd, force) -> None:
    """One step: generalised forces (N, N m) from coordinates q, rates v (SI) and both commands (-1..1)."""
    p = par[0]
    s = state[0]
    t = s.step * p.dt
    s.active = 0.0
    force[:] = 0.0
    load = np.zeros(2)
    for i in range(2):
        side = 0.5 * p.axle * (1.0 if i == 0 else -1.0)
        load[i] = max(0.0, p.normal_k[i] * (p.radius[i] - q[2] - side * q[5]))
    forward = v[0] * math.cos(q[3]) + v[1] * math.sin(q[3])
    s.rolled += p.dt * abs(forward)
    _drive(p, s, q, v, cmd, t, load, forward, force)
    _floor(p, s, q, v, load, forward, force)
    _others(p, s, q, v, t, force)
    s.step += 1
