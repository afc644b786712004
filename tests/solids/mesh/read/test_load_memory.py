"""Five million triangles of a binary STL go through a new process in less than 100 MB; to measure one takes 100 B."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest
from helpers.mesh_samples import binary_stl, torus

COUNT = 5_000_000
READ = """
import sys
from robodyn.solids.mesh.read.load import load_triangles
read = load_triangles(sys.argv[1], file_type="stl")
print(sum(len(block) for _ in range(2) for block in read.blocks()))
print(next(line.split()[1] for line in open("/proc/self/status") if line.startswith("VmHWM")))
"""

MEASURE = """
import sys
from robodyn.solids.mass_properties import mass_properties
print(mass_properties(sys.argv[1]).triangles)
print(next(line.split()[1] for line in open("/proc/self/status") if line.startswith("VmHWM")))
"""


@pytest.mark.slow
@pytest.mark.skipif(not os.path.exists("/proc/self/status"), reason="the system does not tell the peak of a process")
@pytest.mark.parametrize("from_stdin", [False, True])
def test_peak_resident_memory(tmp_path, from_stdin):
    path = tmp_path / "large.stl"
    part = binary_stl(torus(rings=500, sectors=50))[84:]
    with path.open("wb") as stream:
        stream.write(bytes(80) + COUNT.to_bytes(4, "little"))
        for _ in range(COUNT // 50_000):
            stream.write(part)
    with path.open("rb") as stream:
        call = [sys.executable, "-c", READ, "-" if from_stdin else str(path)]
        done = subprocess.run(call, stdin=stream, capture_output=True, text=True, check=True)
    count, peak = map(int, done.stdout.split())
    assert count == 2 * COUNT
    assert peak < 100 * 1024


@pytest.mark.slow
@pytest.mark.skipif(not os.path.exists("/proc/self/status"), reason="the system does not tell the peak of a process")
def test_peak_resident_memory_of_a_measured_shell(tmp_path):
    path = tmp_path / "torus.stl"
    path.write_bytes(binary_stl(torus(rings=2500, sectors=1000)))
    done = subprocess.run([sys.executable, "-c", MEASURE, str(path)], capture_output=True, text=True, check=True)
    count, peak = map(int, done.stdout.split())
    assert count == COUNT
    assert peak < 100 * 1024 + 100 * COUNT // 1024
