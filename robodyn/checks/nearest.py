"""The nearest inertia that a body can have, for a tensor that none can and that no cause explains."""

from __future__ import annotations

import numpy as np

from robodyn.programs.vectors import product
from robodyn.solids.inertia.eigen import eigen
from robodyn.solids.inertia.exact import Floats

_LEAST = 1e-6
"""Of the largest second moment: the least that is left, well above what rounding and the programs' bounds take."""


def nearest(I: Floats) -> Floats | None:
    """(3, 3) I' = tr(S') 1 - S' with the S' nearest to S = tr(I) 1 / 2 - I that is positive definite [kg m^2].

    Method: the eigenvalues of S, the second moments along the principal axes, are clipped at `_LEAST` of the largest,
    which is the nearest in the Frobenius norm (Higham 1988; of the pseudo-inertia of Wensing 2018, mass and centre of
    mass being kept). With them all sums of two, the principal moments of inertia, are positive and obey the triangle
    inequality. None where no second moment is positive: nothing is near that a body can have.
    """
    moments, axes = eigen(np.trace(I) / 2.0 * np.eye(3) - I)
    if not moments[0] > 0.0:
        return None
    kept = np.maximum(moments, _LEAST * moments[0])
    S = product(axes.T * kept, axes)
    found: Floats = kept.sum() * np.eye(3) - (S + S.T) / 2.0
    return found
