"""Units that a motion cannot be in are doubted, those of sane motions are not; rates are held against positions.

Sane motions: every joint swings through 4 to 90 % of its range, at 2 to 90 % of its limit of speed (of 5 rad/s, 1 m/s
without one), sampled at 1 ms to 0.1 s, or as 5 to 12 way-points 0.5 to 5 s apart. Of 651 such motions of 75 robots none
is doubted, with another unit all 1899 whose stamps are in ms, us or ns are told, and all 597 in degrees of robots whose
joints have limits; of 4 robots without none is, since nothing tells.
"""

from __future__ import annotations

import json
import re
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import run
from helpers.example_robots import LARGE, PATHS
from helpers.oracles import ROBOTS, robot
from helpers.robot_catalogue import FOLDER, belonging, names
from helpers.sampled import sampled

import robodyn
from robodyn.errors import Caveat, WrongUnits
from robodyn.loads.example_motion import example_motion
from robodyn.report.limits import limits_verdict
from robodyn.robot.load import load
from robodyn.robot.model import Model
from robodyn.scene.read import load_scene
from robodyn.scene.scene import Scene
from robodyn.trajectory.columns.signals import Signal, Signals
from robodyn.trajectory.motion import Trajectory
from robodyn.trajectory.read import from_arrays, motion, open_trajectory, read_motion, signals

SLIPS = {"ms": (1e3, 1.0), "us": (1e6, 1.0), "ns": (1e9, 1.0), "deg": (1.0, 180 / np.pi)}
"""What a slip multiplies stamps and angles by."""
STEPS = (0.001, 0.002, 0.005, 0.01, 0.05, 0.1)


def random_motion(model: Model, rng: np.random.Generator, waypoints: bool) -> tuple[np.ndarray, ...]:
    """Stamps, q, qd, qdd of a sane motion."""
    rows, step = (int(rng.integers(5, 13)), rng.uniform(0.5, 5)) if waypoints else (150, rng.choice(STEPS))
    time = np.arange(rows) * step
    q, qd, qdd = (np.zeros((rows, k)) for k in (model.nq, model.n, model.n))
    for joint in model.independent:
        if joint.kind == "floating":
            q[:, joint.coordinate + 6] = 1.0
            continue
        usual = 1.0 if joint.kind == "prismatic" else 5.0
        lower, upper = (-2.0 if joint.lower is None else joint.lower), (2.0 if joint.upper is None else joint.upper)
        lower, upper = (max(lower, -7.0), min(upper, 7.0)) if lower < upper else (-2.0, 2.0)
        h = rng.uniform(0.02, 0.45) * (upper - lower)
        c = rng.uniform(lower + h, upper - h)
        w = rng.uniform(0.02, 0.9) * min(joint.velocity or usual, usual) / h
        phase = w * time + rng.uniform(0, 2 * np.pi)
        q[:, joint.coordinate] = c + h * np.sin(phase)
        qd[:, joint.rate], qdd[:, joint.rate] = h * w * np.cos(phase), -h * w * w * np.sin(phase)
    return time, q, qd, qdd


def slipped(model: Model, given: tuple[np.ndarray, ...], slip: str) -> Trajectory:
    """The motion as it is read if its stamps or angles are in another unit."""
    time, q, qd, qdd = (x.copy() for x in given)
    ticks, parts = SLIPS[slip]
    for joint in model.independent:
        if joint.kind == "revolute":
            q[:, joint.coordinate] *= parts
            qd[:, joint.rate] *= parts
            qdd[:, joint.rate] *= parts
    return motion(model, time * ticks, q, qd / ticks, qdd / ticks**2)


def of_units(given: Trajectory) -> list[Caveat]:
    """What is doubted of units; that interpolated rates are not those of the positions is another matter."""
    return [caveat for caveat in given.caveats if isinstance(caveat, WrongUnits)]


def found(model: Model, seeds: range) -> Counter[str]:
    """How many sane motions are doubted ("sane"), and how many of each slip are with the option that mends it."""
    count: Counter[str] = Counter()
    for seed in seeds:
        rng = np.random.default_rng(seed)
        given = random_motion(model, rng, waypoints=seed % 3 == 2)
        count["sane"] += bool(of_units(motion(model, *given)))
        for slip in SLIPS:
            option = "--angle-unit deg" if slip == "deg" else f"--time-unit {slip}"
            count[slip] += any(option in caveat.text for caveat in slipped(model, given, slip).caveats)
    return count


def limited(model: Model) -> bool:
    """Whether a joint that turns has limits, without which degrees cannot be told from radians."""
    turning = [joint for joint in model.independent if joint.kind == "revolute" and not joint.continuous]
    return any(joint.lower is not None and joint.lower < joint.upper < 100.0 for joint in turning)


ROBOTS_AND_SEEDS = [
    ("puma560", range(1)),
    ("scara", range(1)),
    pytest.param("scara", range(1, 4), marks=pytest.mark.slow),
]


@pytest.mark.parametrize(("name", "seeds"), ROBOTS_AND_SEEDS)
def test_motions_at_any_speed_are_not_doubted(name: str, seeds: range) -> None:
    """From a ten-thousandth of the limits of speed to five times these, densely sampled, and with glitches of a row."""
    model = load(str(FOLDER / f"{name}.urdf"))
    for seed in seeds:
        rng = np.random.default_rng(seed)
        time, *given = random_motion(model, rng, waypoints=False)
        factor = 10.0 ** rng.uniform(-4.0, 0.7)
        stretched = time / factor
        if stretched[1] - stretched[0] > 0.1:  # rows as far apart as in another unit of time
            stretched = np.arange(len(time)) * 0.1
            given = [np.array([np.interp(stretched, time / factor, x) for x in each.T]).T for each in given]
        q, qd, qdd = given[0], given[1] * factor, given[2] * factor**2
        assert of_units(motion(model, stretched, q, qd, qdd)) == []
        glitch = q.copy()
        glitch[rng.integers(20, len(q) - 20), rng.integers(model.nq)] += rng.uniform(-0.2, 0.2)
        assert of_units(motion(model, stretched, glitch)) == []


@pytest.mark.parametrize(("name", "seeds"), ROBOTS_AND_SEEDS)
@pytest.mark.parametrize("order", [1, 2], ids=["qd", "qdd"])
def test_rates_in_another_unit_than_positions(name: str, order: int, seeds: range) -> None:
    """Velocities or accelerations alone are in degrees or millimetres, with noise of a hundredth or without."""
    model = load(str(FOLDER / f"{name}.urdf"))
    for seed in seeds:
        rng = np.random.default_rng(seed)
        time, *given = random_motion(model, rng, waypoints=False)
        if (np.abs(np.diff(given[0], axis=0)).max(axis=0) > 0.15 * np.ptp(given[0], axis=0)).any():
            continue  # too few samples a period to tell anything of rates
        for kind, parts, unit in (("revolute", 180 / np.pi, "deg"), ("prismatic", 1000.0, "mm")):
            joints = [joint for joint in model.independent if joint.kind == kind]
            if joints:
                rates = given[order].copy()
                rates[:, [joint.rate for joint in joints]] *= parts
                rates += 0.01 * rates.std(axis=0) * rng.standard_normal(rates.shape) * (seed % 2)
                given_now = [*given[:order], rates, *given[order + 1 :]]
                said = " ".join(caveat.text for caveat in motion(model, time, *given_now).caveats)
                assert f"[{unit}/s{'^2' * (order - 1)}]=" in said
                told = of_units(motion(model, time, *given_now, angle_unit="rad"))
                assert kind == "prismatic" or told == []


OTHERS = [*(FOLDER / f"{name}.urdf" for name in names()[::6]), *(x for x in PATHS[::8] if not x.stem.startswith(LARGE))]


@pytest.mark.parametrize(
    "path",
    [FOLDER / "cylindrical.urdf", *(pytest.param(path, marks=pytest.mark.slow) for path in OTHERS)],
    ids=lambda path: path.stem,
)
def test_slips_are_told_and_sane_motions_are_not_doubted(path: Path) -> None:
    model = load(path)
    told = 3 if any(joint.kind != "floating" for joint in model.independent) else 0
    count = found(model, range(3))
    if path.parent == FOLDER and not limited(model):
        count["deg"] = 0  # some may be told by limits of speed
    assert count == {**dict.fromkeys(SLIPS, told), "sane": 0, "deg": told if limited(model) else 0}


@pytest.mark.parametrize(
    "path", sampled([*sorted(FOLDER.glob("*.urdf")), *PATHS[::28]], 12), ids=lambda path: path.stem
)
def test_example_motions_are_not_doubted(path: Path) -> None:
    model = load(path)
    _, time, columns = example_motion(model)
    rows = columns[:: len(time) // 100]
    q, qd, qdd = np.split(rows, (model.nq, model.nq + model.n), axis=1)
    assert motion(model, time[:: len(time) // 100], q, qd, qdd).caveats == ()


TABLES = [path for path in sorted(FOLDER.glob("*.csv")) if path.read_text().startswith(("time,", "t,"))]


@pytest.mark.parametrize("table", sampled(TABLES, 8), ids=lambda path: path.stem)
def test_our_tables_are_not_doubted(table: Path) -> None:
    moving = "base_" in table.read_text().partition("\n")[0]
    name = next(name for name in names() if table in belonging(name, ".csv"))
    model = load(str(FOLDER / f"{name}.urdf"), moving_base=moving)
    own = table.with_suffix(".toml")
    with read_motion(table, model, load_scene(own) if own.exists() else Scene(), ignore_extra=True) as reader:
        assert [block.caveats for block in reader.blocks()][-1] == ()


ARM = load(str(FOLDER / "puma.urdf"))


@pytest.mark.parametrize(
    ("ticks", "start", "said"),
    [
        (1e3, 0.0, "rows are 10 s apart and no joint moves faster than 0.067 %"),
        (1e6, 0.0, "are the stamps microseconds? (--time-unit us, or --time-unit s"),
        (1e3, 1.7e9, "are the stamps milliseconds?"),
    ],
)
def test_words_about_stamps(ticks: float, start: float, said: str) -> None:
    time = np.arange(50) / 100
    q = np.tile(0.2 * np.sin(5 * time)[:, None], (1, ARM.n))
    (caveat,) = motion(ARM, (start + time) * ticks, q).caveats
    assert caveat.kind == "if the stamps are seconds (assumed)"
    assert said in caveat.text
    (short,) = motion(ARM, time, q, time_unit="ms").caveats
    assert "times their limit of speed: are the stamps seconds? (--time-unit s)" in short.text


def test_units_that_are_told_are_not_doubted() -> None:
    """A motion that is slow, or beyond all limits, on purpose."""
    time = np.arange(50) * 10.0
    q = np.tile(0.2 * np.sin(time / 200)[:, None], (1, ARM.n))
    assert motion(ARM, time, q).caveats
    assert motion(ARM, time, q, time_unit="s").caveats == ()
    assert motion(ARM, time / 1e3, 90 * q).caveats
    assert motion(ARM, time / 1e3, 90 * q, angle_unit="rad").caveats == ()


def test_lengths_in_millimetres_are_doubted() -> None:
    model = load(str(FOLDER / "scara.urdf"))
    time = np.arange(50) / 100
    q = np.tile(0.05 * np.sin(5 * time)[:, None], (1, 3)) * (1, 1, 1000)
    (caveat,) = motion(model, time, q).caveats
    assert caveat.kind == "if lengths are metres (assumed)"
    assert "are these millimetres? (--map 'q_quill [mm]=q[3]'" in caveat.text


def test_ranges_are_those_of_all_blocks(tmp_path: Path) -> None:
    """Only the second block is beyond the limits, and only its own and later ones are doubted."""
    path, time = tmp_path / "t.csv", np.arange(200) / 100
    names_of = ",".join(f"{kind}_{name}" for kind in ("q", "qd", "qdd") for name in ARM.joint_names)
    rows = np.column_stack((time, *([60.0 * (time > 1.5)] * 3), *([0 * time] * 6)))
    np.savetxt(path, rows, delimiter=",", header=f"time,{names_of}", comments="")
    with open_trajectory(path, signals(ARM), block_rows=100) as reader:
        assert [len(block.caveats) for block in reader.blocks()] == [0, 1]


ONE = Signals((Signal("a", "angle"),))
TIME = np.arange(0.0, 1.2, 1e-3)


def swing(n: int, time: np.ndarray = TIME, hertz: float = 1.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Positions, velocities and accelerations of n joints that swing by half a radian."""
    w, phase = 2 * np.pi * hertz, hertz * 2 * np.pi * time[:, None] + np.arange(n)
    return 0.5 * np.sin(phase), 0.5 * w * np.cos(phase), -0.5 * w * w * np.sin(phase)


def read(q: np.ndarray, bits: int) -> np.ndarray:
    step = 2 * np.pi / 2**bits
    return step * np.round(q / step)


def gradients(q: np.ndarray, time: np.ndarray = TIME) -> tuple[np.ndarray, np.ndarray]:
    qd = np.gradient(q, time, axis=0)
    return qd, np.gradient(qd, time, axis=0)


def test_bars_of_accelerations_that_are_differences_hold_the_largest_torque() -> None:
    """89.8 N m "error 0.0" was printed where 6.9 is true, and no limit was said to be exceeded."""
    model = robot("puma560")
    q, qd, qdd = swing(model.n)
    true = np.abs(robodyn.inverse_dynamics(model, q, qd, qdd)).max(axis=0)
    given = read(q, 13)
    rates = gradients(given)
    found = robodyn.torques(model, robodyn.motion(model, TIME, given, *rates))
    for joint, largest in zip(found.joints, true, strict=True):
        assert abs(abs(joint.peak) - largest) <= joint.error_bar
    assert any(
        "accelerations are off by" in caveat.text and "--derivatives anew" in caveat.text for caveat in found.caveats
    )
    assert limits_verdict(found).level != "good"
    anew = robodyn.torques(model, robodyn.motion(model, TIME, given, *rates, derivatives="anew"))
    assert not any("anew" in caveat.text for caveat in anew.caveats)
    for joint, largest in zip(anew.joints, true, strict=True):
        assert abs(abs(joint.peak) - largest) <= joint.error_bar <= largest


def test_a_delay_is_told() -> None:
    delay = 0.005
    q, qd, _ = swing(1)
    late = swing(1, TIME - delay)[2]
    (caveat,) = from_arrays(ONE, TIME, q, qd, late).caveats
    told = float(re.search(r"([\d.]+) ms late", caveat.text)[1])  # type: ignore[index]
    assert told == pytest.approx(1e3 * delay, rel=0.1)


@pytest.mark.parametrize("hertz", [2.0, 120.0])
def test_exact_rates_are_not_doubted_however_fast(hertz: float) -> None:
    motion = from_arrays(ONE, TIME, *swing(1, hertz=hertz))
    assert not motion.caveats
    assert motion.sampling is not None
    assert motion.sampling.off.max() <= 1e-3 * np.abs(motion.qdd).max()


def test_what_nothing_was_compared_with_has_no_bar() -> None:
    model, time = robot("puma560"), np.linspace(0.0, 1.0, 12)
    found = robodyn.torques(model, robodyn.motion(model, time, *swing(model.n, time)))
    assert {joint.error_bar for joint in found.joints} == {None}


def test_the_encoders_error_goes_into_the_bar(tmp_path: Path) -> None:
    """An error that repeats with the angle moves with the motion: positions alone do not tell it."""
    model = robot("two_link_planar")
    q, qd, qdd = swing(model.n)
    size = 2e-5
    given = q + size * np.sin(256 * q)
    true = np.abs(robodyn.inverse_dynamics(model, q, qd, qdd)).max(axis=0)
    found, bars = {}, []
    for error in (0.0, size):
        loads = robodyn.torques(model, robodyn.motion(model, TIME, given, encoder_error=error)).joints
        off = [abs(abs(joint.peak) - x) / joint.error_bar for joint, x in zip(loads, true, strict=True)]
        found[error] = max(off)
        bars.append([joint.error_bar for joint in loads])
    assert found[size] <= 1.0 < found[0.0]
    table = tmp_path / "read.csv"
    head = ",".join(["time", *(f"q_{name}" for name in model.coordinates)])
    np.savetxt(table, np.column_stack((TIME, given)), delimiter=",", header=head, comments="", fmt="%.17g")
    outcome = run(
        "torques", str(ROBOTS / "two_link_planar.urdf"), str(table), "--format", "json", "--encoder-error", f"{size}"
    )
    assert outcome.status == 0, outcome.err
    assert [joint["error_bar"] for joint in json.loads(outcome.out)["joints"]] == pytest.approx(bars[1], rel=1e-6)
    assert run("torques", str(ROBOTS / "two_link_planar.urdf"), str(table), "--encoder-error", "-1").status == 2
