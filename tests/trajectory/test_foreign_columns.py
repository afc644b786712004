"""Tables of other programs: names of columns, units in names, arrays of joints, stamps from a distant origin."""

from __future__ import annotations

import contextlib
import math
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from helpers.whole_tables import read_trajectory

from robodyn.errors import TrajectoryError
from robodyn.trajectory.columns.layout import Header, resolve
from robodyn.trajectory.columns.signals import Signal, Signals, unit_of
from robodyn.trajectory.motion import Trajectory
from robodyn.trajectory.options import Reading
from robodyn.trajectory.read import open_trajectory, row_at

ARM = Signals((Signal("elbow", "angle"), Signal("lift", "length")), dependent=("finger",))
GIVEN = Reading("given")


def read(folder: Path, header: str, *rows: str, reading: Reading = GIVEN, signals: Signals = ARM) -> Trajectory:
    path = folder / "t.csv"
    path.write_text("\n".join((header, *rows, "")))
    return read_trajectory(path, signals, reading=reading)


NAMES: dict[tuple[str, int], list[str]] = {
    ("q", 0): ["/joint_states/elbow/position", "elbow_position", "elbow Angle", "elbow-angle", "elbow [rad]"],
    ("qd", 0): ["/joint_states/elbow/velocity", "elbow_velocity", "dq_elbow", "elbow/velocity [rad/s]"],
    ("qdd", 0): ["elbow_acceleration"],
    ("tau", 0): ["/joint_states/elbow/effort", "elbow.effort", "effort_elbow", "elbow_torque", "elbow_torque [N m]"],
    ("qd", 1): ["velocity_lift"],
    ("qdd", 1): ["qdd_lift_mm_s2"],
}
NAMES["q", 0] += ["elbow (deg)", "elbow_deg"]
NAMES["qd", 0] += ["elbow_vel_deg_per_s"]


def test_names_of_other_programs() -> None:
    found = {column: ARM.find(column) for columns in NAMES.values() for column in columns}
    places = {column: meaning and meaning.place for column, meaning in found.items()}
    assert places == {column: place for place, columns in NAMES.items() for column in columns}
    finger = ARM.find("finger_position")
    assert finger is not None
    assert finger.place is None
    for column in ("wrist_position", "elbow_x", "velocity", "position[0]", "elbow_s", "Elbow"):
        assert ARM.find(column) is None


UNITS = {
    "rad": ("angle", 1.0, 0),
    "\N{DEGREE SIGN}/s": ("angle", 180 / math.pi, 1),
    "deg/s^2": ("angle", 180 / math.pi, 2),
    "rad/s\N{SUPERSCRIPT TWO}": ("angle", 1.0, 2),
    "mm/s/s": ("length", 1000.0, 2),
    "\N{MICRO SIGN}s": ("time", 1e6, 0),
    "Nanoseconds": ("time", 1e9, 0),
    **dict.fromkeys(("grad", "ticks", "/s", "", "m/s^3", "rad s")),
}


def test_units() -> None:
    assert {text: unit_of(text) for text in UNITS} == UNITS


def test_units_in_names_are_converted(tmp_path: Path) -> None:
    header = "time [ms],elbow [deg],qd_elbow (deg/s),elbow_acc_deg_s2,lift_mm,qd_lift [mm/s],lift_acceleration [m/s^2]"
    found = read(tmp_path, header, "0,90,180,-90,250,1000,2", "5,91,180,-90,255,1000,2")
    assert found.time.tolist() == [0.0, 0.005]
    assert np.allclose(found.q, [[math.pi / 2, 0.25], [math.radians(91), 0.255]], rtol=1e-15)
    assert np.allclose([found.qd[0], found.qdd[0]], [[math.pi, 1.0], [-math.pi / 2, 2.0]], rtol=1e-15)


@pytest.mark.parametrize(
    ("column", "message"),
    [
        ("elbow_mm", "column 'elbow_mm': 'mm' is no unit of the position of 'elbow' (understood: rad or deg)"),
        ("elbow [rad/s]", "'rad/s' is no unit of the position of 'elbow'"),
        ("qd_elbow [deg]", "'deg' is no unit of the velocity of 'elbow' (understood: rad/s or deg/s)"),
        ("lift (deg)", "column 'lift (deg)': 'deg' is no unit of the position of 'lift' (understood: m or mm)"),
    ],
)
def test_units_that_cannot_be_are_refused(column: str, message: str) -> None:
    given = {"elbow": "elbow", "lift": "lift"} | {"lift" if "lift" in column else "elbow": column}
    names = ("time", *given.values()) if "qd" not in column else ("time", "elbow", "lift", column)
    with pytest.raises(TrajectoryError) as caught:
        resolve(Header(names), ARM)
    assert message in str(caught.value)


ROW = {"q_elbow": "1", "qd_elbow": "0", "qdd_elbow": "0", "q_lift": "0", "qd_lift": "0", "qdd_lift": "0"}


@pytest.mark.parametrize(
    ("stamps", "time"),
    [
        ({"__time": ("0.5", "0.75")}, (0.5, 0.75)),
        ({"%time": ("500000000", "750000000")}, (0.5, 0.75)),
        ({"time_from_start": ("0", "0.25")}, (0.0, 0.25)),
        ({"time_from_start.sec": ("1", "1"), "time_from_start.nanosec": ("0", "250000000")}, (1.0, 1.25)),
        ({"header.stamp.sec": ("9", "10"), "header.stamp.nanosec": ("750000000", "0")}, (9.75, 10.0)),
        (
            {"/joint_states/header/stamp/sec": ("9", "10"), "/joint_states/header/stamp/nanosec": ("5", "0")},
            (9 + 5e-9, 10),
        ),
        ({"secs": ("1", "2"), "nsecs": ("500000000", "0")}, (1.5, 2.0)),
        ({"Timestamp (ns)": ("500000000", "750000000")}, (0.5, 0.75)),
        (
            {"__time": ("0.5", "0.75"), "/header/stamp/sec": ("7", "7"), "/header/stamp/nanosec": ("1", "2")},
            (0.5, 0.75),
        ),
        ({"%time": ("1", "2"), "field.header.seq": ("0", "1"), "field.header.stamp": ("7", "8")}, (1e-9, 2e-9)),
    ],
    ids=lambda stamps: "+".join(stamps) if isinstance(stamps, dict) else "",
)
def test_time_of_other_programs(stamps: dict[str, tuple[str, str]], time: tuple[float, float], tmp_path: Path) -> None:
    rows = [",".join((*(cells[k] for cells in stamps.values()), *ROW.values())) for k in range(2)]
    assert read(tmp_path, ",".join((*stamps, *ROW)), *rows).time.tolist() == list(time)


ROSTOPIC = (
    "%time,field.header.seq,field.header.stamp,field.header.frame_id,field.name0,field.name1,field.name2,"
    "field.position0,field.position1,field.position2,field.velocity0,field.velocity1,field.velocity2,field.effort0"
)


def echoed(k: int, names: str = "lift,finger,elbow") -> str:
    return f"{1000000 * k},{k},{1000000 * k},base,{names},0.25,0.5,1.5,0.1,0,-0.1,7"


def test_arrays_with_names_of_joints(tmp_path: Path) -> None:
    """What `rostopic echo -p /joint_states` writes, whose order is that of the names beside it."""
    reading = Reading("central")
    found = read(tmp_path, ROSTOPIC, *map(echoed, range(5)), reading=reading)
    assert found.q[0].tolist() == [1.5, 0.25]
    assert found.qd[0].tolist() == [-0.1, 0.1]
    with pytest.raises(
        TrajectoryError, match=r"t.csv:4: column 'field.name0' is 'elbow', and 'lift' in the rows before"
    ):
        read(tmp_path, ROSTOPIC, echoed(0), echoed(1), echoed(2, "elbow,finger,lift"), reading=reading)


@pytest.mark.parametrize("form", ["/joint_states.position[{}]", "position{}"])
def test_arrays_without_names_are_refused(form: str) -> None:
    names = form.format(0), form.format(1)
    with pytest.raises(TrajectoryError) as caught:
        resolve(Header(("time", *names)), ARM)
    assert f"columns {names[0]!r}, {names[1]!r} do not tell which joints they are of" in str(caught.value)
    assert f"q_elbow={names[0]}" in str(caught.value).replace("'", "")
    layout = resolve(Header(("time", *names)), ARM, reading=Reading(columns={"q_elbow": names[1], "q_lift": names[0]}))
    assert layout.q == (2, 1)


def test_map_gives_columns_our_names(tmp_path: Path) -> None:
    columns = {"time": "clock", "q_elbow": "my angle [deg]", "lift": "up_mm", "qd_elbow": "w", "push": "F"}
    reading = Reading("central", columns=columns)
    path = tmp_path / "t.csv"
    path.write_text("clock,my angle [deg],up_mm,w,F\n0,90,250,1,5\n1,90,250,1,6\n2,90,250,1,7\n")
    found = read_trajectory(path, ARM, extra=("push",), reading=reading)
    assert found.q[0].tolist() == pytest.approx([math.pi / 2, 0.25])
    assert (found.qd[0, 0], found.extra["push"].tolist()) == (1.0, [5.0, 6.0, 7.0])


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ({"q_elbw": "a"}, "a column is called 'q_elbw', which the robot does not know (did you mean 'q_elbow'?)"),
        ({"tau_wrist": "a"}, "a column is called 'tau_wrist', which the robot does not know"),
        ({"q_elbow": "bb"}, "there is no column 'bb' to be called 'q_elbow' (columns: 'time', 'a', 'lift')"),
        ({"q_elbow": "a", "elbow": "lift"}, "columns 'a' and 'lift' give the same quantity"),
    ],
)
def test_maps_that_lead_nowhere(columns: dict[str, str], message: str) -> None:
    with pytest.raises(TrajectoryError) as caught:
        resolve(Header(("time", "a", "lift")), ARM, reading=Reading(columns=columns))
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (("time", "Elbow", "lift"), "did you mean 'Elbow' for 'q_elbow'? then --map q_elbow=Elbow;"),
        (("time", "Elbow Pos", "Lift [mm]"), "then --map 'q_elbow=Elbow Pos' --map 'q_lift=Lift [mm]';"),
        (("time", "velocity_elbow", "lift"), "no position of joint 'elbow' (--hold rest"),
        (("time", "velocity_elbw", "lift"), "no position of joint 'elbow' (--hold rest"),
        (("time", "elbow", "lift", "velocity_elbw"), "did you mean 'velocity_elbw' for 'qd_elbow'?"),
        (("time", "elbow", "lift", "tau_elbw"), "did you mean 'tau_elbw' for 'tau_elbow'? then --map tau_elbow="),
        (("time", "elbow", "lift", "tau_elbow", "tau_elbw"), "unknown column 'tau_elbw' (there is 'time', 'elbow'"),
    ],
)
def test_proposals_are_of_the_right_quantity(names: tuple[str, ...], message: str) -> None:
    """A velocity is not proposed for a position, nor a column for a quantity that is given."""
    with pytest.raises(TrajectoryError) as caught:
        resolve(Header(names), ARM)
    assert message in str(caught.value)


@pytest.mark.parametrize("name", ["_-", "-", "__", "é", "-1", "\uff0e", "q_", "_q_"])
def test_a_joint_of_marks_alone(name: str) -> None:
    signals = Signals((Signal("shoulder", "angle"), Signal(name, "angle")))
    for column in ("c", "_-x", "q_", "foo-bar", "-", "q_é", "٣"):
        with contextlib.suppress(TrajectoryError):
            resolve(Header(("time", "q_shoulder", column)), signals)


ONE = Signals((Signal("a", "angle"),))
START = 1_700_000_000_123_456_789
"""Nanoseconds since 1970; a double is a multiple of 256 of them."""
STEPS = np.cumsum(np.random.default_rng(0).integers(900_000, 1_100_000, 200))
STAMPS = [START + int(step) for step in STEPS]
TIME = np.array([step - int(STEPS[0]) for step in STEPS.tolist()]) / 1e9
Q = np.sin(TIME)


def csv(path: Path, names: str, cells: list[str]) -> Path:
    path.write_text(
        "\n".join([f"{names},q_a", *(f"{cell},{q!r}" for cell, q in zip(cells, Q.tolist(), strict=True)), ""])
    )
    return path


def tables(folder: Path) -> list[tuple[Path, Reading]]:
    """The same stamps in every form that holds them."""
    whole = [f"{stamp}" for stamp in STAMPS]
    ints = np.array(STAMPS)
    parts = [divmod(stamp, 10**9) for stamp in STAMPS]
    pl.DataFrame({"time": ints, "q_a": Q}).write_parquet(folder / "t.parquet")
    np.savez(folder / "t.npz", time=ints, q_a=Q)
    np.savez(folder / "pair.npz", sec=np.array([s for s, _ in parts]), nanosec=np.array([n for _, n in parts]), q_a=Q)
    told = Reading("central", time_unit="ns")
    return [
        (csv(folder / "echo.csv", "%time", whole), Reading("central")),
        (csv(folder / "ns.csv", "time [ns]", whole), Reading("central")),
        (csv(folder / "pair.csv", "stamp.sec,stamp.nanosec", [f"{s},{n}" for s, n in parts]), Reading("central")),
        (csv(folder / "s.csv", "__time", [f"{s}.{n:09d}" for s, n in parts]), Reading("central")),
        (folder / "t.parquet", told),
        (folder / "t.npz", told),
        (folder / "pair.npz", Reading("central")),
    ]


@pytest.mark.parametrize("large", [1 << 60, -1], ids=["lines", "polars"])
def test_times_are_exact_in_every_form(large: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """To the bit those of the differences; through doubles they would be off by up to 128 ns."""
    monkeypatch.setattr("robodyn.trajectory.formats.csv_table.LARGE", large)
    for path, reading in tables(tmp_path):
        found = read_trajectory(path, ONE, reading=reading)
        np.testing.assert_array_equal(found.time, TIME, err_msg=path.name)
        assert found.origin == STAMPS[0] / 10**9
    rough = np.array(STAMPS, float) / 1e9
    assert np.abs(rough - rough[0] - TIME).max() > 5e-8


def test_given_stamps_are_kept_as_they_were(tmp_path: Path) -> None:
    for path, reading in tables(tmp_path):
        with open_trajectory(path, ONE, reading=reading, block_rows=64) as reader:
            given = np.concatenate([block.given_time for block in reader.blocks()])
        seconds = path.stem in ("pair", "s")
        expected = np.array([stamp / 10**9 if seconds else float(stamp) for stamp in STAMPS])
        np.testing.assert_array_equal(given, expected, err_msg=path.name)


@pytest.mark.parametrize(
    ("row", "message"),
    [
        (f"{STAMPS[-1]},0", r"t.csv:202: time 0\.\d+ s after the first stamp repeats 0\.\d+ of the row before"),
        ("soon,0", "t.csv:202: column '%time': 'soon' is not a number"),
        ("1_800_000_000_000_000_000,0", "t.csv:202: column '%time': '1_800_000_000_000_000_000' is not a number"),
        (",0", "t.csv:202: column '%time' is empty"),
    ],
)
@pytest.mark.parametrize("large", [1 << 60, -1], ids=["lines", "polars"])
def test_bad_stamps_are_told_with_their_line(
    row: str, message: str, large: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("robodyn.trajectory.formats.csv_table.LARGE", large)
    path = csv(tmp_path / "t.csv", "%time", [f"{stamp}" for stamp in STAMPS])
    path.write_text(f"{path.read_text()}{row}\n")
    with pytest.raises(TrajectoryError, match=message):
        read_trajectory(path, ONE, reading=Reading("central"))


def test_a_row_is_found_by_the_time_since_the_first(tmp_path: Path) -> None:
    path, reading = tables(tmp_path)[0]
    with open_trajectory(path, ONE, reading=reading) as reader:
        assert row_at(reader, 0.1).time[0] == TIME[np.abs(TIME - 0.1).argmin()]
    with (
        open_trajectory(path, ONE, reading=reading) as reader,
        pytest.raises(TrajectoryError, match="it lasts from 0 s"),
    ):
        row_at(reader, START / 1e9)
