"""What is done about messages of other libraries is done in one thread, and undone."""

from __future__ import annotations

import logging
import warnings
from threading import Event, Thread

import numpy as np
import pytest
from helpers.mesh_files import dae

from robodyn.solids.mesh.read.load import load_triangles
from robodyn.support.libraries import library_messages, treated_warnings

NAME = "robodyn.tests.library"


@pytest.fixture(autouse=True)
def _as_it_was():
    loggers = [logging.getLogger(name) for name in (NAME, "trimesh", "yourdfpy")]
    before = [(logger.disabled, logger.level, list(logger.filters), list(logger.handlers)) for logger in loggers]
    yield
    assert [(logger.disabled, logger.level, logger.filters, logger.handlers) for logger in loggers] == before


def test_messages_of_this_thread_are_heard_and_those_of_others_go_on(caplog):
    logger = logging.getLogger(NAME)
    with caplog.at_level(logging.INFO):
        with library_messages(NAME) as messages:
            logger.warning("of %s", "ours")
            logger.info("little")
            other = Thread(target=lambda: logger.warning("of another"))
            other.start()
            other.join()
        logger.error("later")
    assert messages == ["of ours"]
    assert [record.message for record in caplog.records] == ["little", "of another", "later"]


def test_filters_of_warnings_are_restored_whoever_ends_first():
    """If both were at it, the one who began first would put back what he found, the other then the first one's."""
    before = list(warnings.filters)
    begun, both, ended = Event(), Event(), Event()

    def first():
        with treated_warnings("error", "one"):
            begun.set()
            both.wait(0.1)
        ended.set()

    thread = Thread(target=first)
    thread.start()
    begun.wait()
    with treated_warnings("ignore", "two"):
        both.set()
        ended.wait()
    thread.join()
    assert warnings.filters == before


def test_a_scene_is_read_while_others_log(tmp_path, monkeypatch, caplog):
    from trimesh.exchange.load import mesh_loaders

    def load(*given, **more):
        other = Thread(target=lambda: logging.getLogger("trimesh").warning("of another"))
        other.start()
        other.join()
        logging.getLogger("trimesh.util").warning("ours")
        return before(*given, **more)

    before = mesh_loaders["dae"]
    monkeypatch.setitem(mesh_loaders, "dae", load)
    found = load_triangles(dae(np.eye(3)[None]), file_type="dae")
    assert "trimesh: ours" in found.notes
    assert [record.message for record in caplog.records] == ["of another"]
