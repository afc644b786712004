"""Too few samples to derive accelerations, or to check the energy: in the error bar, in warnings, never green.

One row is a robot at rest, with what rates it gives; two rows are too few to differentiate.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from helpers.command_line import ARM, ROBOTS, run
from helpers.exact_motions import linear_accelerations, minimum_jerk
from helpers.oracles import robot
from helpers.sampled import sampled

import robodyn
from robodyn.errors import TOO_FEW
from robodyn.report.limits import limits_verdict

DURATION = 4.0
ENOUGH = 0.93
Rates = tuple[np.ndarray, np.ndarray, np.ndarray]
Motion = Callable[[np.ndarray], Rates]


def sine(t: np.ndarray) -> Rates:
    w = 2 * np.pi / DURATION
    return np.sin(w * t + 0.7), w * np.cos(w * t + 0.7), -w * w * np.sin(w * t + 0.7)


def through(points: tuple[float, ...], shape: Callable[[np.ndarray], Rates]) -> Motion:
    """From point to point, at rest in each."""
    T = DURATION / (len(points) - 1)

    def motion(t: np.ndarray) -> Rates:
        k = np.minimum((t / T).astype(int), len(points) - 2)
        step = np.diff(points)[k]
        s, v, c = shape(t / T - k)
        return np.array(points)[k] + step * s, step * v / T, step * c / T**2

    return motion


POINTS = (0.0, 0.8, -0.4, 0.3, 1.0)
MOTIONS: dict[str, Motion] = {
    "sine": sine,
    "points by minimum jerk": through(POINTS, minimum_jerk(None, 0.0)[0]),
    "points by trapezoids": through(POINTS, linear_accelerations([(0.25, 1, 1), (0.5, 0, 0), (0.25, -1, -1)])[0]),
}
ROWS = (3, 20, 30, 60, 100, 200, 400)
TOO_FEW_BELOW = {"sine": 30, "points by minimum jerk": 60, "points by trapezoids": 200}
"""Of positions alone over 4 s: the first of ROWS that is not warned of."""
ENERGY_BELOW = {"sine": 12, "points by minimum jerk": 20, "points by trapezoids": 60}
"""Of given velocities and accelerations: the first of ROWS from which on the energy can be checked."""


def both(name: str, rows: int, rng: np.random.Generator) -> tuple[robodyn.Result, robodyn.Result, np.ndarray]:
    """What an arm bears that moves so, from positions alone and from all that is known; and the truth."""
    model = robot("puma")
    t = np.linspace(0.0, DURATION, rows)
    size, middle = rng.uniform(0.3, 1.0, (2, model.n)) * rng.choice((-1.0, 1.0), (2, model.n))
    s, v, a = (x[:, None] * size for x in MOTIONS[name](t))
    q = middle + s
    derived = robodyn.torques(model, robodyn.motion(model, t, q))
    return derived, robodyn.torques(model, robodyn.motion(model, t, q, v, a)), robodyn.inverse_dynamics(model, q, v, a)


@pytest.mark.parametrize("name", sampled(MOTIONS, 3))
def test_which_numbers_of_samples_are_too_few_and_that_error_bars_hold(name: str) -> None:
    rng, held = np.random.default_rng(1), []
    for rows in ROWS:
        derived, given, true = both(name, rows, rng)
        warned = any(caveat.kind == TOO_FEW for caveat in derived.caveats)
        assert warned == (rows < TOO_FEW_BELOW[name]), rows
        assert derived.samples_suffice is not warned
        if rows >= ENERGY_BELOW[name]:
            assert not given.caveats, rows
        assert all("too few" in caveat.kind for caveat in given.caveats)
        for k, joint in enumerate(derived.joints if rows >= 8 else ()):
            off = abs(joint.peak - true[joint.peak_row - 1, k])
            held.append(off <= joint.error_bar + 1e-9 * np.abs(true).max())
            assert rows < 400 or "sine" not in name or joint.error_bar <= 1e-3 * abs(joint.peak)
    assert np.mean(held) >= ENOUGH


def test_a_pose_that_is_held_needs_no_samples() -> None:
    model = robot("puma560")
    result = robodyn.torques(model, robodyn.motion(model, [0.0, 1.0, 2.0], np.full((3, model.n), 0.4)))
    assert not result.caveats
    assert not any(joint.error_bar for joint in result.joints)


def write(folder: Path, rows: int, effort: float = 50.0) -> tuple[str, str]:
    """The arm and positions of a move from point to point."""
    (folder / "arm.urdf").write_text(ARM.replace('effort="50"', f'effort="{effort:g}"'))
    t = np.linspace(0.0, DURATION, rows)
    s = MOTIONS["points by minimum jerk"](t)[0]
    lines = [f"{a:.17g},{b:.17g},{-0.7 * b:.17g}" for a, b in zip(t, s, strict=True)]
    (folder / "points.csv").write_text("\n".join(["time,shoulder,elbow", *lines, ""]))
    return str(folder / "arm.urdf"), str(folder / "points.csv")


@pytest.mark.parametrize("form", ["text", "json", "md"])
def test_too_few_samples_are_in_every_report(form: str, tmp_path: Path) -> None:
    page = tmp_path / f"page.{form}"
    more = {"text": (), "json": ("--format", "json")}.get(form, ("--report", str(page)))
    outcome = run("torques", *write(tmp_path, 5, 1e4), "--fail-on-limits", *more)
    assert (outcome.status, outcome.err) == (0, "")
    shown = page.read_text() if page.exists() else outcome.out
    assert "5 samples over 4 s are too few to derive accelerations" in shown
    assert "torques that are not trusted (too few samples)" in shown
    assert "the data are clean" not in shown
    if form == "json":
        found = json.loads(shown)
        assert (found["within_limits"], found["verdict"]["level"]) == (None, "doubtful")
        assert found["checks"]["energy_balance"]["consistent"] is False
        assert all(joint["error_bar"] > 0.1 * abs(joint["peak"]) for joint in found["joints"])
    fine = run("torques", *write(tmp_path, 401, 1e4))
    assert "\nNo limit is exceeded.\n" in fine.out
    assert "the data are clean" in fine.out
    assert "error (95 %)" not in fine.out


def test_a_limit_within_the_error_bar_of_a_peak_is_not_green() -> None:
    model = robot("puma560")
    t = np.linspace(0.0, DURATION, 400)
    rng = np.random.default_rng(6)
    q = 0.5 * sine(t)[0][:, None] * np.ones(model.n) + 1e-5 * rng.standard_normal((400, model.n))
    peaks = robodyn.torques(model, robodyn.motion(model, t, q)).joints
    text = (ROBOTS / "puma560.urdf").read_text()
    waist = peaks[0]
    limit = abs(waist.peak) + 0.5 * waist.error_bar
    tight = robodyn.load(re.sub('effort="[^"]*"', f'effort="{limit!r}"', text, count=1).encode())
    result = robodyn.torques(tight, robodyn.motion(tight, t, q))
    (caveat,) = [each for each in result.caveats if "error bar" in each.kind]
    assert caveat.kind == "unless within the error bar of 'waist'"
    assert limits_verdict(result).level != "good"


@pytest.mark.parametrize(
    ("name", "given"), [("puma560", ()), ("scara", ("qd",)), ("cylindrical", ("qd", "qdd")), ("scara", ("qdd",))]
)
def test_one_row_is_taken_as_rest(name: str, given: tuple[str, ...], tmp_path: Path) -> None:
    model = robodyn.load(str(ROBOTS / f"{name}.urdf"))
    rng = np.random.default_rng(len(given))
    names = [joint.name for joint in model.independent]
    state = {kind: rng.uniform(-0.1, 0.1, model.n) for kind in ("q", "qd", "qdd")}
    used = ("q", *given)
    head = ",".join(f"{kind}_{joint}" for kind in used for joint in names)
    row = ",".join(repr(float(x)) for kind in used for x in state[kind])
    (tmp_path / "one.csv").write_text(f"time,{head}\n0,{row}\n")
    call = ("torques", str(ROBOTS / f"{name}.urdf"), str(tmp_path / "one.csv"))
    found = json.loads(run(*call, "--format", "json").out)
    still = np.zeros(model.n)
    exact = robodyn.inverse_dynamics(
        model, state["q"], *(state[kind] if kind in given else still for kind in ("qd", "qdd"))
    )
    scale = np.abs(exact).max()
    assert np.abs([joint["peak"] for joint in found["joints"]] - exact).max() <= 1e-12 * scale
    said = "one row is no motion: velocities and accelerations that it does not give are 0"
    assert any(line.startswith(said) and "fbd ROBOT --at" in line for line in found["warnings"]) == (
        not {"qd", "qdd"} <= {*given}
    )


def test_two_rows_and_explicit_derivatives_are_refused(tmp_path: Path) -> None:
    urdf = str(ROBOTS / "two_link_planar.urdf")
    first = robodyn.load(urdf).independent[0].name
    (tmp_path / "two.csv").write_text(f"time,q_{first}\n0,0.1\n1,0.2\n")
    call = ("torques", urdf, str(tmp_path / "two.csv"), "--hold", "rest")
    assert "has 2 rows, too few to differentiate" in run(*call).err
    (tmp_path / "two.csv").write_text(f"time,q_{first}\n0,0.1\n")
    assert run(*call, "--derivatives", "given").status == 2


def test_an_example_is_said_to_be_no_duty_cycle(tmp_path: Path) -> None:
    call = ("torques", str(ROBOTS / "puma560.urdf"), str(tmp_path / "m.csv"), "--example")
    said = "which is no duty cycle and reaches 40 % of the limits of speed: size by the motion that the robot will do"
    assert f"m.csv, an example motion to begin with, {said}\n" in run(*call, "--sizing").out
    (tmp_path / "m.csv").unlink()
    assert "m.csv, an example motion to begin with\n" in run(*call).out
