"""Ranges in degrees are turned into radians at both ends or not at all; joints that turn freely are continuous."""

from __future__ import annotations

from math import radians

import pytest
from helpers.planted_defects import HEALTHY

from robodyn.checks.check import Options, check_one
from robodyn.checks.fixes import fixed
from robodyn.checks.rule import Finding, Severity

LIMITS = 'lower="-2.9" upper="2.8"'
SOFT = 'soft_lower_limit="-2.85" soft_upper_limit="2.75"'


def one(text: str, code: str) -> Finding:
    (finding,) = check_one(text.encode(), Options(select=(code,)))
    return finding


def mended(text: str) -> str:
    given = Options(select=("RD507",))
    return fixed(text.encode(), "arm.urdf", lambda data: check_one(data, given), unsafe=True).after.decode()


@pytest.mark.parametrize(
    ("limits", "soft"),
    [
        (("-170", "165"), None),
        (("-170", "10"), None),
        (("0", "90"), None),
        (("-5", "90"), ("0", "85")),
        (("-720", "720"), None),
    ],
)
def test_both_ends_are_turned(limits: tuple[str, str], soft: tuple[str, str] | None) -> None:
    text, after = HEALTHY, HEALTHY
    for old, names, new in (
        (LIMITS, ("lower", "upper"), limits),
        (SOFT, ("soft_lower_limit", "soft_upper_limit"), soft),
    ):
        values = (0.0, 0.0) if new is None else tuple(map(float, new))
        written = " ".join(f'{name}="{value}"' for name, value in zip(names, new or ("0", "0"), strict=True))
        turned = " ".join(f'{name}="{radians(value)!r}"' for name, value in zip(names, values, strict=True))
        text, after = text.replace(old, written), after.replace(old, turned)
    assert one(text, "RD507").cause == "written in degrees"
    assert mended(text) == after


@pytest.mark.parametrize(
    "text",
    [
        HEALTHY.replace(LIMITS, 'lower="-2.9" upper="90"'),
        HEALTHY.replace(LIMITS, 'lower="-90" upper="91"').replace(SOFT, ""),
        HEALTHY.replace(LIMITS, 'lower="-90" upper="90"'),
        HEALTHY.replace(LIMITS, 'lower="-90" upper="a"').replace(SOFT, ""),
        HEALTHY.replace(LIMITS, 'lower="-1000" upper="1000"').replace(SOFT, ""),
    ],
    ids=["one end", "not round", "soft limits in radians", "unreadable", "beyond two turns"],
)
def test_or_neither(text: str) -> None:
    finding = one(text, "RD507")
    assert (finding.cause, finding.fix, finding.severity) == (None, None, Severity.WARNING)
    assert mended(text) == text


def test_a_range_without_end_is_no_angle_in_degrees() -> None:
    finding = one(HEALTHY.replace(LIMITS, 'lower="-1000" upper="1000"'), "RD507")
    assert finding.remedy.startswith("make a joint that turns freely continuous")


@pytest.mark.parametrize(
    ("limits", "free"),
    [
        ("", True),
        ('lower="0" upper="0"', True),
        ('lower="0.3" upper="0.3"', False),
        ('lower="-1e16" upper="1e16"', True),
    ],
)
def test_a_joint_that_turns_freely_is_continuous(limits: str, free: bool) -> None:
    text = HEALTHY.replace(LIMITS, limits)
    assert ("continuous" in one(text, "RD504").remedy) is free
    slide = text.replace('name="shoulder" type="revolute"', 'name="shoulder" type="prismatic"')
    assert "continuous" not in one(slide, "RD504").remedy
