"""Joints whose names have no letter, beside columns that nobody knows."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.command_line import ARM, run


@pytest.mark.parametrize("name", ["_-", "-", "__", "é", "-1", "\uff0e", "q_", "_q_"])
@pytest.mark.parametrize("column", ["c", "_-x", "q_", "foo-bar", "-", "q_é", "٣"])
def test_a_joint_of_marks_alone(name: str, column: str, tmp_path: Path) -> None:
    (tmp_path / "r.urdf").write_text(ARM.replace('"elbow"', f'"{name}"'))
    (tmp_path / "t.csv").write_text(f"time,q_shoulder,{column}\n0,0,0\n1,1,1\n2,2,2\n3,3,3\n")
    outcome = run("torques", str(tmp_path / "r.urdf"), str(tmp_path / "t.csv"))
    assert outcome.status in (0, 2)
    assert "internal error" not in outcome.err, outcome.err
