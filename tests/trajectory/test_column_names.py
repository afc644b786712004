"""Columns: every form of a name is understood, every mistake named; joints without columns are held or follow."""

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
from robodyn.errors import InputError, TrajectoryError
from robodyn.loads.constraints import Follower
from robodyn.trajectory.columns.layout import ABSENT, Header, resolve
from robodyn.trajectory.columns.signals import Signal, Signals
from robodyn.trajectory.formats.table import ArrayTable
from robodyn.trajectory.motion import Trajectory, join
from robodyn.trajectory.options import HoldGiven, Reading, hold_of
from robodyn.trajectory.read import TrajectoryReader

ARM = Signals((Signal("shoulder", "angle"), Signal("elbow", "continuous"), Signal("lift", "length")))
FREE = Signals((Signal("base", "floating"), Signal("arm/wrist", "angle")))


def place(signals: Signals, column: str) -> tuple[str, int] | None:
    found = signals.find(column)
    return found.place if found else None


OURS: dict[tuple[str, int] | None, list[str]] = {
    ("q", 0): ["q1", "q[1]"],
    ("q", 1): ["q_elbow", "elbow", "elbow.pos", "elbow/position"],
    ("q", 2): ["q[3]"],
    ("qd", 1): ["qd_elbow", "elbow.vel", "/joint_states/elbow/velocity", "qd2"],
    ("qdd", 1): ["qdd_elbow", "elbow.acc"],
    ("qdd", 2): ["a/b/c/lift/acceleration", "qdd3"],
    ("tau", 1): ["elbow/effort"],
    None: ["q4", "q0", "Elbow", "elbow_x"],
}
FLOATING: dict[tuple[str, int] | None, list[str]] = {
    ("q", 0): ["base_x"],
    ("q", 2): ["q_base_z"],
    ("q", 3): ["base_qx"],
    ("q", 6): ["base_qw"],
    ("q", 7): ["q_arm/wrist", "states/arm/wrist/position"],
    ("qd", 0): ["base_wx", "ros/base_wx/velocity"],
    ("qd", 3): ["qd_base_vx"],
    ("qd", 5): ["base_vz"],
    ("qd", 6): ["qd7"],
    ("qdd", 0): ["qdd_base_wx", "qdd_base_wdx"],
    ("qdd", 1): ["base_wdy"],
    ("qdd", 3): ["base_ax"],
    None: ["base"],
}


@pytest.mark.parametrize(("signals", "names"), [(ARM, OURS), (FREE, FLOATING)], ids=["scalar", "floating"])
def test_every_form_of_a_name(signals: Signals, names: dict[tuple[str, int] | None, list[str]]) -> None:
    for meaning, columns in names.items():
        assert {column: place(signals, column) for column in columns} == dict.fromkeys(columns, meaning)


def test_a_joint_called_like_a_number_wins() -> None:
    swapped = Signals((Signal("q2", "angle"), Signal("q1", "angle")))
    assert place(swapped, "q1") == ("q", 1)
    assert place(swapped, "q[1]") == ("q", 0)
    both = Signals((Signal("a", "angle"), Signal("q_a", "angle")))
    assert (place(both, "q_a"), place(both, "q_q_a")) == (("q", 0), ("q", 1))
    with pytest.raises(InputError, match="share the column name 'a_x'"):
        Signals((Signal("a", "floating"), Signal("a_x", "angle")))


def test_any_order_and_what_is_absent() -> None:
    layout = resolve(Header(("lift", "qd_elbow", "t", "q_elbow", "shoulder.pos", "fx")), ARM, extra=("fx",))
    assert (layout.clock.column, layout.q, layout.qd) == (2, (4, 3, 0), (ABSENT, 1, ABSENT))
    assert layout.qdd == (ABSENT,) * 3
    assert layout.extra == {"fx": 5}
    assert layout.needed == (0, 1, 2, 3, 4, 5)
    ignoring = resolve(Header((*ALL, "force", "moment")), ARM, reading=Reading(ignore_extra=True))
    assert (ignoring.needed, ignoring.notes) == ((0, 1, 2, 3), ("columns not used: 'force', 'moment'",))
    with pytest.raises(TrajectoryError, match="no column 'fx', which the scene names"):
        resolve(Header(ALL), ARM, extra=("fx",))
    signals = Signals((Signal("thumb", "angle"),), dependent=("finger",))
    for column in ("finger", "finger.vel", "/states/finger/position"):
        assert resolve(Header(("t", "thumb", column)), signals).notes == (f"columns not used: {column!r}",)


ALL = ("time", "q_shoulder", "q_elbow", "q_lift")


@pytest.mark.parametrize(
    ("names", "message"),
    [
        ((), "no column of time"),
        (("when", *ALL[1:]), "no column of time (name it 'time', or say which it is: --map time=NAME"),
        ((*ALL, "t"), "time is given 2 times, by 'time', 't'"),
        ((*ALL, "time"), "column 'time' appears twice"),
        ((*ALL, ""), "column 5 of 5 has no name"),
        ((*ALL, "elbow.pos"), "columns 'q_elbow' and 'elbow.pos' give the same quantity"),
        ((*ALL, "q2"), "columns 'q_elbow' and 'q2' give the same quantity"),
        (
            ALL[:3],
            "no position of joint 'lift' (--hold rest keeps joints without columns still; there is 'time', 'q_sh",
        ),
        (("time", "q_shoulder", "q_elbov", "q_lift"), "did you mean 'q_elbov' for 'q_elbow'?"),
        (("time", "qd_shoulder", "q_elbow", "q_lift"), "no position of joint 'shoulder'"),
        ((*ALL, "qd_elbo"), "unknown column 'qd_elbo'"),
        ((*ALL, "force"), "unknown column 'force'"),
        ((*ALL, "force"), "--ignore-extra"),
    ],
)
def test_every_mistake_is_named(names: tuple[str, ...], message: str) -> None:
    with pytest.raises(TrajectoryError) as caught:
        resolve(Header(names, "t.csv", 1), ARM)
    assert message in str(caught.value)
    assert str(caught.value).startswith("t.csv:1: ")


def test_floating_joint_needs_one_column_and_whole_quaternions() -> None:
    free = Signals((Signal("base", "floating"),))
    for column in ("base_x", "base_wz", "base_ax"):
        resolve(Header(("t", column)), free)
    with pytest.raises(
        TrajectoryError, match=r"no column says where 'base' is, which moves freely .give base_x base_y"
    ):
        resolve(Header(("t",)), free)
    with pytest.raises(TrajectoryError, match="orientation of 'base' is incomplete: only 'base_qx', 'base_qw'"):
        resolve(Header(("t", "base_qx", "base_qw")), free)


SIX = ("fx", "fy", "fz", "mx", "my", "mz")


def with_sets(*names: str) -> tuple[str, ...]:
    return ("time", "q1", "q2", "q3", *(f"{part}_{name}" for name in names for part in SIX))


@pytest.mark.parametrize("loops", [("pin",), ("elbow",), ("shoulder", "elbow", "lift", "pin")], ids=" ".join)
def test_wrenches_of_loops_are_refused(loops: tuple[str, ...]) -> None:
    name = loops[-1]
    with pytest.raises(TrajectoryError, match=f"columns 'fx_{name}' to 'mz_{name}' are what simulate writes of a loop"):
        resolve(Header(with_sets(*loops)), ARM, reading=Reading(ignore_extra=True))


@pytest.mark.parametrize(
    "names",
    [
        with_sets("pin")[:-1],
        ("time", "q1", "q2", "q3", "fx_sensor", "fy_sensor", "fz_sensor"),
        with_sets("shoulder", "elbow", "lift"),
    ],
    ids=["five of six", "a sensor's force", "reactions of every joint"],
)
def test_other_columns_may_be_ignored(names: tuple[str, ...]) -> None:
    layout = resolve(Header(names), ARM, reading=Reading(ignore_extra=True))
    assert f"columns not used: '{names[4]}'" in layout.notes[0]
    with pytest.raises(TrajectoryError, match="unknown columns 'fx_"):
        resolve(Header(names), ARM)
    assert resolve(Header(with_sets("pin")), Signals(()), ["fx_pin"], Reading(ignore_extra=True)).extra == {"fx_pin": 4}


LIMITED = Signals(
    (Signal("wrist", "angle", -2.0, 2.0), Signal("elbow", "angle", 0.5, 2.0), Signal("lift", "length", -0.5, -0.1)),
    dependent=("finger",),
)
AFLOAT = Signals((Signal("base", "floating"), *LIMITED.joints))
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
    found = read(LIMITED, hold, "wrist")
    assert (found.q[:, 1:] == places).all()
    assert not found.qd[:, 1:].any()
    assert not found.qdd[:, 1:].any()
    assert found.held == dict(zip(("elbow", "lift"), places, strict=True))
    assert found.derivation is not None
    assert [joint.name for joint in found.derivation.joints] == ["wrist"]


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
        read(LIMITED, hold, *columns)
    assert message in str(caught.value)


def test_a_floating_joint_is_held_at_its_place() -> None:
    """Where it has columns, they and what is said of the others hold."""
    found = read(AFLOAT, "rest,base_z=0.8", "wrist")
    assert (found.q[:, :7] == (0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 1.0)).all()
    assert not found.qd[:, :6].any()
    assert (found.notes, found.held["base_z"]) == ((), 0.8)
    assert (read(AFLOAT, "rest,base_z=0.8", "wrist", "base_x").q[:, 1:3] == (0.0, 0.8)).all()
    with pytest.raises(
        TrajectoryError, match=r"joint 'base' moves freely, one number does not place it \(give base_x="
    ):
        read(AFLOAT, "rest,base=1", "wrist")
    degrees = read(LIMITED, "elbow=90,lift=-0.2", "wrist", angle_unit="deg")
    assert degrees.held == {"elbow": pytest.approx(math.pi / 2, rel=1e-15), "lift": -0.2}


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
