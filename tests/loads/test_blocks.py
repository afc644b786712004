"""One block or many: the same figures, the first of equal extremes, in memory that does not grow."""

from __future__ import annotations

from dataclasses import asdict, replace

import numpy as np
import pytest
from helpers.busy_robot import BUSY_SCENE, busy_robot
from helpers.motions import Pieces, waves
from helpers.oracles import EPS, robot
from helpers.small_robots import built, joint, link

from robodyn.dynamics.inverse import inverse_dynamics
from robodyn.errors import InputError
from robodyn.loads.accumulate import output_names
from robodyn.loads.statistics import Extremes, Greatest
from robodyn.loads.torques import torques
from robodyn.trajectory.read import motion

SAMPLES = 200
TIME = np.sort(np.random.default_rng(3).uniform(0, 4, SAMPLES))
SPLITS = {"ones": [1] * 4 + [SAMPLES - 6] + [1] * 2, "with empty ones": [0, SAMPLES - 1, 0, 1, 0]}


def _busy():
    rng = np.random.default_rng(4)
    model = busy_robot()
    columns = {name: rng.normal(size=SAMPLES) for name in BUSY_SCENE.columns}
    return model, waves(model, TIME, columns=columns), BUSY_SCENE


def _numbers(record):
    return {key: value for key, value in asdict(record).items() if isinstance(value, (int, float))}


def test_a_joint_that_begins_late_is_not_taken_for_one_at_rest():
    """The first row of a column says nothing of the others: peaks are those of inverse dynamics."""
    model = robot("puma")
    late = waves(model, TIME)
    late = replace(
        late, **{name: np.where(TIME[:, None] > TIME[9], getattr(late, name), 0.0) for name in ("qd", "qdd")}
    )
    expected = np.abs(inverse_dynamics(model, late.q, late.qd, late.qdd)).max(axis=0)
    found = [abs(joint.peak) for joint in torques(model, late).joints]
    assert np.abs(found - expected).max() <= 64 * EPS * expected.max()


@pytest.mark.parametrize("split", SPLITS)
def test_figures_do_not_depend_on_blocks(split):
    model, trajectory, scene = _busy()
    whole = torques(model, trajectory, scene)
    parts = torques(model, Pieces(trajectory, SPLITS[split]), scene)
    for one, two in zip((*whole.joints, *whole.base_wrench), (*parts.joints, *parts.base_wrench), strict=True):
        expected, found = _numbers(one), _numbers(two)
        for key, value in expected.items():
            assert abs(found[key] - value) <= 64 * EPS * abs(value), key
    assert (parts.samples, parts.duration, parts.operations) == (whole.samples, whole.duration, whole.operations)
    balance, other = whole.checks.energy_balance, parts.checks.energy_balance
    assert abs(other.work - balance.work) <= 64 * EPS * balance.turnover
    assert abs(other.energy_change - balance.energy_change) <= 64 * EPS * balance.turnover
    assert [report.verdict for report in parts.effects] == [report.verdict for report in whole.effects]
    assert [joint.shares.keys() for joint in parts.joints] == [joint.shares.keys() for joint in whole.joints]


def test_sinks_see_every_sample_once():
    model, trajectory, scene = _busy()
    once, many = [], []
    torques(model, trajectory, scene, reactions=True, sinks=[lambda *block: once.append(block)])
    torques(model, Pieces(trajectory, [50] * 4), scene, reactions=True, sinks=[lambda *block: many.append(block)])
    assert (len(once), len(many)) == (1, 4)
    np.testing.assert_array_equal(np.concatenate([time for time, _ in many]), once[0][0])
    np.testing.assert_array_equal(np.concatenate([loads for _, loads in many]), once[0][1])
    assert once[0][1].shape == (SAMPLES, len(output_names(model, True)))


def test_a_block_at_rest_between_blocks_that_move():
    """What has moved once does not fold away again; what is on is what is on in any block."""
    model = robot("puma560")
    trajectory = waves(model, np.linspace(0, 3, 300))
    still = np.ones((300, 1))
    still[100:200] = 0
    resting = replace(trajectory, qd=trajectory.qd * still, qdd=trajectory.qdd * still)
    whole, parts = torques(model, resting), torques(model, Pieces(resting, [100] * 3))
    assert [report.verdict for report in parts.effects] == [report.verdict for report in whole.effects]
    assert [joint.peak for joint in parts.joints] == [joint.peak for joint in whole.joints]
    assert parts.operations == whole.operations


@pytest.mark.parametrize("ulps", [-3, 0, 3])
def test_of_peaks_that_differ_by_rounding_the_first_counts(ulps):
    """-1 comes before 1 + a few ulp, whether or not they stand in the same block; so do its time and its row."""
    values = np.array([[0.5, -1.0, 1.0 + ulps * EPS, -1.0]])
    together, apart, extremes = Greatest(1), Greatest(1), Extremes(["x"])
    together.update(0.1 * np.arange(4), 1, np.abs(values))
    for k in range(4):
        apart.update(np.array([0.1 * k]), k + 1, np.abs(values[:, k : k + 1]))
        extremes.update(np.array([0.1 * k]), -np.abs(values[:, k : k + 1]).T)
    for peak in (together, apart):
        assert (peak.row.tolist(), peak.time.tolist()) == ([2], [0.1])
    assert extremes.ranges()[0].least_time == 0.1


def test_one_sample_and_none():
    model = robot("puma560")
    at = motion(model, [2.5], [[0.1] * 6], [[0.2] * 6], [[0.3] * 6])
    one = torques(model, at)
    assert one.warnings == model.notes
    assert (one.samples, one.duration) == (1, 0.0)
    for found in one.joints:
        assert found.mean == found.peak
        assert abs(found.rms - abs(found.peak)) <= EPS * abs(found.peak)
        assert (found.peak_time, found.peak_row, found.work_positive, found.cubic_mean) == (2.5, 1, 0.0, 0.0)
    none = replace(at, **{name: getattr(at, name)[:0] for name in ("time", "q", "qd", "qdd")})
    with pytest.raises(InputError, match="no samples"):
        torques(model, Pieces(none, [0]))


def test_a_motion_up_to_its_limits_exceeds_none():
    """And one beyond by more than rounding does, for as long as it is beyond."""
    turns = joint("j", "base", "arm").replace('"-9" upper="9"', '"-1" upper="1"').replace('"100"', '"2"')
    model = built(link("base"), link("arm", 1), turns)
    time = np.linspace(0, 1, 11)

    def found(factor):
        q, qd = factor * np.linspace(-1, 1, 11)[:, None], np.full((11, 1), 2.0 * factor)
        return torques(model, motion(model, time, q, qd, np.zeros((11, 1)))).joints[0]

    at = found(1 + 4 * EPS)
    assert (at.exceeded, at.seconds_over_velocity) == ((), 0.0)
    beyond = found(1 + 1e-8)
    assert [excess.quantity for excess in beyond.exceeded] == ["velocity", "position", "position"]
    assert beyond.seconds_over_velocity == pytest.approx(1.0)
