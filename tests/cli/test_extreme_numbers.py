"""Numbers at the ends of floating point: a right result or one line of error, whatever is asked."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from helpers.command_line import motion, run
from helpers.mesh_files import ascii_stl
from helpers.mesh_samples import tetrahedron
from hypothesis import assume, example, given
from hypothesis import strategies as st

from robodyn.simulation import stiff_steps

URDF = """<robot name="arm">
  <link name="base"/>
  <link name="upper"><inertial><origin xyz="0.2 0 0" rpy="0.1 0 0"/><mass value="2"/>
    <inertia ixx="0.02" ixy="0.001" ixz="0" iyy="0.021" iyz="0.001" izz="0.022"/></inertial>
    <visual><origin xyz="0.1 0 0.2"/><geometry><box size="0.1 0.2 0.3"/></geometry></visual>
    <collision><geometry><mesh filename="part.stl" scale="1 1.5 2"/></geometry></collision></link>
  <link name="fore"><inertial><origin xyz="0.1 0 0.02"/><mass value="1"/>
    <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial>
    <visual><geometry><sphere radius="0.4"/></geometry></visual>
    <collision><geometry><cylinder radius="0.1" length="0.7"/></geometry></collision></link>
  <link name="tool"/>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 0.6 0.8"/>
    <limit effort="50" velocity="5" lower="-3" upper="3"/><dynamics damping="0.9" friction="0.35"/>
    <safety_controller soft_lower_limit="-2.9" soft_upper_limit="2.9" k_position="10" k_velocity="3"/></joint>
  <joint name="elbow" type="prismatic"><parent link="upper"/><child link="fore"/><origin xyz="0.4 0 0"/>
    <axis xyz="0 1 0"/><limit effort="50" velocity="5" lower="-3" upper="3"/></joint>
  <joint name="wrist" type="continuous"><parent link="fore"/><child link="tool"/><origin rpy="0.4 0 0"/>
    <mimic joint="elbow" multiplier="0.7" offset="0.05"/></joint>
  <transmission name="drive"><joint name="elbow"/>
    <actuator name="motor"><mechanicalReduction>55</mechanicalReduction></actuator></transmission>
</robot>
"""
SCENE = "gravity = [0, 0, -9.81]\n[friction.elbow]\nviscous = 0.1\ncoulomb = 0.2\n[initial.q]\nelbow = 0.1\n"
SIMULATE = ("simulate", "robot.urdf", "--scene", "scene.toml", "--duration", "0.01")
COMMANDS = [
    ("check", "robot.urdf"),
    ("info", "robot.urdf"),
    ("inertia", "robot.urdf", "--format", "json"),
    ("inertia", "part.stl"),
    ("torques", "robot.urdf", "motion.csv", "--scene", "scene.toml"),
    (*SIMULATE, "--step", "0.005"),
    (*SIMULATE, "--rtol", "1e-4"),
    ("fbd", "robot.urdf"),
    ("equations", "robot.urdf", "--form", "dae"),
    ("linearize", "robot.urdf", "--scene", "scene.toml"),
    ("envelope", "robot.urdf", "--scene", "scene.toml", "--format", "json"),
]
NUMBER = re.compile(r"(?<=[ \"\[>])-?\d+(?:\.\d+)?(?=[ \"\],<\n])")
STL = ascii_stl(tetrahedron(((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1))), number="%g").decode()
FILES = {"robot.urdf": URDF, "scene.toml": SCENE, "part.stl": STL}
PLACES = [(name, *found.span()) for name, text in FILES.items() for found in NUMBER.finditer(text)]
GRAVITY, VISCOUS, COULOMB = [place for place in PLACES if place[0] == "scene.toml"][2:5]
EXTREMES = st.sampled_from(
    [
        *("1e300", "-1e300", "1e155", "1e-155", "1e-300", "5e-324", "-0.0", "1.7976931348623157e308", "nan", "inf"),
        *("3e38", "1e200", "1e-200", "1e-110", "1e29", "-1e29", "1.1e-60", "1e-59", "1e-30", "1e15", "1e-320"),
    ]
)


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    (tmp_path / "motion.csv").write_text(motion(10))
    monkeypatch.chdir(tmp_path)


def answered(arguments: tuple[str, ...], quoted: bool) -> None:
    """A report without a number that is none, or one line of error with the file at fault."""
    outcome = run(*arguments)
    errors = [line for line in outcome.err.splitlines() if line.startswith("error:")]
    assert not any("internal error" in line for line in errors), errors
    assert outcome.status in (0, 1, 2)
    assert len(errors) == (outcome.status == 2), errors
    assert quoted or not re.search(r"\b(nan|inf|NaN|Infinity)\b", outcome.out), outcome.out


@given(st.lists(st.tuples(st.sampled_from(PLACES), EXTREMES), min_size=1, max_size=3), st.sampled_from(COMMANDS))
@example([(VISCOUS, "1e300")], (*SIMULATE, "--rtol", "1e-4"))
@example([(GRAVITY, "1e300")], ("linearize", "robot.urdf", "--scene", "scene.toml"))
@example([(COULOMB, "1.7976931348623157e308")], (*SIMULATE, "--rtol", "1e-4"))
def test_extreme_numbers_are_answered(
    changes: list[tuple[tuple[str, int, int], str]], command: tuple[str, ...]
) -> None:
    texts = dict(FILES)
    for (name, start, end), value in sorted(dict(changes).items(), reverse=True):
        assume(name != "part.stl" or value.lstrip("-") != "1e29")  # a needle so long that nothing of it is known
        texts[name] = texts[name][:start] + value + texts[name][end:]
    for name, text in texts.items():
        Path(name).write_text(text)
    answered(command, quoted=any(value in ("nan", "inf") for _, value in changes))


def changed(name: str, old: str, new: str) -> None:
    assert FILES[name].count(old) == 1
    Path(name).write_text(FILES[name].replace(old, new))


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ('ixx="0.02"', 'ixx="1e200"', 4),
        ('radius="0.4"', 'radius="1e200"', 9),
        ('xyz="0.4 0 0"', 'xyz="1e155 0 0"', 15),
        ('damping="0.9"', 'damping="1e308"', 13),
    ],
)
def test_numbers_beyond_all_robots_are_refused_with_their_line(old: str, new: str, line: int) -> None:
    changed("robot.urdf", old, new)
    for command in (("info", "robot.urdf"), SIMULATE, ("torques", "robot.urdf", "motion.csv")):
        outcome = run(*command)
        assert outcome.status == 2
        assert outcome.err.startswith(f"error: robot.urdf:{line}: ")
        assert "is too large" in outcome.err
    outcome = run("check", "robot.urdf")
    assert outcome.status == 1
    assert f"robot.urdf:{line}:" in outcome.out
    assert "RD007" in outcome.out


def test_what_rounding_left_of_zero_is_zero() -> None:
    changed("robot.urdf", 'rpy="0.1 0 0"', 'rpy="0.1 5.8e-66 -1e-320"')
    noisy = run("inertia", "robot.urdf", "--format", "json")
    Path("robot.urdf").write_text(URDF)
    assert noisy == run("inertia", "robot.urdf", "--format", "json")


def test_the_largest_float_is_no_limit() -> None:
    changed(
        "robot.urdf", 'velocity="5" lower="-3" upper="3"/><dynamics', 'velocity="1.79e308" upper="1.79e308"/><dynamics'
    )
    for command in COMMANDS:
        assert run(*command).status in (0, 1)


def test_a_motion_of_an_impossible_body_that_would_take_for_ever_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stiff_steps, "MOST_UNASKED", 3e3)
    monkeypatch.setattr(stiff_steps, "MOST_EVER", 3e7)
    changed("robot.urdf", 'ixz="0" iyy="0.01"', 'ixz="-1e29" iyy="0.01"')
    outcome = run(*SIMULATE, "--rtol", "1e-4")
    assert outcome.status == 2
    assert "dop853 has taken 3e+03 evaluations and is at " in outcome.err
