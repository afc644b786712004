"""What kind of machine and which versions a measurement belongs to; no names."""

from __future__ import annotations

import importlib.metadata
import os
import platform

import numpy as np

WIDEST = {"AVX512": "AVX-512", "AVX2": "AVX2", "X86_V3": "AVX2", "ASIMD": "NEON", "NEON": "NEON", "SSE": "SSE"}


def vectors() -> str:
    """The class of vector instructions that NumPy finds."""
    found = " ".join(np.show_config(mode="dicts")["SIMD Extensions"].get("found", []))
    return next((name for flag, name in WIDEST.items() if flag in found), "baseline")


def machine(*packages: str) -> str:
    """One sentence: cores, processor and vector class, system, versions of Python, NumPy and `packages`."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    versions = [f"{name} {importlib.metadata.version(package)}" for name, package in _named(packages)]
    return (
        f"Measured on {cores} cores of {platform.machine()} with {vectors()}, {platform.system()}; "
        f"{', '.join([f'Python {platform.python_version()}', f'NumPy {np.__version__}', *versions])}.\n"
    )


def _named(packages: tuple[str, ...]) -> list[tuple[str, str]]:
    titles = {"pin": "Pinocchio", "polars": "polars", "mujoco": "MuJoCo"}
    return [(titles.get(package, package), package) for package in packages]
