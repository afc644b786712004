"""Both kernels of integrals over a volume."""

from __future__ import annotations

import pytest

from robodyn.solids.mesh import integrals, kernel
from robodyn.solids.mesh.kernel import volume_kernel


@pytest.fixture(params=["numpy", "machine code"])
def either_kernel(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Meshes of any size are integrated by NumPy, and once more by machine code."""
    if request.param == "numpy":
        monkeypatch.setattr(integrals, "kernel_for", lambda count: volume_kernel)
    else:
        pytest.importorskip("llvmlite")
        monkeypatch.setattr(kernel, "LEAST", 0)
        monkeypatch.setattr(kernel, "_worth_its_start", lambda count: True)
