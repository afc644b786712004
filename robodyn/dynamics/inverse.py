"""Inverse dynamics and bias for arrays of samples: the Python interface to the recursion."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from robodyn.dynamics.arrays import arrays_of, check_out, results, zero_sources
from robodyn.dynamics.plan import torque_runner
from robodyn.robot.model import Model
from robodyn.scene.fit import refuse_constraints, refuse_load, refuse_others
from robodyn.scene.scene import DEFAULT, Scene
from robodyn.support.floats import Floats


def inverse_dynamics(
    model: Model,
    q: ArrayLike,
    qd: ArrayLike,
    qdd: ArrayLike,
    *,
    scene: Scene = DEFAULT,
    columns: Mapping[str, ArrayLike] | None = None,
    out: Floats | None = None,
    executor: str = "auto",
    threads: int | None = None,
    dtype: DTypeLike = np.float64,
) -> Floats:
    """tau = M(q) qdd + c(q, qd) + g(q) + friction + armature qdd + springs - J^T w.

    The recursive Newton-Euler algorithm (RNEA), traced once per model and scene, then run over all samples.

    Args:
        model: of `robodyn.load`.
        q: (..., nq) rad or m; a floating base comes first, as x y z qx qy qz qw.
        qd, qdd: (..., n) per s and per s^2; of a floating base wx wy wz (body axes) and vx vy vz (ground's axes).
            Broadcast against q; `0` is a robot at rest.
        scene: gravity, friction and so on; by default gravity (0, 0, -9.81) and the friction of the description.
        columns: (...) values of the columns that the scene's wrenches name.
        out: (..., n) of `dtype`, written to and returned if given.
        executor: "numpy" starts at once; "compiled" turns the recursion into machine code, tens of times faster per
            sample, and needs llvmlite; "auto" weighs the work. Their results differ by rounding.
        threads: of the compiled executor; None is all cores. Results do not depend on it.
        dtype: float64 or float32, of arrays and arithmetic.

    Returns:
        (..., n) N m or N, in the order of `model.rates`. The columns of a matrix are contiguous, which is fastest.

    Raises:
        InputError: a shape, or a joint or link that the scene names, does not fit the model; no such executor; loops of
            the scene are open.

    In a scene with loops, contacts or passive joints these are the torques of the drives, as `constraint_forces` finds
    them.

    Accuracy: 1e-14 of the largest torque for chains of up to 100 bodies. The executors agree within 4 ulp of it for
    real robots on a fixed base, 8 on a free one. Bit-identical wherever a fixed base stands and with every effect whose
    coefficient is zero. In float32, 1e-6 of the largest torque.
    """
    sources, shape = arrays_of(model, {"q": q, "qd": qd, "qdd": qdd}, scene, columns or {}, dtype)
    if not scene.constrained:
        runner = torque_runner(model, scene, zero_sources(sources))
        return results(runner, sources, shape, (model.n,), out, executor, threads, dtype)
    from robodyn.dynamics.constraints.inverse import constraint_forces

    found = constraint_forces(model, q, qd, qdd, scene=scene, columns=columns, executor=executor, threads=threads).tau
    if out is None:
        return found.astype(dtype, copy=False)
    check_out(out, found.shape, dtype)
    out[...] = found
    return out


def bias_forces(
    model: Model,
    q: ArrayLike,
    qd: ArrayLike,
    *,
    scene: Scene = DEFAULT,
    columns: Mapping[str, ArrayLike] | None = None,
    executor: str = "auto",
    threads: int | None = None,
) -> Floats:
    """b(q, qd) = c(q, qd) + g(q) + friction + springs - J^T w: the torque of a motion without acceleration.

    Args, returns and accuracy: as for `inverse_dynamics` with qdd = 0.

    Raises:
        InputError: as `inverse_dynamics`; or the scene has loops or contacts, whose forces follow from qdd, or friction
            that grows with load, which the torques of qdd change.
    """
    refuse_others(model, scene)
    refuse_constraints(scene)
    refuse_load(scene)
    return inverse_dynamics(model, q, qd, 0.0, scene=scene, columns=columns, executor=executor, threads=threads)
