"""The comparison with other libraries that anyone repeats: its data are whole, and what it times computes the same."""

import json
import subprocess
import sys

import pytest
from benchmarks.compare import ALGORITHMS, QUICK, TESTS
from benchmarks.compare_tables import WAYS
from benchmarks.published import PUBLISHED
from helpers.example_robots import PATHS
from helpers.peers import peer


def test_published_times_name_hardware_and_source() -> None:
    for each in PUBLISHED:
        assert any(maker in each.hardware for maker in ("Intel", "NVIDIA"))
        assert each.source
        assert "/" in each.address
        assert all(set(times) <= set(ALGORITHMS) and min(times.values()) > 0.0 for times in each.times.values())


@pytest.mark.slow
def test_a_quick_comparison_with_pinocchio(tmp_path) -> None:
    peer("pinocchio")
    if not PATHS:
        pytest.skip("example-robot-data is not installed")
    page = tmp_path / "page.html"
    command = [sys.executable, "-m", "benchmarks.compare", "--quick", "--libraries", "robodyn", "Pinocchio"]
    done = subprocess.run(
        [*command, "--out", str(page)], cwd=TESTS, capture_output=True, text=True, encoding="utf-8", check=True
    )
    assert done.stderr == ""
    assert "Measured on" in done.stdout
    data = json.loads(page.with_suffix(".json").read_text(encoding="utf-8"))
    assert data["skipped"] == []
    assert data["threads"] == 1
    assert set(data["empty_call"]) == set(data["versions"])
    libraries = {title.partition(" ")[0] for title in data["versions"]}
    assert libraries == {"robodyn", "Pinocchio"}
    found = {(x["robot"], x["algorithm"], x["library"].partition(" ")[0], x["way"]): x for x in data["results"]}
    ours = {(robot, algorithm, "robodyn", way) for robot in QUICK for algorithm in ALGORITHMS for way in WAYS}
    theirs = {(robot, algorithm, "Pinocchio", "one") for robot in QUICK for algorithm in ALGORITHMS}
    assert ours | theirs <= set(found)
    for each in data["results"]:
        assert 0.0 < each["seconds"]["low"] <= each["seconds"]["median"] <= each["seconds"]["high"]
        assert each["samples"] > 0
        assert each["error"] < 1e-12, each
    assert all(found[case]["operations"] > 0 for case in ours if case[-1] == "block")
    text = page.read_text(encoding="utf-8")
    assert all(each.hardware in text for each in PUBLISHED)
    assert "https://" not in text.partition("<main")[2].partition("</main>")[0]
