"""There is one verdict on a motion, the worst first: the same in text, JSON and pages, and nothing green beside red."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import ROBOTS, run
from helpers.html_pages import checked

MOTION = str(ROBOTS / "puma560_sweep.csv")
PEAKS = {"waist": 10.94, "shoulder": 53.24, "elbow": 11.21}
GREEN = ("No limit", "keep to them", "kept", "✅", "verdict good")


def scene_and_robot(seed: int, folder: Path) -> tuple[str, str]:
    """The PUMA 560 with limits of effort and motors that its sweep keeps or exceeds, as a draw has it."""
    rng = np.random.default_rng(seed)
    urdf = (ROBOTS / "puma560.urdf").read_text()
    efforts = iter(rng.choice([1e-3, 1e3], 6, p=[0.15, 0.85]))
    (folder / "arm.urdf").write_text(re.sub(r'effort="[^"]*"', lambda _: f'effort="{next(efforts):g}"', urdf))
    lines = ["[motor]"]
    for joint, peak in PEAKS.items():
        gear = 100.0
        continuous, most = (peak / gear * rng.choice([0.3, 3.0], p=[0.3, 0.7]) for _ in range(2))
        torques = f"continuous = {min(continuous, most):.4g}, peak = {most:.4g}"
        lines.append(f"{joint} = {{ gear = {gear}, {torques}, max_speed = {rng.choice([100.0, 1e4])} }}")
    (folder / "motors.toml").write_text("\n".join(lines))
    return str(folder / "arm.urdf"), str(folder / "motors.toml")


@pytest.mark.parametrize("seed", [1, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (0, 2))])
def test_one_verdict_in_all_forms(seed: int, tmp_path: Path) -> None:
    robot, scene = scene_and_robot(seed, tmp_path)
    page, markdown = tmp_path / "page.html", tmp_path / "page.md"
    call = ("torques", robot, MOTION, "--scene", scene) if seed % 4 else ("torques", robot, MOTION)
    outcome = run(*call, "--report", str(page), "--fail-on-limits")
    run(*call, "--report", str(markdown))
    found = json.loads(run(*call, "--format", "json").out)
    verdict, last = found["verdict"], outcome.out.splitlines()[-1]
    assert last.startswith(verdict["headline"])
    shown = checked(page.read_text())
    (block,) = [each for each in shown.elements if "verdict" in (each.attributes.get("class") or "").split()]
    assert block.attributes["class"] == f"verdict {verdict['level']}"
    assert " ".join(shown.all("main")[0].text.split()).startswith(verdict["headline"])
    exceeded = bool(found["limits_exceeded"]) or any(
        each["exceeded"] for each in found.get("sizing", {}).get("joints", ())
    )
    assert (verdict["level"] == "bad") == exceeded == (outcome.status == 1) == (found["within_limits"] is False)
    if exceeded:
        assert last.startswith(f"{verdict['headline']}: {verdict['reasons'][0]}")
        for text in (outcome.out, page.read_text().partition("<main")[2], markdown.read_text(), json.dumps(verdict)):
            assert not any(word in text for word in GREEN)
        names = {each["joint"] for each in found["limits_exceeded"]}
        names |= {each["name"] for each in found.get("sizing", {}).get("joints", ()) if each["exceeded"]}
        assert verdict["headline"].startswith(f"{len(names)} of 6 joints ")
        assert all(any(reason.startswith(name) for reason in verdict["reasons"]) for name in names)


def test_the_worst_comes_first() -> None:
    """What breaks before what wears, and each by how many times its limit it is."""
    scene = str(ROBOTS / "puma560_sizing.toml")
    outcome = run("torques", str(ROBOTS / "puma560.urdf"), MOTION, "--scene", scene)
    over = [line.split(" ", 1)[0] for line in outcome.out.splitlines() if "OVER" in line]
    assert over == ["wrist_pitch", "flange_roll", "wrist_roll"]
    assert ": wrist_pitch: the motor's torque is 0.02663 N m, 274 % above" in outcome.out.splitlines()[-1]


def test_an_accuracy_that_is_not_met_is_red_though_limits_are_kept(tmp_path: Path) -> None:
    table = np.genfromtxt(MOTION, delimiter=",", names=True)
    names = [name for name in table.dtype.names if not name.startswith("qd")]
    noisy = np.column_stack([np.round(table[name], 4) for name in names])
    np.savetxt(tmp_path / "noisy.csv", noisy, delimiter=",", header=",".join(names), comments="", fmt="%.6f")
    call = ("torques", str(ROBOTS / "puma560.urdf"), str(tmp_path / "noisy.csv"), "--accuracy", "1e-9")
    outcome = run(*call, "--report", str(tmp_path / "page.md"))
    assert outcome.status == 1
    assert outcome.out.splitlines()[-1].startswith("The accuracy asked for is not met: ")
    assert "✅" not in (tmp_path / "page.md").read_text()
