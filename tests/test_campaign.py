"""A sample of the fuzz campaign finds nothing, and the campaign finds and shrinks what is planted."""

import importlib.util
import os
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from recording_samples import ROOT

from fsm_calib.errors import InputError

sys.path.insert(0, str(ROOT / "benchmarks"))
_spec = importlib.util.spec_from_file_location("campaign", ROOT / "benchmarks" / "campaign.py")
campaign = importlib.util.module_from_spec(_spec)
sys.modules["campaign"] = campaign
_spec.loader.exec_module(campaign)
import campaign_door  # noqa: E402 - beside the benchmark
from campaign_readers import DOORS, KINDS, Kind, damaged_text  # noqa: E402

FEW = {"fitted recording": 2}
TOO_SHORT = {"manifest and CSV"}  # its sound form has too few poses to fit


@pytest.mark.parametrize("name", sorted(KINDS))
def test_sample_of_damaged_input_is_read_or_refused_with_a_sentence(name: str, tmp_path: Path) -> None:
    found = campaign.Campaign.opened(tmp_path, 20)
    found.run(name, KINDS[name], KINDS[name].sound(), FEW.get(name, 20))
    assert found.findings == {}
    assert sum(found.counts[name].values()) == FEW.get(name, 20)


@pytest.mark.parametrize("name", sorted(KINDS.keys() - TOO_SHORT))
def test_sound_input_is_read(name: str) -> None:
    assert campaign.judge(KINDS[name], KINDS[name].sound()) == ("read", "")


@pytest.mark.parametrize("name", ["scenario, validate", "Duckietown bag, identify"])
def test_damaged_input_given_to_a_command_ends_with_a_code_and_a_sentence(
    name: str, tmp_path: Path, capfd: pytest.CaptureFixture
) -> None:
    found = campaign.Campaign.opened(tmp_path, 21)
    with capfd.disabled():  # a child's words go to its own log
        found.run(name, DOORS[name], DOORS[name].sound(), 3)
    assert found.findings == {}
    assert sum(found.counts[name].values()) == 3


def through_a_door(work: Callable[[], int], monkeypatch: pytest.MonkeyPatch) -> tuple[str, str]:
    """Return what is judged of a command that does `work` in its folder for results, here the present one."""
    monkeypatch.setattr(campaign_door, "command", lambda arguments: lambda: os.chdir(arguments[0]) or work())
    return campaign.judge(replace(PLANTED, read=campaign_door.through("{out}")), PLANTED.sound())


def test_a_command_that_fails_and_leaves_a_file_is_a_finding(monkeypatch: pytest.MonkeyPatch) -> None:
    def half(code: int) -> int:
        Path("half.json").write_text("{")
        return os.write(2, b"fsm-calib: no.\n") and code

    assert through_a_door(lambda: half(2), monkeypatch)[1].startswith("Wrong at campaign_door.py")
    assert through_a_door(lambda: half(0), monkeypatch)[1].startswith("JSONDecodeError at")


def test_a_command_that_fails_with_a_sentence_alone_is_right(monkeypatch: pytest.MonkeyPatch) -> None:
    assert through_a_door(lambda: os.write(2, b"fsm-calib: no.\n") and 2, monkeypatch) == ("refused", "no.")
    assert through_a_door(lambda: 2, monkeypatch)[0] == "finding"


def fragile(folder: Path) -> None:
    """Fail on a full stop in an unforeseen way, on a comma with a sentence that a terminal would obey."""
    text = (folder / "a.txt").read_text("utf-8", "replace")
    if "." in text:
        raise ZeroDivisionError
    raise InputError(f"bad {text}")


PLANTED = Kind(lambda: {"a.txt": b"some words. and more of them"}, damaged_text, fragile)


def test_unforeseen_exception_is_a_finding_with_its_place() -> None:
    verdict, said = campaign.judge(PLANTED, PLANTED.sound())
    assert verdict == "finding"
    assert said.startswith("ZeroDivisionError at test_campaign.py:")
    assert campaign.judge(PLANTED, {"a.txt": b"\x1b[2J"})[0] == "refused"


def test_reading_that_makes_changes_or_removes_a_file_is_a_finding() -> None:
    def clumsy(folder: Path) -> None:
        (folder / "a.txt").write_text("other words")
        (folder / "b.txt").unlink()
        (folder / "new").mkdir()

    kind = Kind(PLANTED.sound, damaged_text, clumsy)
    said = "a.txt was changed or removed, b.txt was changed or removed, new was made"
    assert campaign.judge(kind, {"a.txt": b"words", "b.txt": b"", "c.txt": b""}) == ("finding", said)


def test_kinds_take_turns_until_all_together_have_had_their_inputs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    calm = Kind(PLANTED.sound, damaged_text, lambda folder: None, turn=4)
    monkeypatch.setattr(campaign, "KINDS", {"calm": calm, "slow": replace(calm, turn=1)})
    found = campaign.Campaign.opened(tmp_path, 3)
    campaign.fuzz(found, ["calm", "slow"], 12, 60.0)
    assert found.done == {"calm": 10, "slow": 2}


def test_finding_is_shrunk_to_what_makes_it() -> None:
    said = campaign.judge(PLANTED, PLANTED.sound())[1]
    assert campaign.shrunk(PLANTED, PLANTED.sound(), said) == {"a.txt": b"."}


def test_hang_is_a_finding(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(campaign, "LONGEST_ANSWER", 0.05)

    def endless(folder: Path) -> None:
        while True:
            pass

    assert campaign.judge(Kind(PLANTED.sound, damaged_text, endless), PLANTED.sound()) == ("finding", "hang")


def test_campaign_goes_on_where_it_was_and_keeps_repro_and_report(tmp_path: Path) -> None:
    first = campaign.Campaign.opened(tmp_path, 3)
    first.run("planted", PLANTED, PLANTED.sound(), 10)
    first.save()
    again = campaign.Campaign.opened(tmp_path, 3)
    again.run("planted", PLANTED, PLANTED.sound(), 5)
    again.save()
    assert again.done == {"planted": 15}
    (key,) = again.findings
    assert (tmp_path / "repro" / key / "a.txt").read_bytes() == b"."
    assert f"repro/{key}" in (tmp_path / "report.md").read_text()
    with pytest.raises(SystemExit, match="seed 3"):
        campaign.Campaign.opened(tmp_path, 4)


def test_memory_that_the_process_held_before_is_no_finding(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sizes = iter([3 << 20, (3 << 20) + 5, 5 << 20])
    monkeypatch.setattr(campaign, "largest_held", lambda: next(sizes))
    sound = Kind(PLANTED.sound, lambda files, rng: files, lambda folder: None)
    found = campaign.Campaign(tmp_path, 3, held_before=campaign.largest_held())
    found.run("planted", sound, PLANTED.sound(), 1)
    assert found.findings == {}
    found.run("planted", sound, PLANTED.sound(), 1)
    assert [finding["found"] for finding in found.findings.values()] == ["memory above 1 GB"]
