"""Words of a text as numbers, against Python's own float and int."""

from __future__ import annotations

import math
import struct

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from robodyn.errors import MeshError
from robodyn.solids.mesh.read.lines import chunks, tokens
from robodyn.solids.mesh.read.source import open_source

BLANKS = st.text(" \t\r\n\v\f", min_size=1, max_size=3)
FORMATS = st.sampled_from(["{!r}", "{:.6f}", "{:e}", "{:g}", "{:+.17g}", "{:.3E}", "{:.20f}"])
ANY_FLOAT = st.integers(0, 2**64 - 1).map(lambda bits: struct.unpack("<d", struct.pack("<Q", bits))[0])
MODERATE = st.floats(-1e6, 1e6)


def words_of(text):
    return tokens(open_source(text or b" "), 0, text)


def all_of(words):
    return np.arange(len(words.starts))


@given(st.lists(st.tuples(st.text("ab./-1é", min_size=1, max_size=9), BLANKS), max_size=20), BLANKS)
def test_words_and_lines_are_those_of_split(pairs, before):
    text = (before + "".join(word + blank for word, blank in pairs)).encode()
    words = words_of(text)
    assert [words.word(i) for i in all_of(words)] == text.split()
    lines = [line.split() for line in text.replace(b"\r", b"\n").split(b"\n") if line.split()]
    assert np.diff(words.first).tolist() == [len(line) for line in lines]


@given(st.lists(st.tuples(ANY_FLOAT | MODERATE, FORMATS), min_size=1, max_size=30))
def test_numbers_are_correctly_rounded(pairs):
    written = [form.format(value) for value, form in pairs]
    written = [text for text in written if len(text) <= 64] or ["0"]
    words = words_of(" ".join(written).encode())
    np.testing.assert_array_equal(words.floats(all_of(words)), [float(text) for text in written])


@given(st.lists(st.integers(-(10**17), 10**17) | st.integers(-200, 200), min_size=1, max_size=30), st.booleans())
def test_integers_are_exact(values, slash):
    tail = "/7/-8" if slash else ""
    words = words_of(" ".join(f"{value}{tail}" for value in values).encode())
    assert words.integers(all_of(words), slash=slash).tolist() == values


@given(st.text("0123456789+-./e_x,\0é", min_size=1, max_size=20))
@example("1/2")
def test_only_plain_numbers_are_read(word):
    """Python reads `1_0` and spaces too; a text of a mesh must not."""
    words = words_of(word.encode())
    plain = "_" not in word and "\0" not in word
    for read, convert in ((words.floats, float), (words.integers, int)):
        try:
            expected = convert(word) if plain else math.nan
        except ValueError:
            expected = None
        try:
            found = read(all_of(words)).tolist()
        except MeshError:
            assert expected is None or not plain or len(word) > 18
        else:
            assert not plain or found == [expected]


@pytest.mark.parametrize("word", [b"facet", b"endfacet", b"v"])
def test_words_are_compared_whole(word):
    words = words_of(b" ".join([word] * 3))
    assert words.equal(all_of(words), word)
    for other in (word + b"s", word[:-1] + b"~", word.upper()):
        words = words_of(b" ".join([word, other, word]))
        assert not words.equal(all_of(words), word)


@given(st.lists(st.integers(0, 3 << 18), max_size=12))
def test_chunks_end_with_lines_and_make_up_the_file(lengths):
    text = b"".join(b"x" * length + b"\n" for length in lengths) + b"end"
    found: list[bytes] = []
    offsets = [words.offset for words in chunks(open_source(text), plain=lambda chunk: found.append(chunk) or chunk)]
    assert b"".join(found) == text
    assert offsets == [0, *np.cumsum([len(chunk) for chunk in found])[:-1]]
    assert all(chunk.endswith(b"\n") for chunk in found[:-1])


def test_the_line_of_an_error_counts_those_of_earlier_chunks():
    text = b"a line\n" * 300_000 + b"bad\n"
    found = list(chunks(open_source(text)))
    assert len(found) > 2
    with pytest.raises(MeshError, match=r"^<bytes>:300001: 'bad' is not a number"):
        found[-1].floats(np.array([len(found[-1].starts) - 1]))
