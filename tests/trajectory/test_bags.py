"""Logs of ROS: bags of every kind, messages as text and of several publishers, and what is said of misfits."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from helpers.bags import NANO, ROS1, ROS2, dynamic_joint_state, joint_state, write_bag
from helpers.command_line import ROBOTS, run

import robodyn
from robodyn.errors import TrajectoryError
from robodyn.support.input_file import VARIABLE
from robodyn.trajectory.formats.messages import LogTable, State
from robodyn.trajectory.motion import join
from robodyn.trajectory.options import Reading, hold_of
from robodyn.trajectory.read import TrajectoryReader, open_table, signals

NAMES = ("shoulder", "elbow")
URDF = str(ROBOTS / "two_link_planar.urdf")
LOG = Path(__file__).parents[1] / "data" / "ur10_log" / "exciting"
START = 1_700_000_000 * NANO
"""ns, of an epoch: as numbers of seconds such stamps are 2e-7 s apart."""


def samples(count: int = 60):
    """Times in ns, positions, velocities and efforts of both joints."""
    time = 8_000_000 * np.arange(count)
    angle = np.column_stack([np.sin(1e-9 * time), np.cos(2e-9 * time)])
    speed = np.column_stack([np.cos(1e-9 * time), -2.0 * np.sin(2e-9 * time)])
    return time, angle, speed, 3.0 * angle


def states(store, start=START, names=NAMES, order=None):
    """Messages as they are recorded; `order`: places of the joints, message by message."""
    found = []
    for k, (time, *parts) in enumerate(zip(*samples(), strict=True)):
        turn = list((order or (lambda k: range(len(names))))(k))
        values = {name: part[turn] for name, part in zip(("position", "velocity", "effort"), parts, strict=True)}
        message = joint_state(store, start + int(time), [names[i] for i in turn], values)
        found.append((START + int(time) + 77, message))
    return found


def read(path, **options):
    model = robodyn.load(URDF)
    with robodyn.read_motion(path, model, **options) as reader:
        return join(list(reader.blocks()))


def check(block, names=NAMES):
    time, angle, speed, _ = samples()
    order = [robodyn.load(URDF).rates.index(name) for name in names]
    np.testing.assert_array_equal(block.time, time / NANO)
    np.testing.assert_array_equal(block.q[:, order], angle)
    np.testing.assert_array_equal(block.qd[:, order], speed)


@pytest.mark.parametrize("kind", ["sqlite3", "mcap", "ros1"])
def test_bags_of_every_kind(kind, tmp_path):
    """The numbers of the messages, to the bit; stamps count from the first one, exactly."""
    path = write_bag(
        tmp_path / f"log{'.bag' * (kind == 'ros1')}", {"/joint_states": states(ROS1 if kind == "ros1" else ROS2)}, kind
    )
    block = read(path)
    assert block.origin == 1_700_000_000
    check(block)
    if kind == "sqlite3":
        _without_metadata(path, tmp_path)
    elif kind == "mcap":
        (file,) = path.glob("*.mcap")
        check(read(file))


def _without_metadata(path: Path, folder: Path) -> None:
    """The only bag in a folder is read; what is said of none and of several."""
    (path / "metadata.yaml").unlink()
    check(read(path))
    (bag,) = path.iterdir()
    (path / f"more{bag.suffix}").write_bytes(bag.read_bytes())
    (folder / "none").mkdir()
    for given, said in (
        (path, f"with 2 bags: '{bag.name}', 'more{bag.suffix}' (name one of them, or let `ros2 bag reindex` write"),
        (folder / "none", "and no file in it is .db3, .mcap, .bag (name a table or a bag)"),
    ):
        with pytest.raises(TrajectoryError) as caught:
            read(given)
        assert str(caught.value).startswith(f"{given}: is a folder without metadata.yaml, ")
        assert said in str(caught.value)


def test_limits_of_bags(tmp_path, monkeypatch):
    path = write_bag(tmp_path / "log", {"/joint_states": states(ROS2)})
    check(read(path))
    for limit in ("bag_steps=100", "bag_chunk_bytes=60", "yaml_metadata_bytes=50"):
        monkeypatch.setenv(VARIABLE, limit)
        with pytest.raises(TrajectoryError):
            read(path)


def test_messages_that_say_something_else_are_left_out_and_told(tmp_path):
    """A gripper's driver on the same topic, a message that came twice, and joints in any order."""
    found = states(ROS2, order=lambda k: (k % 2, 1 - k % 2))
    for k in (5, 20, 30):
        found.append((found[k][0] + 1, joint_state(ROS2, START, ["finger"], {"position": [0.1]})))
    found.append((found[7][0] + 1, found[7][1]))
    block = read(write_bag(tmp_path / "log", {"/joint_states": sorted(found, key=lambda pair: pair[0])}))
    check(block)
    assert any("'q_finger'" in note for note in block.notes)
    assert "1 message with the stamp of the one before left out" in block.notes


def test_interfaces_that_all_joints_have(tmp_path):
    time, angle, speed, effort = samples()
    found = []
    for k, stamp in enumerate(time.tolist()):
        each = {name: {"position": angle[k, i], "velocity": speed[k, i]} for i, name in enumerate(NAMES)}
        each["elbow"]["effort"] = effort[k, 1]
        found.append((START + stamp, dynamic_joint_state(START + stamp, each)))
    path = write_bag(tmp_path / "log", {"/dynamic_joint_states": found})
    check(read(path))
    assert not any(name.startswith("tau") for name in open_table(path).names)


def topics(tmp_path):
    other = [(recorded, joint_state(ROS2, 0, ["finger"], {"position": [0.1]})) for recorded, _ in states(ROS2)]
    return write_bag(tmp_path / "log", {"/left/joint_states": states(ROS2), "/right/joint_states": other})


def test_one_of_several_topics(tmp_path):
    path = topics(tmp_path)
    check(read(path, topic="/left/joint_states"))
    outcome = run("torques", URDF, str(path), "--topic", "/left/joint_states")
    assert (outcome.status, outcome.err) == (0, "")
    listed = "/left/joint_states (JointState, 60 messages), /right/joint_states (JointState, 60 messages)"
    outcome = run("torques", URDF, str(path))
    assert (outcome.status, outcome.out) == (2, "")
    assert outcome.err == f"error: {path}: has several topics about joints: {listed} (--topic NAME says which)\n"
    with pytest.raises(TrajectoryError, match="no topic '/lft/joint_states' with messages about joints"):
        read(path, topic="/lft/joint_states")


def as_text(folder: Path, name: str, document: object) -> Path:
    path = folder / name
    path.write_text(json.dumps(document))  # JSON is YAML
    return path


@pytest.mark.parametrize(("suffix", "nested"), [(".json", False), (".yaml", True)], ids=["", "MoveIt"])
def test_trajectories_as_text(suffix, nested, tmp_path):
    time, angle, speed, _ = samples()
    points = [
        {"positions": q, "velocities": qd, "time_from_start": {"sec": t // NANO, "nanosec": t % NANO}}
        for t, q, qd in zip(time.tolist(), angle.tolist(), speed.tolist(), strict=True)
    ]
    plan = {"joint_names": list(NAMES), "points": points}
    check(read(as_text(tmp_path, f"plan{suffix}", {"trajectory": [{"joint_trajectory": plan}]} if nested else plan)))


def test_what_topic_echo_writes(tmp_path):
    """Documents one after another, in the words of ROS 1 too."""
    lines = []
    for time, q, qd, _ in zip(*(part.tolist() for part in samples()), strict=True):
        stamp = {"secs": 1_700_000_000 + time // NANO, "nsecs": time % NANO}
        lines.append(json.dumps({"header": {"stamp": stamp}, "name": list(NAMES), "position": q, "velocity": qd}))
    path = tmp_path / "echo.yaml"
    path.write_text("\n---\n".join(lines) + "\n---\n")
    block = read(path)
    assert block.origin == 1_700_000_000
    check(block)


WRONG = {
    "{}": "has no messages about joints (understood: JointState, DynamicJointState, JointTrajectory, by keys",
    '[{"joint_names": [], "points": []}, {"name": ["a"], "position": [1]}]': "has messages of several kinds: JointSt",
    '{"joint_names": ["a"], "points": []}': "has no messages",
    '{"name": ["shoulder", "elbow"], "velocity": [1, 2], "position": []}': "no messages with positions",
    "{": "cannot be read as JSON: ",
}


@pytest.mark.parametrize("text", WRONG)
def test_text_that_is_no_motion(text, tmp_path):
    path = tmp_path / "plan.json"
    path.write_text(text)
    outcome = run("torques", URDF, str(path))
    assert (outcome.status, outcome.out) == (2, "")
    assert outcome.err.startswith(f"error: {path}: {WRONG[text]}")
    assert len(outcome.err.splitlines()) == 1


def test_bags_that_are_none(tmp_path):
    folder = tmp_path / "folder"
    folder.mkdir()
    (folder / "metadata.yaml").write_text("none: 1\n")
    broken = tmp_path / "log.mcap"
    broken.write_bytes(b"not a bag at all")
    for path, said in (
        (folder, "cannot be read as a bag: "),
        (broken, "cannot be read as a bag: "),
        (tmp_path / "no.db3", "no such file"),
    ):
        outcome = run("torques", URDF, str(path))
        assert (outcome.status, outcome.out) == (2, "")
        assert said in outcome.err
        assert len(outcome.err.splitlines()) == 1
    outcome = run("torques", URDF, str(ROBOTS / "two_link_planar_swing.csv"), "--topic", "/joint_states")
    assert outcome.err.endswith("two_link_planar_swing.csv: has no topics (--topic is for bags: .db3, .mcap, .bag)\n")


def test_a_real_log_has_the_torques_that_were_measured():
    """The first second of a UR10's: joints in its own order, efforts as large as gravity asks for."""
    table = open_table(LOG)
    assert len(table.names) == 20
    (tau,) = table.blocks([table.names.index("tau_shoulder_lift_joint")], 1000)
    assert len(tau) == 120
    assert -120.0 < tau.min() < -10.0


def test_names_that_do_not_fit_are_proposed(tmp_path):
    """A position that is mapped brings its speed and effort."""
    path = write_bag(tmp_path / "log", {"/joint_states": states(ROS2, names=("robot1_shoulder_joint", "Elbow"))})
    outcome = run("torques", URDF, str(path))
    assert "--map q_shoulder=q_robot1_shoulder_joint --map q_elbow=q_Elbow" in outcome.err
    columns = {"q_shoulder": "q_robot1_shoulder_joint", "q_elbow": "q_Elbow"}
    block = read(path, columns=columns, measured=True)
    check(block)
    np.testing.assert_array_equal(block.extra["tau_elbow"], samples()[3][:, 1])


def test_what_is_nan_in_every_message_was_not_measured(tmp_path):
    """Velocities of all joints, the effort of one; a single cell stays an error, that says what to do."""
    found = states(ROS2)
    for _, message in found:
        message.velocity[:] = np.nan
        message.effort[1] = np.nan
    block = read(write_bag(tmp_path / "log", {"/joint_states": found}), measured=True)
    assert (block.derivation is not None, [*block.extra]) == (True, ["tau_shoulder"])
    for said in ("velocity of 'shoulder', 'elbow'", "effort of 'elbow'"):
        assert f"{said} is NaN in every message: read as not measured" in block.notes
    found[3][1].effort[1] = 1.0
    what = (
        r"row 1: column 'tau_elbow' is empty or NaN \(every cell must be finite: leave out such rows, or the whole col"
    )
    with pytest.raises(TrajectoryError, match=what):
        read(write_bag(tmp_path / "other", {"/joint_states": found}), measured=True)


ROBOT = ROBOTS / "two_link_planar.urdf"
STEP = 8_000_000
"""ns."""


def angle(stamps):
    return np.sin(2e-9 * np.asarray(stamps))


def publisher(names, stamps, position=angle):
    """Messages whose joints all have the same position, and that times 3 for a torque."""
    values = position(stamps)
    return [
        State(int(t), tuple(names), {"position": [x] * len(names), "effort": [3 * x] * len(names)})
        for t, x in zip(stamps, values.tolist(), strict=True)
    ]


def read_states(*publishers, hold=None):
    states = sorted((state for each in publishers for state in each), key=lambda state: state.stamp)
    reading = Reading("none", hold=hold_of(hold), measured=True)
    with TrajectoryReader(LogTable("log", states), signals(robodyn.load(ROBOT)), (), reading) as reader:
        return join(list(reader.blocks()))


def place(name):
    return robodyn.load(ROBOT).rates.index(name)


MAIN = NANO + STEP * np.arange(200)


def test_equal_stamps_give_the_numbers_of_the_messages():
    """To the bit, and no joint that the log has is held."""
    block = read_states(publisher(["shoulder"], MAIN), publisher(["elbow"], MAIN), hold="rest")
    assert not block.held
    for name in ("shoulder", "elbow"):
        np.testing.assert_array_equal(block.q[:, place(name)], angle(MAIN))
        np.testing.assert_array_equal(block.extra[f"tau_{name}"], 3 * angle(MAIN))
    assert "messages of another publisher about 'elbow' are interpolated onto the stamps of the others" in block.notes


def test_stamps_between_are_interpolated():
    """A chord is off a sine by h^2 / 8 max|q''| at most; the stretch is that of both publishers."""
    other = NANO + 3_000_000 + STEP * np.arange(10, 150)
    block = read_states(publisher(["shoulder"], MAIN), publisher(["elbow"], other))
    stamps = MAIN[(other[0] <= MAIN) & (other[-1] >= MAIN)]
    np.testing.assert_array_equal(block.q[:, place("shoulder")], angle(stamps))
    bound = (1e-9 * STEP) ** 2 / 8 * 4.0
    assert np.abs(block.q[:, place("elbow")] - angle(stamps)).max() < bound
    assert f"{200 - len(stamps)} messages left out, not between two about 'elbow'" in block.notes


def test_in_gaps_of_a_publisher_there_are_no_rows():
    block = read_states(publisher(["shoulder"], MAIN), publisher(["elbow"], np.delete(MAIN, np.s_[50:60])))
    np.testing.assert_array_equal(block.q[:, place("elbow")], angle(np.delete(MAIN, np.s_[50:60])))


def test_between_turns_the_nearer_message_counts():
    """Of an angle that jumps from pi to -pi nothing stands between."""
    other = MAIN[:-1] + 3_000_000

    def turning(stamps):
        return np.where(np.arange(len(stamps)) % 2, 3.1, -3.1)

    block = read_states(publisher(["shoulder"], MAIN), publisher(["elbow"], other, turning))
    np.testing.assert_array_equal(block.q[:, place("elbow")], turning(other)[1:])


def test_publishers_of_different_times_are_refused():
    with pytest.raises(TrajectoryError) as caught:
        read_states(publisher(["shoulder"], MAIN), publisher(["elbow"], MAIN[:50] + 10 * NANO), hold="rest")
    what = "log: messages about 'elbow' and those about the other joints are of different times (record them together)"
    assert str(caught.value) == what
