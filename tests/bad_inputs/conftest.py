"""Cases for the tests of bad input."""

import pytest


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    """An empty folder that is the present one."""
    monkeypatch.chdir(tmp_path)
    return tmp_path
