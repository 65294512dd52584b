"""Names of the numbers that one integration step works on: the state `S` and the workbench `W`.

Both are flat arrays of float64, because that is what compiled code passes around for nothing. An effect's
hook reads and changes entries of `W` (and its own memory at the end of `S`) by these names. Pairs are left
then right, so that `W[TARGET + side]` with side 0 (left) or 1 (right) works. Frames and units are those of
`fsm_calib.types`.
"""

from __future__ import annotations

# ---- S: the state of the robot ----
X, Y, THETA = 0, 1, 2
"""Pose of `base` (axle centre) in `world` [m, m, rad]; theta is not wrapped."""
V, L, OMEGA = 3, 4, 5
"""Velocity of the axle centre, forward and left in `base` [m/s], and yaw rate [rad/s]."""
ANGLE = 6
"""Angles of the wheels, left and right [rad] (slots 6, 7)."""
RIM = 8
"""Speed of the rims relative to the axle [m/s] (slots 8, 9): an encoder's rate times the wheel's radius."""
TIME = 10
"""Time since the start of the roll-out [s]."""
HEADING_COS, HEADING_SIN = 11, 12
"""Cosine and sine of theta, carried along because they are what a step needs."""
MEMORY = 13
"""First slot of the effects' memories."""

# ---- W: the workbench of one step ----
STEP = 0
"""Length of the step [s]."""
COMMAND = 1
"""Shaped commands, mean over the step [1] (1, 2)."""
TARGET = 3
"""No-load rim speed that the motors strive for [m/s] (3, 4)."""
DRIVE = 5
"""Slope of the motors' torque-speed line at the rim [N s/m] (5, 6)."""
DRY = 7
"""Dry friction that resists a turning wheel, at the rim [N] (7, 8)."""
GRIP = 9
"""Largest force that a tyre can pass, friction coefficient times wheel load [N] (9, 10)."""
SLIP_SPEED = 11
"""Slip speed at which a tyre passes 1/sqrt(2) of its grip [m/s]."""
SIDE_COMPLIANCE = 12
"""Additional compliance of the tyres sideways [s m/N]: slip speed per force."""
FORCE_X, FORCE_Y, MOMENT = 13, 14, 15
"""Forces along the axes of `base` [N] and the moment about the axle centre [N m]."""
DAMP = 16
"""Damping of (V, L, OMEGA), symmetric: xx, xy, xt, yy, yt, tt (16 to 21) [N s/m, N s, N m s]."""
MASS, INERTIA = 22, 23
"""Mass [kg] and yaw inertia about the centre of mass [kg m2]."""
COM_X, COM_Y = 24, 25
"""Centre of mass in `base` [m]."""
PLACE_X, PLACE_Y, COS, SIN = 26, 27, 28, 29
"""Where the robot is for effects that depend on place or heading: measured when a track is given, else
simulated."""
ROLL = 30
"""Angles of the wheels for effects that depend on them [rad] (30, 31): from the track when given, else
simulated."""
HALF_AXLE = 32
"""Half the distance between the wheels [m]."""
RADIUS = 33
"""Radii of the wheels [m] (33, 34)."""
MEAN_VX, MEAN_VY, MEAN_OMEGA = 35, 36, 37
"""Mean velocity of the centre of mass in `world` [m/s] and mean yaw rate [rad/s] over the step."""
NEXT_VX, NEXT_VY = 38, 39
"""Velocity of the centre of mass in `world` after the step [m/s]."""
LOAD = 40
"""Wheel loads [N] (40, 41)."""
ENGAGED = 42
"""How much of the step the motors' gears are engaged, 0 to 1 (42, 43)."""
BASE_DRIVE, ROTATING = 44, 45
"""The base's DRIVE [N s/m], and the rotating inertia of a wheel and its motor as a mass at the rim [kg]."""
LAST_SLIP = 46
"""Slip of the tyres in the step before [m/s] (46, 47): the search for the next begins where it was going."""
WHEEL_ENCODER = 48
"""Whether encoders turn with the wheels (1) or with the motors (0); they differ while gears are in their play."""
FREE_ROTATING = 49
"""The part of ROTATING that turns with the motor alone while its gears are in their play [kg]."""
SLIP_TREND = 50
"""How much the slip of the tyres changed in the step before [m/s] (50, 51)."""
HOOKED = 52
"""Whether any effect acts in a step (1) or none (0)."""
SIDE_DRIFT = 53
"""Sideways speed that bent tyres and springs add to the motion without a force of their own [m/s]."""
SLIP_RATIO = 54
"""Slip over rolling speed at which a rolling tyre passes 1/sqrt(2) of its grip [1]."""
INVERSE = 55
"""Inverse of the mass matrix of this step, by rows (55 to 63): change of (V, L, OMEGA) by an impulse."""
CONTACTS, CONTACT = 64, 65
"""How many dry contacts brake the body in this step, and what is kept of them, one after the other (`dry_contacts`)."""
MOST_CONTACTS, CONTACT_SIZE = 8, 15
"""How many there may be, and the numbers that are kept of each."""
CARRIED_X = CONTACT + MOST_CONTACTS * CONTACT_SIZE
CARRIED_Y = CARRIED_X + 1
"""Velocity in `world` at which the floor's surface carries the robot, without a force of its own [m/s]."""
CEILING = CARRIED_Y + 1
"""No-load rim speeds that the motors' supply gives at most [m/s] (left, right); 0: it never ends."""
LOOP_GAIN = CEILING + 2
"""How much stiffer a speed loop's proportional gain makes the motors than they are [1]."""
HELD = LOOP_GAIN + 1
"""Whether a controller with an integral holds the wheels' speeds (1) or not (0)."""
BENCH_SIZE = HELD + 1

# ---- constants of the world ----
GRAVITY = 9.80665
"""Standard gravity [m/s2] (CGPM 1901)."""
CASTER_ARM = 0.083
"""Distance of the caster's pivot behind the axle [m] (Duckietown URDF, duckiebot.urdf.xacro, DB18)."""
SMALL_AXLE = 0.3
"""Axle length up to which a robot is a small one [m] (Duckiebot 0.1, Create 0.26): what is longer on a larger one grows
with its axle from here on."""
CREEP_SPEED = 1e-3
"""Speed below which dry friction of a place acts like a stiff damper [m/s]: a fifth of what tag poses can see in
1 s."""
EDGE = 0.01
"""Softness of the edges of places on the floor [m]: half the width of a wheel's contact (assumed)."""
