"""The concealed robots' own physics: nothing of `fsm_calib.world2d` is used or copied here.

A planar rigid body on two wheels. Differences from the simulator under test, on purpose: the rotor's inertia is a
state behind a gear that may have play, the tyres answer to slip *ratio* through a sine-arctangent curve, and the
integrator is semi-implicit at 0.5 ms.

    J_m dω_m/dt = τ_stall (g u - ω_m/ω_0) - τ_gear - c sgn ω_m          rotor, reflected to the wheel [kg m²]
    J_w dω_w/dt = τ_gear - R F_x                                        wheel
    F = μ N sin(1.3 atan(B σ)) σ/|σ|,  σ = (Rω_w - v_x, -v_y) / max(|v|, v_0)
    m (dv_x/dt - v_y ω) = ΣF_x + ...,  m (dv_y/dt + v_x ω) = ΣF_y + ...,  I dω/dt = M
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit


class Physics(NamedTuple):
    """Every parameter of the concealed world, SI units; the defaults are a plain robot."""

    mass: float = 1.1
    inertia: float = 0.0065
    radius: float = 0.0318
    axle: float = 0.1
    load_share: float = 0.42
    mu: float = 0.75
    stiffness: float = 14.0
    v0: float = 0.06
    gain_left: float = 1.0
    gain_right: float = 1.0
    stall: float = 0.21
    no_load: float = 20.0
    rotor_inertia: float = 4e-05
    wheel_inertia: float = 2e-05
    deadband: float = 0.0
    saturation: float = 9.0
    curve: float = 0.0
    reverse_left: float = 0.0
    reverse_right: float = 0.0
    brake_fade: float = 0.0
    coulomb_left: float = 0.0
    coulomb_right: float = 0.0
    play: float = 0.0
    sag_charge: float = 0.0
    sag_load: float = 0.0
    warm_left: float = 0.0
    warm_right: float = 0.0
    warm_time: float = 25.0
    fault_left: float = 0.0
    fault_right: float = 0.0
    fault_start: float = 0.0
    fault_end: float = 0.0
    delay: float = 0.0
    ecc_left: float = 0.0
    ecc_right: float = 0.0
    phase_left: float = 0.0
    phase_right: float = 0.0
    caster_drag: float = 0.0
    caster_scrub: float = 0.0
    caster_trail: float = 0.014
    caster_x: float = -0.075
    scrub_dry: float = 0.0
    scrub_wet: float = 0.0
    lateral_soft: float = 0.0
    com_x: float = 0.0
    com_y: float = 0.0
    tilt_x: float = 0.0
    tilt_y: float = 0.0
    nap: float = 0.0
    nap_direction: float = 0.0
    patch_x: float = 0.0
    patch_y: float = 0.0
    patch_r: float = 0.25
    patch_drag: float = 0.0
    patch_mu: float = 1.0
    push_time: float = -9.0
    push_fx: float = 0.0
    push_fy: float = 0.0
    push_m: float = 0.0
    ou_force: float = 0.0
    ou_moment: float = 0.0
    ou_tau: float = 0.3
    tether_k: float = 0.0
    tether_x: float = 0.0
    tether_y: float = 0.0
    bowl_k: float = 0.0
    bowl_x: float = 0.0
    bowl_y: float = 0.0
    gust_f: float = 0.0
    gust_period: float = 5.0
    gust_phase: float = 0.0
    cross_talk: float = 0.0
    twist_k: float = 0.0
    heading_gain: float = 0.0
    heading_phase: float = 0.0


G = 9.81
PUSH_LENGTH = 0.25
STATE = ["x", "y", "theta", "vx", "vy", "omega", "wheel_left", "wheel_right", "angle_left", "angle_right"]


@njit(cache=True)
def _shape_command(u, deadband, saturation, curve, reverse):
    a = abs(u)
    if a < 0.01:
        return 0.0
    s = 1.0 if u > 0.0 else -1.0
    a = min(a, saturation)
    a = max(a - deadband, 0.0)
    a = a * (1.0 - curve * a)
    if u < 0.0:
        a *= 1.0 - reverse
    return s * a


@njit(cache=True)
def _tyre(rate, radius, vx, vy, mu_load, stiffness, v0, lateral_soft):
    """Return Fx, Fy and dFx/d(R rate) of one tyre."""
    scale = max(math.hypot(vx, vy), max(abs(rate * radius), v0))
    sx = (rate * radius - vx) / scale
    sy = -vy / scale * (1.0 - lateral_soft)
    s = math.hypot(sx, sy)
    if s < 1e-9:
        gain = mu_load * 1.3 * stiffness
        return gain * sx, gain * sy, gain / scale
    f = mu_load * math.sin(1.3 * math.atan(stiffness * s))
    return f * sx / s, f * sy / s, max(f / s, mu_load * 0.02) / scale


@njit(cache=True)
def _simulate(p, times, left, right, x0, n_steps, dt, every, noise):
    """Integrate from standstill; one row of STATE every `every` steps."""
    m, inertia, radius, axle = p.mass, p.inertia, p.radius, p.axle
    out = np.empty((n_steps // every + 1, 10))
    x, y, th = x0[0], x0[1], x0[2]
    vx = vy = om = 0.0
    wm = np.zeros(2)
    ww = np.zeros(2)
    angle = np.zeros(2)
    gap = np.zeros(2)
    fx = np.zeros(2)
    fy = np.zeros(2)
    charge = 0.0
    psi = math.pi
    of = 0.0
    omt = 0.0
    k = 0
    a_ou = math.exp(-dt / p.ou_tau) if p.ou_tau > 0 else 0.0
    b_ou = math.sqrt(1.0 - a_ou * a_ou)
    theta_start = x0[2]
    for i in range(n_steps + 1):
        if i % every == 0:
            r = out[i // every]
            r[0] = x
            r[1] = y
            r[2] = th
            r[3] = vx
            r[4] = vy
            r[5] = om
            r[6] = ww[0]
            r[7] = ww[1]
            r[8] = angle[0]
            r[9] = angle[1]
        t = i * dt
        td = t - p.delay
        while k + 1 < times.shape[0] and times[k + 1] <= td:
            k += 1
        ul = left[k] if td >= times[0] else 0.0
        ur = right[k] if td >= times[0] else 0.0
        c, s = math.cos(th), math.sin(th)
        # commands -> effective
        ctl = ul + p.cross_talk * ur
        ctr = ur + p.cross_talk * ul
        heading = 1.0 + p.heading_gain * math.cos(th - p.heading_phase)
        charge += (abs(ul) + abs(ur)) * dt
        weak = 1.0 - p.sag_charge * charge - p.sag_load * (abs(ul) + abs(ur))
        speed = math.hypot(vx, vy)
        moving = speed > 0.008 or abs(om) > 0.05
        slip_mu = p.mu
        inside = 0.0
        if p.patch_drag != 0.0 or p.patch_mu != 1.0:
            dist = math.hypot(x - p.patch_x, y - p.patch_y)
            inside = 1.0 if dist < p.patch_r else 0.0
        half = 0.5 * axle
        for w in range(2):
            u = ctl if w == 0 else ctr
            u = _shape_command(
                u, p.deadband, p.saturation, p.curve, (p.reverse_left if w == 0 else p.reverse_right)
            )
            g = (p.gain_left if w == 0 else p.gain_right) * weak * heading
            g *= 1.0 + (p.warm_left if w == 0 else p.warm_right) * (1.0 - math.exp(-t / p.warm_time))
            if p.fault_start <= t < p.fault_end:
                g *= 1.0 - (p.fault_left if w == 0 else p.fault_right)
            stall = p.stall
            drive = g * u - wm[w] / p.no_load
            if drive * wm[w] < 0.0:
                stall *= 1.0 - p.brake_fade
            torque = stall * drive
            torque -= (p.coulomb_left if w == 0 else p.coulomb_right) * math.tanh(wm[w] / 0.15)
            lever = half if w == 0 else -half
            cvx = vx - om * lever
            rr = radius * (
                1.0
                + (p.ecc_left if w == 0 else p.ecc_right)
                * math.cos(angle[w] + (p.phase_left if w == 0 else p.phase_right))
            )
            load = m * G * p.load_share
            mu = slip_mu * (p.patch_mu if inside > 0.0 else 1.0)
            f0, _g0, slope = _tyre(ww[w], rr, cvx, vy, mu * load, p.stiffness, p.v0, p.lateral_soft)
            jm, jw = p.rotor_inertia, p.wheel_inertia
            damping = stall / p.no_load
            play = p.play
            if play <= 0.0:
                rate = (
                    (torque - rr * f0) / (jm + jw) * dt / (1.0 + dt / (jm + jw) * (rr * rr * slope + damping))
                )
                ww[w] += rate
                wm[w] = ww[w]
            else:
                am = torque / jm * dt / (1.0 + dt / jm * damping)
                aw = -rr * f0 / jw * dt / (1.0 + dt / jw * rr * rr * slope)
                at_top = gap[w] >= 0.5 * play
                at_bottom = gap[w] <= -0.5 * play
                together = (at_top and wm[w] + am >= ww[w] + aw) or (at_bottom and wm[w] + am <= ww[w] + aw)
                if together:
                    common = (jm * wm[w] + jw * ww[w]) / (jm + jw)
                    common += (
                        (torque - rr * f0)
                        / (jm + jw)
                        * dt
                        / (1.0 + dt / (jm + jw) * (rr * rr * slope + damping))
                    )
                    wm[w] = common
                    ww[w] = common
                else:
                    wm[w] += am
                    ww[w] += aw
                    gap[w] = min(max(gap[w] + (wm[w] - ww[w]) * dt, -0.5 * play), 0.5 * play)
            f1, g1, slope = _tyre(ww[w], rr, cvx, vy, mu * load, p.stiffness, p.v0, p.lateral_soft)
            fx[w] = f1
            fy[w] = g1
            angle[w] += ww[w] * dt
        force_x = fx[0] + fx[1]
        force_y = fy[0] + fy[1]
        moment = half * (fx[1] - fx[0])
        # caster: rolling drag along its own wheel, scrubbing across it while it swivels
        if p.caster_drag > 0.0:
            kx, ky = vx, vy + om * p.caster_x
            ks = math.hypot(kx, ky)
            if ks > 1e-4:
                to = math.atan2(ky, kx)
                psi -= ks / p.caster_trail * math.sin(psi - to) * dt
                fade = math.tanh(ks / 0.01)
                along = -p.caster_drag * math.cos(psi - to) * fade
                across = -p.caster_scrub * math.sin(to - psi) * fade
                cfx = along * math.cos(psi) - across * math.sin(psi)
                cfy = along * math.sin(psi) + across * math.cos(psi)
                force_x += cfx
                force_y += cfy
                moment += p.caster_x * cfy
        moment -= p.scrub_dry * math.tanh(om / 0.12) + p.scrub_wet * om
        # world-frame forces
        wx = -m * G * p.tilt_x
        wy = -m * G * p.tilt_y
        if p.bowl_k != 0.0:
            wx -= p.bowl_k * (x - p.bowl_x)
            wy -= p.bowl_k * (y - p.bowl_y)
        if p.tether_k > 0.0:
            wx -= p.tether_k * (x - p.tether_x)
            wy -= p.tether_k * (y - p.tether_y)
        if p.gust_f != 0.0:
            wx += p.gust_f * math.sin(2 * math.pi * t / p.gust_period + p.gust_phase)
        if speed > 1e-4:
            fade = math.tanh(speed / 0.01)
            if p.nap > 0.0:
                travel = math.atan2(s * vx + c * vy, c * vx - s * vy)
                drag = p.nap * 0.5 * (1.0 + math.cos(travel - p.nap_direction)) * fade
                force_x -= drag * vx / speed
                force_y -= drag * vy / speed
            if inside > 0.0 and p.patch_drag > 0.0:
                force_x -= p.patch_drag * fade * vx / speed
                force_y -= p.patch_drag * fade * vy / speed
        force_x += c * wx + s * wy
        force_y += -s * wx + c * wy
        moment -= p.twist_k * (th - theta_start)
        if p.push_time <= t < p.push_time + PUSH_LENGTH:
            force_x += p.push_fx
            force_y += p.push_fy
            moment += p.push_m
        if noise.shape[0] > 1:
            of = a_ou * of + b_ou * noise[i, 0]
            omt = a_ou * omt + b_ou * noise[i, 1]
            if moving:
                force_x += p.ou_force * of
                moment += p.ou_moment * omt
        # centre of mass away from the axle's centre: forces act at base, motion of the base follows
        cx, cy = p.com_x, p.com_y
        # m (a_base + alpha x r - om^2 r) = F ; I alpha = M - r x F about the centre of mass
        bx = force_x + m * vy * om + m * om * om * cx
        by = force_y - m * vx * om + m * om * om * cy
        al = (moment - (cx * force_y - cy * force_x)) / inertia
        ax = bx / m + al * cy
        ay = by / m - al * cx
        vx += ax * dt
        vy += ay * dt
        om += al * dt
        th_mid = th + 0.5 * om * dt
        x += (math.cos(th_mid) * vx - math.sin(th_mid) * vy) * dt
        y += (math.sin(th_mid) * vx + math.cos(th_mid) * vy) * dt
        th += om * dt
    return out


def simulate(
    physics: Physics,
    times: np.ndarray,
    left: np.ndarray,
    right: np.ndarray,
    start: np.ndarray,
    duration: float,
    rng: np.random.Generator | None,
    *,
    step: float = 0.0005,
    every: int = 4,
) -> tuple[np.ndarray, np.ndarray]:
    """Drive the robot by held commands; return times (n,) [s] and states (n, 10) in the order of `STATE`.

    `rng` None leaves the random force and moment out.
    """
    n = round(duration / step)
    noise = rng.standard_normal((n + 1, 2)) if rng is not None else np.zeros((1, 2))
    states = _simulate(Physics(*map(float, physics)), times, left, right, start, n, step, every, noise)
    return np.arange(states.shape[0]) * step * every, states
