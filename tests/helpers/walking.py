"""Real robots that stand, shift their weight and walk: the feet and the base follow paths, the legs follow by Newton.

The base stays level and may turn about the vertical; soles stay level and do not turn. Between steps the base moves
until the mass centre is about above the feet that stand; then the next foot is lifted, carried on and put down.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from helpers.example_robots import real
from robodyn.dynamics.constraints.constraint_jacobian import contact_jacobian
from robodyn.dynamics.plan import plan
from robodyn.robot.kinematics import body_poses, configuration
from robodyn.robot.model import Model
from robodyn.scene.scene import Contact, Scene
from robodyn.trajectory.motion import Trajectory
from robodyn.trajectory.read import motion

POINT = ((0.0, 0.0, 0.0),)
SPACING = 0.02
"""Step in time of the differences by which J' qd is found [s]."""
Move = tuple[float, float, float]
"""When it begins and ends [s], and by how much [m or rad]."""


@dataclass(frozen=True)
class Walker:
    """A robot and how it stands.

    Attributes:
        stem: of its description.
        feet: links by name, in the order of the steps.
        sole: the points of each foot, in its link's frame [m].
        posture: of its joints [rad], the others being 0.
        stride, lift: of a step [m].
        shift, swing: how long the weight is shifted and a foot is in the air [s].
        over: how far the weight is shifted, from the middle of all feet to the middle of those that will stand.
    """

    stem: str
    feet: Mapping[str, str]
    sole: tuple[tuple[float, float, float], ...]
    posture: Mapping[str, float]
    stride: float
    lift: float
    shift: float = 1.0
    swing: float = 0.8
    over: float = 0.8

    @property
    def model(self) -> Model:
        return real(self.stem, moving_base=True)

    def scene(self, on: str = "on_", **more: float) -> Scene:
        """Each foot stands where its column `on_<foot>` says so; more: of each Contact."""
        contacts = (Contact(name, link, self.sole, on=f"{on}{name}", **more) for name, link in self.feet.items())
        return Scene(moving_base=True, contacts=tuple(contacts))


@dataclass(frozen=True)
class Walk:
    """A motion: q (N, nq), qd and qdd (N, n), and the columns `on_<foot>` (N,)."""

    walker: Walker
    time: np.ndarray
    q: np.ndarray
    qd: np.ndarray
    qdd: np.ndarray
    columns: Mapping[str, np.ndarray]

    def trajectory(self, scene: Scene, more: Mapping[str, np.ndarray] | None = None) -> Trajectory:
        columns = {**self.columns, **(more or {})}
        known = {name: columns[name] for name in scene.motion_columns}
        return motion(self.walker.model, self.time, self.q, self.qd, self.qdd, scene=scene, columns=known)


def _legs(front: str, hind: str, joints: Sequence[str], angles: Sequence[float], mirrored: bool) -> dict[str, float]:
    """A posture of four legs; hind ones may bend the other way."""
    found = {}
    for leg in (*front.split(), *hind.split()):
        sign = -1.0 if mirrored and leg in hind.split() else 1.0
        found |= {f"{leg}_{joint}": sign * angle for joint, angle in zip(joints, angles, strict=True)}
    return found


def _sides(names: str, angles: Sequence[float]) -> dict[str, float]:
    """A posture of hip, knee and ankle, alike on both sides."""
    return {
        name.replace("SIDE", side): angle
        for side in ("left", "right")
        for name, angle in zip(names.split(), angles, strict=True)
    }


WALKERS = {
    "ANYmal": Walker(
        "anymal",
        {"lh": "LH_FOOT", "lf": "LF_FOOT", "rh": "RH_FOOT", "rf": "RF_FOOT"},
        POINT,
        _legs("LF RF", "LH RH", ("HFE", "KFE"), (0.6, -1.1), True),
        stride=0.12,
        lift=0.08,
    ),
    "Go2": Walker(
        "go2",
        {"rl": "RL_foot", "fl": "FL_foot", "rr": "RR_foot", "fr": "FR_foot"},
        POINT,
        _legs("FL FR", "RL RR", ("thigh_joint", "calf_joint"), (0.9, -1.8), False),
        stride=0.08,
        lift=0.05,
    ),
    "G1": Walker(
        "g1_29dof_rev_1_0",
        {"left": "left_ankle_roll_link", "right": "right_ankle_roll_link"},
        ((-0.05, -0.025, -0.03), (0.12, -0.03, -0.03), (0.12, 0.03, -0.03), (-0.05, 0.025, -0.03)),
        _sides("SIDE_hip_pitch_joint SIDE_knee_joint SIDE_ankle_pitch_joint", (-0.4, 0.8, -0.4)),
        stride=0.12,
        lift=0.05,
        shift=2.0,
        swing=1.6,
        over=1.0,
    ),
    "TALOS": Walker(
        "talos_full_v2",
        {"left": "left_sole_link", "right": "right_sole_link"},
        ((-0.1, -0.06, 0), (0.1, -0.06, 0), (0.1, 0.06, 0), (-0.1, 0.06, 0)),
        _sides("leg_SIDE_3_joint leg_SIDE_4_joint leg_SIDE_5_joint", (-0.45, 0.9, -0.45))
        | {"arm_left_2_joint": 0.3, "arm_right_2_joint": -0.3},
        stride=0.2,
        lift=0.06,
        shift=2.0,
        swing=1.6,
        over=1.0,
    ),
}


def walk(walker: Walker, count: int, steps: int, turn: float = 0.0) -> Walk:
    """Return `steps` steps, then a shift back, at `count` times; turn: of the base to and fro [rad]."""
    model, feet = walker.model, list(walker.feet)
    paths = _Paths(walker, _standing(walker))
    for step in range(steps):
        paths.step(feet[step % len(feet)], walker.stride * (0.5 if step == 0 and len(feet) == 2 else 1.0))
    end = paths.back(turn)
    time = np.linspace(0.0, end, count)
    return _followed(walker, model, paths, time)


def sway(walker: Walker, count: int, by: float, turn: float = 0.0) -> Walk:
    """Return a shift of the weight by (by, by / 2) m and back; it begins and ends at rest, and feet stay."""
    paths = _Paths(walker, _standing(walker))
    for k, sign in enumerate((1.0, -1.0)):
        paths.base[0].append((0.2 + k, 1.2 + k, 0.5 * sign * by))
        paths.base[1].append((0.2 + k, 1.2 + k, sign * by))
    paths.clock = 2.2
    return _followed(walker, walker.model, paths, np.linspace(0.0, paths.back(turn), count))


def _standing(walker: Walker) -> np.ndarray:
    """Return q (nq,) of the posture, the lowest points of its feet at height 0."""
    model = walker.model
    q = np.array(configuration(model, dict(walker.posture)))
    q[model.independent[0].coordinate + 2] -= _map(walker, q[None], np.zeros((1, model.n))).places[0, :, 2].min()
    return q


def _map(walker: Walker, q: np.ndarray, qd: np.ndarray):
    return contact_jacobian(plan(walker.model, walker.scene()), q, qd, "auto")


def _mass_centre(model: Model, q: np.ndarray) -> np.ndarray:
    """Return (3,) the mass centre in the axes of the ground [m]."""
    moments = [
        body.inertia.m * np.asarray(pose.p, dtype=float) + np.asarray(pose.R @ body.inertia.mc, dtype=float)
        for body, pose in zip(model.bodies, body_poses(model, q), strict=True)
    ]
    return sum(moments) / model.total_mass


@dataclass
class _Paths:
    """Where the base (x, y, z, yaw) and the feet go, as sums of moves.

    Attributes:
        clock: when the last move ends [s].
        lifts: by foot, when it is in the air.
    """

    walker: Walker
    q: np.ndarray
    clock: float = 0.2
    base: tuple[list[Move], ...] = field(default_factory=lambda: ([], [], [], []))
    gone: dict[str, list[Move]] = field(default_factory=dict)
    lifts: dict[str, list[tuple[float, float]]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        places = _map(self.walker, self.q[None], np.zeros((1, self.walker.model.n))).places[0]
        feet = places.reshape(len(self.walker.feet), -1, 3)
        self.corners = dict(zip(self.walker.feet, feet, strict=True))
        self.feet = {name: corners.mean(axis=0)[:2] for name, corners in self.corners.items()}
        self.at = _mass_centre(self.walker.model, self.q)[:2]
        self.gone, self.lifts = {name: [] for name in self.feet}, {name: [] for name in self.feet}

    def step(self, foot: str, stride: float) -> None:
        """Shift the weight off a foot, and carry it forward."""
        others = np.mean([place for name, place in self.feet.items() if name != foot], axis=0)
        middle = np.mean(list(self.feet.values()), axis=0)
        self._shift(middle + self.walker.over * (others - middle))
        start, end = self.clock, self.clock + self.walker.swing
        self.gone[foot].append((start, end, stride))
        self.lifts[foot].append((start, end))
        self.feet[foot] = self.feet[foot] + (stride, 0.0)
        self.clock = end

    def back(self, turn: float) -> float:
        """Shift the weight back into the middle; return when all is over."""
        self._shift(np.mean(list(self.feet.values()), axis=0))
        half = 0.5 * self.clock
        self.base[3].extend([(0.0, half, turn), (half, self.clock, -turn)])
        return self.clock + 0.2

    def _shift(self, to: np.ndarray) -> None:
        end = self.clock + self.walker.shift
        for axis in (0, 1):
            self.base[axis].append((self.clock, end, to[axis] - self.at[axis]))
        self.at, self.clock = to, end

    def base_at(self, time: np.ndarray) -> np.ndarray:
        """Return (3, N, 4) place and yaw, rates and accelerations."""
        found = np.stack([_moved(time, moves) for moves in self.base], axis=-1)
        start = self.walker.model.independent[0].coordinate
        found[0, :, :3] += self.q[start : start + 3]
        return found

    def points_at(self, time: np.ndarray) -> np.ndarray:
        """Return (3, N, K, 3) places, speeds and accelerations of all points."""
        found = []
        for name, corners in self.corners.items():
            foot = np.zeros((3, len(time), 3))
            foot[:, :, 0] = _moved(time, self.gone[name])
            foot[:, :, 2] = sum((_lifted(time, *lift, self.walker.lift) for lift in self.lifts[name]), foot[:, :, 2])
            points = np.repeat(foot[:, :, None], len(corners), axis=2)
            points[0] += corners
            found.append(points)
        return np.concatenate(found, axis=2)


def _moved(time: np.ndarray, moves: Sequence[Move]) -> np.ndarray:
    """Return (3, N) the sum of moves by `s^3 (10 - 15 s + 6 s^2)`, and its rates."""
    found = np.zeros((3, len(time)))
    for start, end, by in moves:
        length = end - start
        s = np.clip((time - start) / length, 0.0, 1.0)
        found[0] += by * s**3 * (10.0 - 15.0 * s + 6.0 * s * s)
        found[1] += by * 30.0 * s**2 * (1.0 - s) ** 2 / length
        found[2] += by * 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / length**2
    return found


def _lifted(time: np.ndarray, start: float, end: float, height: float) -> np.ndarray:
    """Return (3, N) of `64 height (s (1 - s))^3`."""
    length = end - start
    s = np.clip((time - start) / length, 0.0, 1.0)
    u, rate = s * (1.0 - s), (1.0 - 2.0 * s) / length
    second = 6.0 * u * rate**2 - 6.0 * u**2 / length**2
    return 64.0 * height * np.array([u**3, 3.0 * u**2 * rate, second])


def _followed(walker: Walker, model: Model, paths: _Paths, time: np.ndarray) -> Walk:
    """Return the motion of base and legs."""
    base, points = paths.base_at(time), paths.points_at(time)
    legs = _legs_of(walker)
    q = _with_base(model, np.repeat(paths.q[None], len(time), axis=0), base[0])
    rest = np.zeros((len(time), model.n))
    for _ in range(12):
        here = _map(walker, q, rest)
        q = _integrated(model, q, _leg_rates(walker, legs, here.J, points[0] - here.places))
    J = _map(walker, q, rest).J
    moving = _base_rates(model, base[1], len(time))
    qd = moving + _leg_rates(walker, legs, J, points[1] - _pushed(J, moving))
    moving = _base_rates(model, base[2], len(time))
    bias = _bias(walker, model, q, qd)
    qdd = moving + _leg_rates(walker, legs, J, points[2] - bias - _pushed(J, moving))
    columns = {}
    for name, lifts in paths.lifts.items():
        up = np.any([(time > start) & (time < end) for start, end in lifts], axis=0) if lifts else np.zeros(len(time))
        columns[f"on_{name}"] = 1.0 - up
    return Walk(walker, time, q, qd, qdd, columns)


def _legs_of(walker: Walker) -> list[list[int]]:
    """Return the rates of the joints between the base and each foot."""
    model, found = walker.model, []
    for link in walker.feet.values():
        body, rates = model.links[link].body, []
        while body >= 0:
            joint = model.bodies[body].joint
            rates += [joint.rate] if joint.kind == "revolute" else []
            body = model.parents[body]
        found.append(rates)
    return found


def _leg_rates(walker: Walker, legs: list[list[int]], J: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Return (N, n) rates of legs by which their points have speeds (N, K, 3), least squares."""
    samples, count = len(J), 3 * len(walker.sole)
    found, wanted = np.zeros((samples, J.shape[2])), wanted.reshape(samples, -1)
    for i, rates in enumerate(legs):
        rows = slice(i * count, (i + 1) * count)
        found[:, rates] = np.einsum("nij,nj->ni", np.linalg.pinv(J[:, rows][:, :, rates], rcond=1e-8), wanted[:, rows])
    return found


def _pushed(J: np.ndarray, rates: np.ndarray) -> np.ndarray:
    return np.einsum("nki,ni->nk", J, rates).reshape(len(J), -1, 3)


def _with_base(model: Model, q: np.ndarray, base: np.ndarray) -> np.ndarray:
    """Return q with the base's place and yaw (N, 4)."""
    q, i = q.copy(), model.independent[0].coordinate
    zero = np.zeros(len(q))
    q[:, i : i + 7] = np.column_stack((base[:, :3], zero, zero, np.sin(base[:, 3] / 2), np.cos(base[:, 3] / 2)))
    return q


def _base_rates(model: Model, base: np.ndarray, samples: int) -> np.ndarray:
    """Return (N, n) rates of the base alone, of its place and yaw (N, 4)."""
    found, k = np.zeros((samples, model.n)), model.independent[0].rate
    found[:, k + 2], found[:, k + 3 : k + 6] = base[:, 3], base[:, :3]
    return found


def _integrated(model: Model, q: np.ndarray, by: np.ndarray) -> np.ndarray:
    """Return q after steps by (N, n), the base turning about the vertical."""
    q = q.copy()
    for joint in model.independent:
        if joint.kind == "floating":
            i, k = joint.coordinate, joint.rate
            yaw = 2.0 * np.arctan2(q[:, i + 5], q[:, i + 6]) + by[:, k + 2]
            q = _with_base(model, q, np.column_stack((q[:, i : i + 3] + by[:, k + 3 : k + 6], yaw)))
        else:
            q[:, joint.coordinate] += by[:, joint.rate]
    return q


def _bias(walker: Walker, model: Model, q: np.ndarray, qd: np.ndarray) -> np.ndarray:
    """Return (N, K, 3) J' qd, by central differences of order 6 along the motion."""
    found = 0.0
    for k, weight in ((1, 45.0), (2, -9.0), (3, 1.0)):
        after = _map(walker, _integrated(model, q, k * SPACING * qd), qd).speeds
        before = _map(walker, _integrated(model, q, -k * SPACING * qd), qd).speeds
        found = found + weight * (after - before) / (60.0 * SPACING)
    return found
