"""Imports that are put off."""

from __future__ import annotations

import subprocess
import sys

import pytest

from tamp.world.timing.deferred_import import deferred

TIMED = "import numpy; from tamp.world.timing.path_rates import algorithm"


def printed(code: str) -> str:
    """What a fresh interpreter prints."""
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.strip()


def test_timing_a_path_loads_no_plots() -> None:
    assert printed(f"{TIMED}; import sys; print('matplotlib' in sys.modules)") == "False"


SPLINE = """
import numpy as np, sys
from toppra import SimplePath, SplineInterpolator
print("scipy.interpolate" in sys.modules)
rows = np.array([[0.0], [2.0], [0.0]])
print(SplineInterpolator([0, 1, 2], rows)(1.0)[0], SimplePath([0, 1, 2], rows)(1.0)[0])
"""


def test_nor_does_it_load_splines_which_toppra_fits_all_the_same() -> None:
    loaded, values = printed(f"{TIMED}\n{SPLINE}").splitlines()
    assert loaded == "False"
    assert list(map(float, values.split())) == pytest.approx([2.0, 2.0])


def test_toppra_draws_once_it_is_asked_to() -> None:
    drawn = printed(f"{TIMED}; from toppra.algorithm.algorithm import plt; print(plt.figure.__module__)")
    assert drawn == "matplotlib.pyplot"


def test_others_import_the_true_module() -> None:
    assert printed(f"{TIMED}; import matplotlib.pyplot as p; print(p.__file__.endswith('pyplot.py'))") == "True"


def test_what_is_loaded_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    import json.encoder

    with deferred("json", "json.encoder"):
        assert sys.modules["json.encoder"] is json.encoder
    monkeypatch.delitem(sys.modules, "colorsys", raising=False)
    with deferred("colorsys"):
        import colorsys as within
    assert "colorsys" not in sys.modules
    assert within.rgb_to_hsv(0.0, 0.0, 0.0) == (0.0, 0.0, 0.0)
    assert sys.modules["colorsys"] is not within


def test_an_error_within_leaves_no_stand_in(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, "colorsys", raising=False)
    with pytest.raises(ZeroDivisionError), deferred("colorsys"):
        raise ZeroDivisionError
    assert "colorsys" not in sys.modules
