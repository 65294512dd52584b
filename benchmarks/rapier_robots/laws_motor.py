"""Laws of batteries, motors, gears and their friction."""

from __future__ import annotations

import math
from dataclasses import replace

from benchmarks.rapier_robots.engine import STEP
from benchmarks.rapier_robots.laws import Draw, law
from benchmarks.rapier_robots.setup import Setup, State, SupplyHook, TorqueHook


def current(st: State) -> float:
    """Return the mean size of both motors' currents, 1 at stall."""
    return 0.5 * (abs(st.load[0]) + abs(st.load[1]))


@law(
    "battery_sag",
    "1",
    0.005,
    0.6,
    "Peukert 1897: charge counts more at high currents; linear fall of voltage",
    needs="duty",
)
def peukert(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """The supply falls by `size` for the charge of 6 s at a tenth of stall current, current to the power 1.25."""
    unit = 6.0 * 0.1**1.25

    def make(run: int) -> SupplyHook:
        used = [0.0]

        def hook(st: State, volts: float) -> float:
            used[0] += current(st) ** 1.25 * STEP
            return volts * max(1.0 - size * used[0] / unit, 0.3)

        return hook

    s.supplies.append(make)
    return {"fall": size, "power": 1.25}


@law(
    "battery_sag",
    "1",
    0.01,
    0.6,
    "one cell of a pack is empty before the others (pack balancing notes)",
    needs="duty",
)
def empty_cell(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """A share `size` of the voltage is lost within some seconds once the cell's charge is used."""
    knee = d.between(0, 0.8, 1.8)

    def make(run: int) -> SupplyHook:
        used = [0.0]

        def hook(st: State, volts: float) -> float:
            used[0] += current(st) * STEP
            return volts * (1.0 - size / (1.0 + math.exp(-(used[0] - knee) / (0.1 * knee))))

        return hook

    s.supplies.append(make)
    return {"cell": size, "knee": knee}


@law(
    "battery_sag",
    "1",
    0.02,
    8.0,
    "slow diffusion as a ladder of RC members (Jossen 2006, battery dynamics)",
    needs="duty",
)
def diffusion_ladder(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """Voltage falls by `size` per stall current: a fifth at once, two fifths after 1 s, two fifths after 10 s."""

    def make(run: int) -> SupplyHook:
        slow = [0.0, 0.0]

        def hook(st: State, volts: float) -> float:
            amps = current(st)
            for n, tau in enumerate((1.0, 10.0)):
                slow[n] += (0.4 * size * amps - slow[n]) * STEP / tau
            return volts * max(1.0 - 0.2 * size * amps - slow[0] - slow[1], 0.3)

        return hook

    s.supplies.append(make)
    return {"fall": size}


@law(
    "motor_warmup",
    "1",
    0.01,
    0.6,
    "ferrite loses 0.2 %/K of flux, copper gains 0.39 %/K (motor makers' formulas)",
    needs="duty",
)
def warm_magnets(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """Flux falls by up to `size` as the motors run: free rate up, torque down."""
    tau, free, stall = d.between(0, 8.0, 18.0), s.plant.free, s.plant.stall

    def make(run: int) -> TorqueHook:
        heat = [0.0, 0.0]

        def hook(st: State, k: int, duty: float, torque: float) -> float:
            heat[k] += (min(2.0 * abs(duty), 1.0) - heat[k]) * STEP / tau
            flux = 1.0 - size * heat[k]
            back = (1.0 - flux * flux) * st.rate[k] / free[k]
            return torque - stall[k] * ((1.0 - flux) * duty * st.volts - back)

        return hook

    s.torques.append(make)
    return {"flux": size, "warm_s": tau}


@law(
    "motor_warmup",
    "1",
    0.003,
    1.0,
    "gear grease thins by shear and heat (grease makers' cold-start curves)",
    needs="duty",
)
def worked_grease(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """Viscous drag of `size` of the motor's own line, that fades by the turned angle."""
    way = d.between(0, 15.0, 45.0) / (s.plant.radius[0] * 10.0)
    drag = [size * s.plant.stall[k] / s.plant.free[k] for k in (0, 1)]

    def make(run: int) -> TorqueHook:
        turned = [0.0, 0.0]

        def hook(st: State, k: int, duty: float, torque: float) -> float:
            turned[k] += abs(st.rate[k]) * STEP
            return torque - drag[k] * st.rate[k] * math.exp(-turned[k] / way)

        return hook

    s.torques.append(make)
    return {"drag": size, "way_rad": way}


@law(
    "motor_fault",
    "rad",
    0.02,
    4.0,
    "burnt commutator bars: no torque over part of a turn (brush motor failure guides)",
    needs="duty",
)
def burnt_bars(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """One wheel's motor gives a tenth over `size` [rad] of each turn of the wheel, in four places."""
    side = d.side(0)

    def hook(st: State, k: int, duty: float, torque: float) -> float:
        return 0.1 * torque if k == side and (st.angle[k] % (0.5 * math.pi)) < 0.25 * size else torque

    s.torques.append(lambda run: hook)
    return {"arc_rad": size, "wheel": float(side)}


@law(
    "motor_fault",
    "1",
    0.02,
    4.0,
    "brush lifts off at speed: worn spring (carbon brush handbooks)",
    needs="duty",
)
def lifting_brush(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """One wheel loses torque as its rate squared: 1 / (1 + size (rate / free)^2) of what drives it."""
    side, free = d.side(0), s.plant.free

    def hook(st: State, k: int, duty: float, torque: float) -> float:
        if k != side or torque * st.rate[k] < 0:
            return torque
        return torque / (1.0 + 20.0 * size * (st.rate[k] / free[k]) ** 2)

    s.torques.append(lambda run: hook)
    return {"lift": size, "wheel": float(side)}


def bunches(
    d: Draw, run: int, many: tuple[int, int], length: tuple[float, float]
) -> list[tuple[float, float]]:
    """Return spans of time [s] spread over a run, between 3 s and its end."""
    rng = d.rng(run)
    count = int(rng.integers(many[0], many[1] + 1))
    slot = (d.seconds - 5.0) / count
    spans = []
    for n in range(count):
        start = 3.0 + slot * (n + float(rng.uniform(0.0, 0.5)))
        spans.append((start, start + min(float(rng.uniform(*length)), 0.5 * slot)))
    return spans


@law(
    "motor_fault",
    "1",
    0.02,
    1.0,
    "a cracked lead opens in bunches as it flexes (connector intermittency, MIL-STD-1344)",
    local=True,
    needs="duty",
)
def cracked_lead(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """In four to six bunches a run one motor loses `size` of its torque, on and off in flickers of 0.08 s."""
    side = d.side(0)

    def make(run: int) -> TorqueHook:
        spans, rng = bunches(d, run, (4, 6), (1.2, 3.0)), d.rng(run + 50)
        flip = [0.0, 0.0]

        def hook(st: State, k: int, duty: float, torque: float) -> float:
            if k != side or not any(a <= st.t < b for a, b in spans):
                return torque
            st.touched = True
            if st.t >= flip[0]:
                flip[0], flip[1] = st.t + float(rng.exponential(0.08)), 1.0 - flip[1]
            return torque * (1.0 - size * flip[1])

        return hook

    s.torques.append(make)
    return {"loss": size, "wheel": float(side)}


@law(
    "coulomb_friction",
    "1",
    0.002,
    0.2,
    "overtight belt loads its bearings (timing belt makers' tension guides)",
    needs="duty",
)
def overtight_belt(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """Dry friction of `size` of the stall torque more in both drives, not quite alike."""
    share = d.between(0, 0.75, 1.25)
    more = (size * share * s.plant.stall[0], size * (2.0 - share) * s.plant.stall[1])
    s.plant = replace(s.plant, dry=(s.plant.dry[0] + more[0], s.plant.dry[1] + more[1]))
    return {"share": size}


@law(
    "coulomb_friction",
    "1",
    0.01,
    2.0,
    "worm gear: friction goes with the load on its teeth (Niemann, Machine Elements)",
    needs="duty",
)
def worm_gear(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """Dry friction of `size` of the torque at hand and of 0.02 of the stall torque."""
    stall = s.plant.stall

    def hook(st: State) -> None:
        for k in (0, 1):
            st.hold[k] += size * stall[k] * (0.02 + abs(st.load[k]))

    s.floors.append(lambda run: hook)
    return {"share": size}


@law(
    "coulomb_friction",
    "1",
    0.002,
    0.2,
    "seals that give before they slide (Dahl 1968, solid friction)",
    needs="duty",
)
def dahl_seal(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """Friction of `size` of the stall torque that builds up over 0.04 rad of turning."""
    stall, way = s.plant.stall, 0.04

    def make(run: int) -> TorqueHook:
        bent = [0.0, 0.0]

        def hook(st: State, k: int, duty: float, torque: float) -> float:
            go = st.rate[k] * STEP / way
            bent[k] = min(max(bent[k] + go - abs(go) * bent[k], -1.0), 1.0)
            return torque - size * stall[k] * bent[k]

        return hook

    s.torques.append(make)
    return {"share": size, "way_rad": way}


@law(
    "motor_reverse_asymmetry",
    "1",
    0.01,
    0.9,
    "thrust of helical teeth presses on a washer one way (Shigley, helical gears)",
    needs="duty",
)
def thrust_washer(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """Backwards `size` of the driving torque is lost."""

    def hook(st: State, k: int, duty: float, torque: float) -> float:
        return torque * (1.0 - size) if torque < 0 and st.rate[k] < 0 else torque

    s.torques.append(lambda run: hook)
    return {"loss": size}


def played(s: Setup, left: float, right: float) -> None:
    """Give the gears play [rad]."""
    s.plant = replace(s.plant, play=(left, right))


@law(
    "gear_backlash",
    "rad",
    0.01,
    0.6,
    "play of hobby gear trains at the output, 1 to 8 degrees (gear motor data sheets)",
)
def stiff_mesh(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """Both gears have play."""
    played(s, size, size)
    return {"play_rad": size}


@law("gear_backlash", "rad", 0.01, 0.9, "a set screw that has come loose on a flattened shaft")
def loose_set_screw(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """One hub turns freely on its shaft within the flat; the other has a tenth of it."""
    side = d.side(0)
    played(s, size if side == 0 else 0.1 * size, size if side == 1 else 0.1 * size)
    return {"screw_play_rad": size, "wheel": float(side)}
