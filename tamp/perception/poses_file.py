"""Estimates as a file: what `tamp score` reads as poses, with confidence and alternatives beside them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

from tamp.perception.estimate import Estimate
from tamp.task.pose import Pose


def save_estimates(
    estimates: Mapping[str, Estimate],
    path: Path,
    truth: Mapping[str, Pose] = MappingProxyType({}),
    errors: Mapping[str, float] = MappingProxyType({}),
) -> None:
    """Write object -> {"xyz", "quat"} [m; x y z w], null for what was not seen, and more of it into NAME.details.json.

    The first file has the form of all files of final poses; the second adds confidence and alternatives to each, and
    the true pose and how far the estimate is from it [m] where they are given.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    poses = {name: _pose(estimate.pose) for name, estimate in estimates.items()}
    path.write_text(json.dumps(poses, indent=1) + "\n", encoding="utf-8")
    details = {
        name: {
            "pose": _pose(estimate.pose),
            "confidence": round(estimate.confidence, 4),
            "alternatives": [_pose(pose) for pose in estimate.alternatives],
            **({"truth": _pose(truth[name])} if name in truth else {}),
            **({"error_m": round(errors[name], 6)} if name in errors else {}),
        }
        for name, estimate in estimates.items()
    }
    details_path(path).write_text(json.dumps(details, indent=1) + "\n", encoding="utf-8")


def details_path(path: Path) -> Path:
    """Where confidences and alternatives of a file of poses are."""
    return path.with_name(f"{path.stem}.details.json")


def _pose(pose: Pose | None) -> dict[str, Any] | None:
    return None if pose is None else {"xyz": list(pose.xyz), "quat": list(pose.quat)}
