"""The program that makes the table of docs/solvers.md."""

import pytest
from paths import ROOT

from benchmarks.solvers import __main__ as table


def test_a_page_is_written_on_request_only(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(table, "SOLVERS", {})
    page, own = tmp_path / "page.md", (ROOT / "docs/solvers.md").read_bytes()
    page.write_text(f"Before.\n\n{table.BEGIN}\n\nold\n\n{table.END}\n\nAfter.\n")
    table.main(["-o", str(page)])
    shown = capsys.readouterr().out
    assert page.read_text() == f"Before.\n\n{table.BEGIN}\n\n{shown.strip()}\n\n{table.END}\n\nAfter.\n"
    table.main([])
    assert capsys.readouterr().out == shown
    with pytest.raises(SystemExit, match=r"^0$"):
        table.main(["--help"])
    assert "The exact mean" not in capsys.readouterr().out
    assert (ROOT / "docs/solvers.md").read_bytes() == own
