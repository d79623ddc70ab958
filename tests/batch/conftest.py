"""Cases of batches for the tests."""

import pytest


@pytest.fixture
def here(tmp_path, monkeypatch):
    """An empty folder that is the present one."""
    monkeypatch.chdir(tmp_path)
    return tmp_path
