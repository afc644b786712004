"""Joints without columns: held where it is said, or following from loops, whose wrenches' columns are left out."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from helpers.closed_chains import bennett, crank_slider, four_bars
from helpers.small_robots import joint, link

import robodyn
from robodyn.dynamics.plan import plan
from robodyn.errors import TrajectoryError
from robodyn.loads.constraints import Follower
from robodyn.scene.parts import Contact
from robodyn.trajectory.columns.signals import Signal, Signals
from robodyn.trajectory.motion import Trajectory, join
from robodyn.trajectory.reader import TrajectoryReader
from robodyn.trajectory.readers.table import ArrayTable
from robodyn.trajectory.reading import HoldGiven, Reading, hold_of

ARM = Signals(
    (Signal("wrist", "angle", -2.0, 2.0), Signal("elbow", "angle", 0.5, 2.0), Signal("lift", "length", -0.5, -0.1)),
    dependent=("finger",),
)
FREE = Signals((Signal("base", "floating"), *ARM.joints))
TIME = np.arange(20) / 100


def read(signals: Signals, hold: HoldGiven | None, *columns: str, **reading: object) -> Trajectory:
    table = ArrayTable(None, {"time": TIME, **{name: np.sin(TIME) for name in columns}})
    reader = TrajectoryReader(table, signals, reading=Reading(hold=hold_of(hold), **reading))  # type: ignore[arg-type]
    (block,) = reader.blocks()
    return block


@pytest.mark.parametrize(
    ("hold", "places"),
    [
        ("rest", (0.5, -0.1)),
        ("rest,elbow=0.7", (0.7, -0.1)),
        ("elbow=0.7, lift=rest", (0.7, -0.1)),
        (0.25, (0.25, 0.25)),
        ("-0.25", (-0.25, -0.25)),
        ({"elbow": "rest", "lift": -1e-3}, (0.5, -0.001)),
    ],
)
def test_held_where_it_is_said(hold: HoldGiven, places: tuple[float, float]) -> None:
    """At rest is nearest to zero within the limits; velocities and accelerations are zero, not derived."""
    found = read(ARM, hold, "wrist")
    assert (found.q[:, 1:] == places).all()
    assert not found.qd[:, 1:].any()
    assert not found.qdd[:, 1:].any()
    assert found.held == dict(zip(("elbow", "lift"), places, strict=True))
    assert found.derivation is not None
    assert [joint.name for joint in found.derivation.joints] == ["wrist"]


def test_held_angles_are_in_the_unit_of_angles() -> None:
    found = read(ARM, "elbow=90,lift=-0.2", "wrist", angle_unit="deg")
    assert found.held == {"elbow": pytest.approx(math.pi / 2, rel=1e-15), "lift": -0.2}


@pytest.mark.parametrize(
    ("hold", "columns", "message"),
    [
        (None, ("wrist",), "no position of joint 'elbow', 'lift' (--hold rest keeps joints without columns still"),
        ("elbow=1", ("wrist",), "no position of joint 'lift'"),
        ("elbow=1,lift=0", ("wrist", "elbow"), "joint 'elbow' is to be held, and column 'elbow' moves it"),
        ("rest", ("wrist", "qd_elbow"), "joint 'elbow' is to be held, and column 'qd_elbow' moves it"),
        ("rest,elbw=1", ("wrist",), "no joint 'elbw' to hold (did you mean 'elbow'?)"),
        ("rest,finger=1", ("wrist",), "no joint 'finger' to hold (it follows another)"),
        (
            "resting",
            ("wrist",),
            "'resting' is no place to hold a joint (rest, a number, or joints as in rest,elbow=0.3)",
        ),
        ("nan", ("wrist",), "'nan' is no place"),
        ("1_0", ("wrist",), "'1_0' is no place"),
        ("elbow=", ("wrist",), "'' is no place"),
    ],
)
def test_what_cannot_be_held(hold: HoldGiven | None, columns: tuple[str, ...], message: str) -> None:
    with pytest.raises(TrajectoryError) as caught:
        read(ARM, hold, *columns)
    assert message in str(caught.value)


def test_a_floating_joint_is_held_at_its_place() -> None:
    found = read(FREE, "rest,base_z=0.8", "wrist")
    assert (found.q[:, :7] == (0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 1.0)).all()
    assert not found.qd[:, :6].any()
    assert found.notes == ()
    assert found.held["base_z"] == 0.8


def test_the_rest_of_a_floating_joint_with_columns_is_as_before() -> None:
    found = read(FREE, "rest,base_z=0.8", "wrist", "base_x")
    assert (found.q[:, 1:3] == (0.0, 0.8)).all()
    assert "base: position y is not given and taken as 0" in found.notes


def test_one_number_does_not_place_a_floating_joint() -> None:
    with pytest.raises(TrajectoryError) as caught:
        read(FREE, "rest,base=1", "wrist")
    assert "joint 'base' moves freely, one number does not place it (give base_x=..., base_y=" in str(caught.value)


SIX = ("fx", "fy", "fz", "mx", "my", "mz")


def table(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "motion.csv"
    path.write_text(text)
    return path


def test_joints_of_loops_follow(tmp_path: Path) -> None:
    model, scene = crank_slider()
    rows = "".join(f"{0.01 * k},{0.7 + 0.02 * k}\n" for k in range(60))
    with robodyn.read_motion(table(tmp_path, f"time,q_main\n{rows}"), model, scene) as reader:
        assert reader.followed == ("rail", "big_end")
        (block,) = reader.blocks()
    assert block.followed == ("rail", "big_end")
    assert block.derivation is not None
    assert [each.name for each in block.derivation.joints] == ["main"]
    whole = Follower(plan(model, scene), reader.followed, reader.file).take(block)
    assert whole.followed == ()
    sine = 0.3 * np.sin(block.q[:, 0]) / 0.8
    rail = 0.3 * np.cos(block.q[:, 0]) + 0.8 * np.sqrt(1.0 - sine**2)
    assert np.abs(whole.q[:, model.coordinates.index("rail")] - rail).max() <= 1e-13


def test_error_bars_of_what_follows() -> None:
    """For one given crank every bar is |D| times that of the crank, D = qd_d / qd_g."""
    model, scene = crank_slider()
    t = np.linspace(0.0, 1.0, 40)
    block = robodyn.motion(model, t, {"main": 0.7 + np.sin(3.0 * t)}, scene=scene)
    whole = Follower(plan(model, scene), block.followed).take(block)
    assert block.sampling is not None
    assert whole.sampling is not None
    main, rail = model.rates.index("main"), model.rates.index("rail")
    ratio = np.abs(whole.qd[:, rail] / whole.qd[:, main])
    assert block.sampling.off[:, main].max() > 0.0
    for name in ("off", "noise"):
        ours, theirs = getattr(whole.sampling, name), getattr(block.sampling, name)
        assert np.abs(ours[:, rail] - ratio * theirs[:, main]).max() <= 1e-12 * theirs.max(initial=1e-300)
    assert whole.sampling.squares[rail] == pytest.approx((whole.qdd[:, rail] ** 2).sum(), rel=1e-12)
    assert whole.sampling.off_squares[rail] == pytest.approx((whole.sampling.off[:, rail] ** 2).sum(), rel=1e-12)


def test_what_simulate_writes_is_read(tmp_path: Path) -> None:
    """With the wrench of the loop beside it; of loops that the scene does not have it is refused."""
    model, scene = crank_slider()
    names = ["time", *(f"q_{name}" for name in model.coordinates), *(f"{part}_pin" for part in SIX)]
    place = [scene.initial_q[name] for name in model.coordinates]
    rows = "".join(",".join(map(str, [0.1 * k, *place, *range(6)])) + "\n" for k in range(5))
    path = table(tmp_path, f"{','.join(names)}\n{rows}")
    with robodyn.read_motion(path, model, scene) as reader:
        assert (reader.followed, reader.notes) == ((), ())
        assert len(join(list(reader.blocks()))) == 5
    other = replace(scene, loops=(replace(scene.loops[0], name="other"),))
    with pytest.raises(TrajectoryError, match=r"of a loop, and the scene has no loop of that name.*\[\[loop\]\]"):
        robodyn.read_motion(path, model, other)


def test_columns_of_contacts(tmp_path: Path) -> None:
    model, scene = crank_slider()
    scene = replace(scene, contacts=(Contact("foot", "slider", on="touches"),))
    header = ["time", "q_main", "touches", *(f"{part}_foot" for part in SIX)]
    path = table(tmp_path, f"{','.join(header)}\n" + "".join(f"{k},0.7,1,0,0,0,0,0,0\n" for k in range(5)))
    with robodyn.read_motion(path, model, scene) as reader:
        (block,) = reader.blocks()
    assert list(block.extra) == ["touches"]
    assert reader.notes == ()


def test_joints_of_no_loop_need_columns(tmp_path: Path) -> None:
    model, scene = bennett(link("arm", 1.0), joint("lone", "l0", "arm"))
    path = table(tmp_path, "time,q_j1\n0,0.8\n1,0.9\n2,1.0\n")
    with pytest.raises(TrajectoryError, match="no position of joint 'lone'"):
        robodyn.read_motion(path, model, scene)
    with robodyn.read_motion(path, model, scene, hold="rest") as reader:
        (block,) = reader.blocks()
    assert reader.followed == ("j2", "j3")
    assert block.held == {"lone": 0.0}


def test_a_joint_of_a_loop_may_be_held_by_name(tmp_path: Path) -> None:
    model, scene = four_bars(1)
    path = table(tmp_path, "time\n0\n1\n2\n")
    with robodyn.read_motion(path, model, scene, hold={"k0": 1.2}) as reader:
        (block,) = reader.blocks()
    assert (reader.followed, block.held) == (("k1", "c0"), {"k0": 1.2})
    whole = Follower(plan(model, scene), reader.followed).take(block)
    assert np.abs(whole.q - [1.2, 1.2, -1.2][: model.nq]).max() <= 1e-12


def test_rates_without_positions_are_refused(tmp_path: Path) -> None:
    model, scene = crank_slider()
    path = table(tmp_path, "time,q_main,qd_rail\n0,0.7,0\n1,0.7,0\n2,0.7,0\n")
    with pytest.raises(TrajectoryError, match="column 'qd_rail' moves joint 'rail', and no column says where it is"):
        robodyn.read_motion(path, model, scene)
