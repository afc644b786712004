import pytest
from helpers.symmetry_cases import bodies


@pytest.mark.slow
def test_fewer_than_one_verdict_in_a_hundred_is_false():
    wrong, told = (sum(part) for part in zip(*(body.false_verdicts() for body in bodies(100)), strict=True))
    assert told == 300
    assert wrong < 0.01 * told


def test_the_bodies_are_of_all_kinds():
    given = list(bodies(100))
    assert sum(len(body.holding) for body in given) > 80
    assert sum(len(body.broken) for body in given) > 80
    assert len({body.name for body in given}) > 20
