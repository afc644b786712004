"""Torques of robots of robots/ as their textbooks write them; (N, n) arrays in, the columns of tau out."""

from __future__ import annotations

import numpy as np

g = 9.81


def scara(q, qd, qdd):
    l1, l2, c1, c2, m1, m2, m3, I1, I2, I3 = 0.4, 0.3, 0.2, 0.15, 6, 4, 1.5, 0.13, 0.065, 0.001
    A = I1 + I2 + I3 + m1 * c1**2 + m2 * (l1**2 + c2**2) + m3 * (l1**2 + l2**2)
    B = l1 * (m2 * c2 + m3 * l2)
    C = I2 + I3 + m2 * c2**2 + m3 * l2**2
    (_, q2, _), (w1, w2, _), (a1, a2, a3) = q.T, qd.T, qdd.T
    tau1 = (A + 2 * B * np.cos(q2)) * a1 + (C + B * np.cos(q2)) * a2 - B * np.sin(q2) * (2 * w1 * w2 + w2**2)
    tau2 = (C + B * np.cos(q2)) * a1 + C * a2 + B * np.sin(q2) * w1**2
    return [tau1, tau2, m3 * (a3 - g)]


def cylindrical(q, qd, qdd):
    m2, m3, m4, Izz = 5, 3, 1, 0.431
    x3, x4 = 0.3 + q[:, 2], 0.6 + q[:, 2]
    (w, _, rd, _), (al, zdd, rdd, ddd) = qd.T, qdd.T
    turning = m3 * x3 + m4 * x4
    return [
        (Izz + m3 * x3**2 + m4 * x4**2) * al + 2 * turning * rd * w,
        (m2 + m3 + m4) * (zdd + g) - m4 * ddd,
        (m3 + m4) * rdd - turning * w**2,
        m4 * (ddd - zdd - g),
    ]


def two_link_planar_masses(q):
    """M11, M12, M22 of Craig's arm."""
    l1, l2, m1, m2 = 0.5, 0.4, 4, 2.5
    c2 = np.cos(q[:, 1])
    M11 = l2**2 * m2 + 2 * l1 * l2 * m2 * c2 + l1**2 * (m1 + m2)
    return M11, l2**2 * m2 + l1 * l2 * m2 * c2, np.full_like(M11, l2**2 * m2)


def two_link_planar(q, qd, qdd):
    l1, l2, m1, m2 = 0.5, 0.4, 4, 2.5
    M11, M12, M22 = two_link_planar_masses(q)
    (q1, q2), (w1, w2), (a1, a2) = q.T, qd.T, qdd.T
    s2, c12 = np.sin(q2), np.cos(q1 + q2)
    tau1 = M11 * a1 + M12 * a2 - m2 * l1 * l2 * s2 * (w2**2 + 2 * w1 * w2)
    tau1 += m2 * l2 * g * c12 + (m1 + m2) * l1 * g * np.cos(q1)
    return [tau1, M12 * a1 + M22 * a2 + m2 * l1 * l2 * s2 * w1**2 + m2 * l2 * g * c12]


def two_link_spatial(q, qd, qdd):
    Izz, a, m2, c, Ix, Iy, Iz = 0.09, 0.15, 3, 0.3, 0.004, 0.1, 0.102
    q2, (w1, w2), (a1, a2) = q[:, 1], qd.T, qdd.T
    r = a + c * np.cos(q2)
    k = (Ix - Iz) * np.sin(q2) * np.cos(q2) - m2 * r * c * np.sin(q2)
    M11 = Izz + Ix * np.sin(q2) ** 2 + Iz * np.cos(q2) ** 2 + m2 * r**2
    return [M11 * a1 + 2 * k * w1 * w2, (Iy + m2 * c**2) * a2 - k * w1**2 + m2 * g * c * np.cos(q2)]


TORQUES = {form.__name__: form for form in (scara, cylindrical, two_link_planar, two_link_spatial)}
