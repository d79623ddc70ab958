import pytest

from bubblemesh.errors import CaseError
from bubblemesh.workers.choice import PACKING, crew_for
from bubblemesh.workers.crew import MANY


@pytest.mark.parametrize(
    ("parts", "at_once", "loaded", "most"),
    [
        *(("auto", True, PACKING, MANY), (3, True, PACKING, 3), (1, True, None, 1)),
        *(("auto", False, None, MANY), (3, False, None, 3)),
    ],
)
def test_workers_start_before_all_else_unless_one_part_is_asked_for(monkeypatch, parts, at_once, loaded, most):
    seen = []
    monkeypatch.setattr("bubblemesh.workers.crew.crew_of", lambda hire, warn, *more: seen.append(more))
    crew_for(parts, 2, None, print, at_once=at_once, memory_mb=400)
    assert seen == [(loaded, most, 400)]


def test_a_mesh_in_one_piece_has_no_workers():
    with crew_for(None, None, None, print, at_once=True, memory_mb=None) as crew:
        assert crew.__module__ == "bubblemesh.parts.work"
    with pytest.raises(CaseError, match="add --parts auto"):
        crew_for(None, 2, None, print, at_once=True, memory_mb=None)
