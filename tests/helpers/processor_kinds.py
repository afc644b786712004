"""Other kinds of processor than this one, as far as this one can do as if it were them."""

from __future__ import annotations

LINEAR_ALGEBRA = {"avx2": "Haswell", "prescott": "Prescott"}
"""The processor that OpenBLAS is to take this one for: with AVX2, and one of 2004 without fused multiply-add."""


def variables(name: str) -> dict[str, str]:
    """Return what makes NumPy, OpenBLAS and machine code do without AVX-512; nothing where it is not x86-64's."""
    import numpy as np

    inside = np._core if hasattr(np, "_core") else np.core
    core = inside._multiarray_umath

    present = {feature for feature, there in core.__cpu_features__.items() if there}
    if not {"AVX2", "FMA3"} <= present:
        return {}
    wide = [feature for feature in core.__cpu_dispatch__ if feature.startswith(("AVX512", "X86_V4"))]
    return {
        "OPENBLAS_CORETYPE": LINEAR_ALGEBRA[name],
        "NPY_DISABLE_CPU_FEATURES": ",".join(feature for feature in wide if feature in present),
        "ROBODYN_CPU": "x86-64-v3",
    }
