"""How fast the executors are here: measured once, kept, and never believed where it cannot be."""

from __future__ import annotations

import json
import platform
from dataclasses import asdict, replace

import pytest
from compiled_programs import needs_compiler

from robodyn.execute import rates
from robodyn.execute.choice import TYPICAL
from robodyn.execute.llvm import machine
from robodyn.execute.llvm.build import kept_objects

SOME = replace(TYPICAL, call=3e-7, start=0.05)


@pytest.fixture(autouse=True)
def folder(monkeypatch, tmp_path):
    monkeypatch.setenv("ROBODYN_CACHE", str(tmp_path))
    return tmp_path / "objects"


def _keep(content):
    kept_objects().put(rates._key(), content)


@needs_compiler
def test_measured_rates_are_kept():
    assert rates.stored_rates() is None
    measured = rates.measured_rates()
    assert measured.sane
    assert rates.stored_rates() == measured


@needs_compiler
def test_without_a_cache_they_are_measured_all_the_same(monkeypatch, folder):
    monkeypatch.setenv("ROBODYN_CACHE", "0")
    assert rates.measured_rates().sane
    assert rates.stored_rates() is None
    assert not folder.exists()


@needs_compiler
def test_the_compiler_is_measured_and_not_the_cache(monkeypatch):
    """Nothing that is timed as building is loaded."""
    rates.measured_rates()
    compiled = []
    monkeypatch.setattr(rates, "machine_code", lambda ir: compiled.append(ir) or machine.machine_code(ir))
    rates.measured_rates()
    assert len(compiled) == 3


def test_rates_are_read_back_to_the_last_bit():
    _keep(json.dumps(asdict(SOME)).encode())
    assert rates.stored_rates() == SOME


def _one(name, value):
    return json.dumps({**asdict(SOME), name: value}).encode()


UNUSABLE = {
    "nothing": b"",
    "no text": b"\xff\xfe\x00",
    "no JSON": b"{",
    "a number": b"1",
    "a list": json.dumps(list(asdict(SOME).values())).encode(),
    "one missing": json.dumps({name: rate for name, rate in asdict(SOME).items() if name != "load"}).encode(),
    "a word": _one("call", "fast"),
    "none": _one("call", None),
    "a list within": _one("call", [3e-7]),
    "NaN": _one("call", float("nan")),
    "infinite": _one("build", float("inf")),
    "zero": _one("numpy", 0),
    "negative": _one("load", -1e-3),
    "an hour": _one("start", 3600),
    "too large for a double": _one("start", 10**400),
    "machine code slower than NumPy": _one("compiled", 2 * SOME.numpy),
}


@pytest.mark.parametrize("content", UNUSABLE)
def test_rates_that_cannot_be_are_ignored(content):
    _keep(UNUSABLE[content])
    assert rates.stored_rates() is None


DAMAGE = {
    "bit": lambda data: data[:-9] + bytes([data[-9] ^ 1]) + data[-8:],
    "half": lambda data: data[: len(data) // 2],
    "empty": lambda data: b"",
}


@needs_compiler
@pytest.mark.parametrize("damage", DAMAGE)
def test_damaged_rates_are_ignored_and_measured_again(folder, damage):
    _keep(json.dumps(asdict(SOME)).encode())
    (path,) = folder.iterdir()
    path.write_bytes(DAMAGE[damage](path.read_bytes()))
    assert rates.stored_rates() is None
    measured = rates.measured_rates()
    assert rates.stored_rates() == measured


@pytest.mark.parametrize("name", ["node", "machine"])
def test_rates_of_another_machine_are_ignored(monkeypatch, name):
    _keep(json.dumps(asdict(SOME)).encode())
    monkeypatch.setattr(platform, name, lambda: "another")
    assert rates.stored_rates() is None


def test_rates_of_another_version_are_ignored(monkeypatch):
    _keep(json.dumps(asdict(SOME)).encode())
    monkeypatch.setattr(rates, "generator", lambda: "another")
    assert rates.stored_rates() is None


@needs_compiler
@pytest.mark.parametrize("tick", [0.0, 100.0])
def test_rates_measured_by_a_clock_that_is_wrong_are_not_kept(monkeypatch, folder, tick):
    clock = iter(range(10**6))
    monkeypatch.setattr(rates, "perf_counter", lambda: next(clock) * tick)
    assert rates.measured_rates() is TYPICAL
    assert rates.stored_rates() is None
    assert kept_objects().get(rates._key()) is None
