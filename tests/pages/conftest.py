"""Pages of runs for the tests."""

import pytest
from browser import Browser, started
from report_pages import CASE, page_of

from bubblemesh.case import load_case
from bubblemesh.run.pipeline import mesh_case


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    path = tmp_path_factory.mktemp("case") / "composite.yaml"
    path.write_text(CASE)
    return mesh_case(load_case(path))


@pytest.fixture(scope="module")
def page(result):
    return page_of(result)


@pytest.fixture(scope="module")
def browser():
    driver = started()
    yield Browser(driver)
    driver.quit()
