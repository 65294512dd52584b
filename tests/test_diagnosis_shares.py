"""Which sure names are worth saying: those that matter, and what is no habit of every robot."""

from types import SimpleNamespace

import pytest

from fsm_calib.diagnosis.proof.gates import EXACT
from fsm_calib.diagnosis.verdict import shares
from fsm_calib.diagnosis.verdict.shares import TELLING, Taken, worth_saying
from fsm_calib.world2d.effects import registry

LITTLE, ENOUGH = 0.5 * EXACT, 2.0 * EXACT


def said(monkeypatch: pytest.MonkeyPatch, **taken: float) -> list[str]:
    """Return the names that are said of sure ones, strongest first, that take these shares of the error."""
    monkeypatch.setattr(
        shares, "taken_by", lambda *given: {n: Taken(share, 1.0) for n, share in taken.items()}
    )
    named = [SimpleNamespace(name=name) for name in taken]
    return [belief.name for belief in worth_saying(None, None, None, named)]  # type: ignore[arg-type]


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
        names = [b.name for b in worth_saying(None, None, None, named)]  # type: ignore[arg-type]
        assert ("sensor_offset" in names) is said_too


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
