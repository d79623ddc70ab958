"""The page on security: every promise names tests, and these are there."""

import re

from paths import ROOT

PAGE = (ROOT / "docs/security.md").read_text()


def test_every_promise_names_tests_that_exist():
    rows = [line for line in PAGE.splitlines() if line.startswith("| ") and not line.startswith("| promise")]
    assert len(rows) > 15
    for row in rows:
        named = re.findall(r"`(tests/[\w/]+\.py)::(\w+)`", row)
        assert named, row
        for file, test in named:
            assert re.search(rf"^ *def {test}\(", (ROOT / file).read_text(), re.MULTILINE), (file, test)


def test_reports_go_by_the_repository_host():
    assert "SECURITY.md" in (ROOT / "README.md").read_text()
    assert "@" not in (ROOT / "SECURITY.md").read_text()
