"""What is not convex must at least be a solid."""

from __future__ import annotations

from pathlib import Path

import pytest

from tamp.errors import TaskError
from tamp.task import Mesh
from tamp.task.mesh.parts import parts

DENTED = """v 0 0 0
v 0.1 0 0
v 0.1 0.1 0
v 0 0.1 0
v 0 0 0.1
v 0.1 0 0.1
v 0.03 0.03 0.03
v 0 0.1 0.1
f 4 3 2 1
f 5 6 7
f 5 7 8
f 1 2 6 5
f 2 3 7
f 2 7 6
f 3 4 8
f 3 8 7
"""
"""A cube with one corner pushed in; the side x = 0 is missing."""


def test_a_dented_surface_with_a_hole_has_no_inside(tmp_path: Path) -> None:
    path = tmp_path / "dented.obj"
    path.write_text(DENTED)
    with pytest.raises(TaskError, match="neither convex nor closed"):
        parts(Mesh(path))


def test_a_surface_that_cuts_through_itself_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "turned.obj"
    path.write_text(DENTED.replace("v 0.03 0.03 0.03", "v -0.05 0.02 0.05") + "f 4 1 5 8\n")
    with pytest.raises(TaskError, match="intersects itself"):
        parts(Mesh(path))
