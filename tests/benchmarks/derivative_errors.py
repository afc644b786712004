"""What differentiation costs: errors of qdd, and of torques made with it, by method, on clean and on encoder data."""

from __future__ import annotations

import numpy as np
from helpers.markdown_tables import table
from helpers.oracles import robot

import robodyn

METHODS = ("`numpy.gradient` twice", "central", "spline", "savgol", "auto")
HEAD = ("method", "sine at 10 ms, qdd: middle", "ends", "encoder at 1 ms, torque: middle", "ends")
FREQUENCIES = np.array([1.0, 0.7, 1.3])
AMPLITUDES = np.array([0.5, 0.4, 0.6])
COUNT = 2 * np.pi / 2**17
"""Step of an encoder of 17 bits [rad]."""


def swing(time):
    """q, qd and qdd of three joints that swing at different frequencies."""
    w = 2 * np.pi * FREQUENCIES
    angle = time[:, None] * w + np.array([0.0, 1.0, 2.0])
    return AMPLITUDES * np.sin(angle), AMPLITUDES * w * np.cos(angle), -AMPLITUDES * w**2 * np.sin(angle)


def derived(method, time, q):
    """qd and qdd by a method of robodyn, or by numpy."""
    if method == METHODS[0]:
        qd = np.gradient(q, time, axis=0)
        return qd, np.gradient(qd, time, axis=0)
    motion = robodyn.motion(robot("puma"), time, q, derivatives=method)
    return motion.qd, motion.qdd


def by_place(off):
    """The largest of errors (N, c) in the middle half of the samples, and of all."""
    rows = off.max(axis=1)
    quarter = len(rows) // 4
    return rows[quarter:-quarter].max(), rows.max()


def on_sine(method):
    """Errors of qdd of sin(2 pi t) at 10 ms [rad/s^2]."""
    time = np.arange(401) * 0.01
    q = np.repeat(np.sin(2 * np.pi * time)[:, None], 3, axis=1)
    return by_place(np.abs(derived(method, time, q)[1] + 4 * np.pi**2 * q))


def on_encoder(method):
    """Errors of the torques of the PUMA [N m] whose positions an encoder reads at 1 ms, and its largest torque."""
    time = np.arange(2001) * 0.001
    q, qd, qdd = swing(time)
    read = np.round(q / COUNT) * COUNT
    model = robot("puma")
    tau = robodyn.inverse_dynamics(model, q, qd, qdd)
    off = robodyn.inverse_dynamics(model, read, *derived(method, time, read)) - tau
    return *by_place(np.abs(off)), np.abs(tau).max()


def two_digits(x):
    return f"{float(f'{x:.2g}'):g}"


def derivatives_table():
    rows = []
    for method in METHODS:
        *torque, largest = on_encoder(method)
        rows.append(
            (
                method if method == METHODS[0] else f"`--derivatives {method}`",
                *(f"{x:.0e} rad/s^2" for x in on_sine(method)),
                *(f"{two_digits(x)} N m" for x in torque),
            )
        )
    return table(HEAD, rows) + f"\nThe largest torque of the arm is {largest:.0f} N m.\n"
