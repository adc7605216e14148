"""`tamp robots`, `domains`, `samplers`: what is installed."""

from __future__ import annotations

import argparse
from importlib.resources import files
from pathlib import Path

from tamp.cli import SOLVED
from tamp.domains.tabletop import DEFAULT_SAMPLERS
from tamp.language import parse_domain, parse_streams
from tamp.task import load_robot, robot_names


def robots(options: argparse.Namespace) -> int:
    """One line a robot."""
    for name in robot_names():
        spec = load_robot(name)
        stroke = 1000 * spec.gripper.stroke
        print(f"{name:12s} {len(spec.joints)} joints, gripper opens {stroke:.0f} mm, {spec.urdf.name}")
    return SOLVED


def domains(options: argparse.Namespace) -> int:
    """Each domain's actions and streams."""
    for folder in _domain_folders():
        domain = parse_domain(folder / "domain.pddl")
        streams = parse_streams(folder / "stream.pddl", domain)
        print(folder.name)
        print(f"  actions: {', '.join(domain.actions)}")
        print(f"  streams: {', '.join(s.name for s in streams.streams)}")
    return SOLVED


def samplers(options: argparse.Namespace) -> int:
    """Each stream of the tabletop domain with its inputs, outputs and the function that serves it."""
    folder = _domain_folders()[-1]
    streams = parse_streams(folder / "stream.pddl", parse_domain(folder / "domain.pddl"))
    for stream in streams.streams:
        outputs = f" -> {', '.join(map(str, stream.outputs))}" if stream.outputs else ""
        print(f"{stream.name}({', '.join(map(str, stream.inputs))}){outputs}: {DEFAULT_SAMPLERS[stream.name]}")
    return SOLVED


def _domain_folders() -> list[Path]:
    root = Path(str(files("tamp"))) / "domains"
    return sorted(path.parent for path in root.glob("*/domain.pddl"))
