"""Names of columns: every form is understood, and every mistake is named."""

from __future__ import annotations

import pytest

from robodyn.errors import InputError, TrajectoryError
from robodyn.trajectory.columns.layout import ABSENT, Header, resolve
from robodyn.trajectory.columns.signals import Signal, Signals
from robodyn.trajectory.reading import Reading

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


def test_two_coordinates_of_one_name() -> None:
    with pytest.raises(InputError, match="share the column name 'a_x'"):
        Signals((Signal("a", "floating"), Signal("a_x", "angle")))


def test_any_order_and_what_is_absent() -> None:
    layout = resolve(Header(("lift", "qd_elbow", "t", "q_elbow", "shoulder.pos", "fx")), ARM, extra=("fx",))
    assert (layout.clock.column, layout.q, layout.qd) == (2, (4, 3, 0), (ABSENT, 1, ABSENT))
    assert layout.qdd == (ABSENT,) * 3
    assert layout.extra == {"fx": 5}
    assert layout.needed == (0, 1, 2, 3, 4, 5)


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


def test_missing_columns_of_the_scene() -> None:
    with pytest.raises(TrajectoryError, match="no column 'fx', which the scene names"):
        resolve(Header(ALL), ARM, extra=("fx",))


def test_extra_columns_can_be_left_out() -> None:
    layout = resolve(Header((*ALL, "force", "moment")), ARM, reading=Reading(ignore_extra=True))
    assert layout.needed == (0, 1, 2, 3)
    assert layout.notes == ("columns not used: 'force', 'moment'",)


@pytest.mark.parametrize("column", ["finger", "q_finger", "finger.vel", "/states/finger/position", "finger/velocity"])
def test_columns_of_dependent_joints_are_not_used(column: str) -> None:
    signals = Signals((Signal("thumb", "angle"),), dependent=("finger",))
    assert resolve(Header(("t", "thumb", column)), signals).notes == (f"columns not used: {column!r}",)


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


def test_a_simulation_may_follow_columns_of_loops() -> None:
    assert resolve(Header(with_sets("pin")), Signals(()), ["fx_pin"], Reading(ignore_extra=True)).extra == {"fx_pin": 4}
