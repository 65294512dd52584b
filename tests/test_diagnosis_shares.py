"""Which sure names are worth saying: those that matter, and what is no habit of every robot."""

from types import SimpleNamespace

import pytest

from fsm_calib.diagnosis.candidates.ranked import EXACT
from fsm_calib.diagnosis.verdict import shares
from fsm_calib.diagnosis.verdict.shares import TELLING, Taken, worth_saying
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameters

LITTLE, ENOUGH = 0.5 * EXACT, 2.0 * EXACT


def said(monkeypatch: pytest.MonkeyPatch, **taken: float) -> list[str]:
    """Return the names that are said of sure ones, strongest first, that take these shares of the error."""
    monkeypatch.setattr(
        shares, "taken_by", lambda *given: {n: Taken(share, 1.0) for n, share in taken.items()}
    )
    return names_of([SimpleNamespace(name=name) for name in taken])


def names_of(named: list[SimpleNamespace], axle_length: float = 0.1, **numbers: float) -> list[str]:
    """Return the names that are worth saying of some, of a model with numbers `effect__name` of its own."""
    robot = SimpleNamespace(geometry=(0.5 * axle_length,))
    engine = SimpleNamespace(simulators=[SimpleNamespace(prepared=robot, full_speed=0.6)])
    values = parameters({name.replace("__", "."): value for name, value in numbers.items()})
    model = SimpleNamespace(fit=SimpleNamespace(values=values[None]))
    return [belief.name for belief in worth_saying(engine, None, model, named)]  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["caster_drag", "tyre_scrub", "coulomb_friction", "payload_offset"])
def test_what_every_robot_has_is_said_where_it_matters(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    assert said(monkeypatch, sensor_yaw=0.5, **{name: ENOUGH}) == ["sensor_yaw", name]
    assert said(monkeypatch, sensor_yaw=0.5, **{name: LITTLE}) == ["sensor_yaw"]


def test_what_every_robot_has_is_said_where_the_error_is_clearly_larger_without_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    named = [SimpleNamespace(name=name) for name in ("caster_drag", "sensor_offset")]
    for times, said_too in ((TELLING, True), (0.9 * TELLING, False)):
        taken = {"caster_drag": Taken(0.99, 200.0), "sensor_offset": Taken(LITTLE, times)}
        monkeypatch.setattr(shares, "taken_by", lambda *given, taken=taken: taken)
        assert ("sensor_offset" in names_of(named)) is said_too


@pytest.mark.parametrize(
    ("ahead", "axle_length", "said_too"), [(0.02, 0.1, True), (0.01, 0.1, False), (0.02, 0.6, False)]
)
def test_a_mass_as_far_off_as_a_load_puts_it_is_said_however_little_it_takes(
    monkeypatch: pytest.MonkeyPatch, ahead: float, axle_length: float, said_too: bool
) -> None:
    taken = {"tyre_scrub": Taken(0.99, 200.0), "payload_offset": Taken(LITTLE, 1.0)}
    monkeypatch.setattr(shares, "taken_by", lambda *given: taken)
    named = [SimpleNamespace(name=name) for name in taken]
    assert ("payload_offset" in names_of(named, axle_length, payload_offset__x=ahead)) is said_too


def test_a_fault_is_said_however_little_it_takes(monkeypatch: pytest.MonkeyPatch) -> None:
    assert said(monkeypatch, payload_offset=0.5, misplaced_marker=0.0) == [
        "payload_offset",
        "misplaced_marker",
    ]


def test_the_strongest_name_is_said_whatever_it_takes(monkeypatch: pytest.MonkeyPatch) -> None:
    assert said(monkeypatch, lateral_slip=LITTLE, tyre_scrub=LITTLE) == ["lateral_slip"]


def test_universal_physics_resistances_and_mountings_are_what_every_robot_has() -> None:
    usual = {name for name, effect in registry().items() if effect.usual}
    resisting = {"coulomb_friction", "tyre_scrub", "caster_drag"}
    assert usual == {"payload_offset", "lateral_slip", *resisting, "sensor_offset", "sensor_yaw"}
