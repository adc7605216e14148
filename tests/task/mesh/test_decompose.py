"""Decomposition runs aside: what goes wrong there comes back as words."""

from __future__ import annotations

import numpy as np
import pytest

from tamp.task.mesh import decompose as module
from tamp.task.mesh.decompose import decompose

CORNERS = np.array([[x, y, z] for z in (0.0, 0.1) for x, y in ((0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2))]) * 0.1
ENDS = [[0, 3, 2], [0, 2, 1], [0, 5, 4], [0, 4, 3]]
FACES = np.array(
    ENDS
    + [[a + 6, c + 6, b + 6] for a, b, c in ENDS]
    + [face for i, j in zip(range(6), (1, 2, 3, 4, 5, 0), strict=True) for face in ([i, j, j + 6], [i, j + 6, i + 6])]
)


def test_an_angle_comes_apart_in_convex_parts() -> None:
    found = decompose(CORNERS, FACES)
    assert len(found) >= 2
    together = np.concatenate(found)
    np.testing.assert_allclose(together.min(axis=0), CORNERS.min(axis=0), atol=0.01)
    np.testing.assert_allclose(together.max(axis=0), CORNERS.max(axis=0), atol=0.01)


def answer(program: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let another program stand where the library is called."""
    run = module.subprocess.run
    monkeypatch.setattr(
        module.subprocess, "run", lambda _, **options: run([module.sys.executable, "-c", program], **options)
    )


def test_a_crash_of_the_library_comes_back_as_a_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    answer("import os; os.abort()", monkeypatch)
    with pytest.raises(ValueError, match=r"cannot be decomposed into convex parts$"):
        decompose(CORNERS, FACES)


def test_a_decomposition_ends_at_its_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    answer("import resource; resource.setrlimit(resource.RLIMIT_CPU, (1, 2))\nwhile True: pass", monkeypatch)
    with pytest.raises(ValueError, match="in 60 s"):
        decompose(CORNERS, FACES)
