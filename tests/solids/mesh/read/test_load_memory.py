"""Five million triangles of a binary STL go through a new process in less than 100 MB; to measure one takes 100 B."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest
from helpers.mesh_samples import binary_stl, torus

COUNT = 5_000_000
READ = """
from robodyn.solids.mesh.read.load import load_triangles
read = load_triangles(sys.argv[1], file_type="stl")
print(sum(len(block) for _ in range(2) for block in read.blocks()))
"""
MEASURE = """
from robodyn.solids.mass_properties import mass_properties
print(mass_properties(sys.argv[1]).triangles)
"""
PEAK = 'print(next(line.split()[1] for line in open("/proc/self/status") if line.startswith("VmHWM")))'


@pytest.mark.slow
@pytest.mark.skipif(not os.path.exists("/proc/self/status"), reason="the system does not tell the peak of a process")
@pytest.mark.parametrize(("code", "passes", "each"), [(READ, 2, 0), (MEASURE, 1, 100)], ids=["read", "measured"])
def test_peak_resident_memory(tmp_path, code, passes, each):
    path = tmp_path / "large.stl"
    path.write_bytes(binary_stl(torus(rings=2500, sectors=1000)))
    call = [sys.executable, "-c", f"import sys\n{code}{PEAK}", str(path)]
    done = subprocess.run(call, capture_output=True, text=True, check=True)
    count, peak = map(int, done.stdout.split())
    assert count == passes * COUNT
    assert peak < 100 * 1024 + each * COUNT // 1024
