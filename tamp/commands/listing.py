"""`tamp robots`, `domains`, `samplers`: what is installed."""

from __future__ import annotations

import argparse

from tamp.cli import SOLVED
from tamp.commands.output import to_stdout, write_json
from tamp.domains.catalog import contract, domain_names, load_domain, type_name
from tamp.domains.samplers import resolve_samplers
from tamp.task import load_robot, robot_names
from tamp.task.load import load_task


def robots(options: argparse.Namespace) -> int:
    """One line a robot."""
    specs = [load_robot(name) for name in robot_names()]
    if not to_stdout(options.json):
        for spec in specs:
            stroke = 1000 * spec.gripper.stroke
            print(f"{spec.name:12s} {len(spec.joints)} joints, gripper opens {stroke:.0f} mm, {spec.urdf.name}")
    write_json(
        options.json,
        [
            {
                "name": s.name, "joints": list(s.joints), "lower_rad": list(s.lower), "upper_rad": list(s.upper),
                "velocity_rad_s": list(s.velocity), "stroke_m": s.gripper.stroke, "urdf": str(s.urdf),
            }
            for s in specs
        ],
    )  # fmt: skip
    return SOLVED


def domains(options: argparse.Namespace) -> int:
    """Each domain's actions and streams."""
    entries = [load_domain(name) for name in domain_names()]
    listed = [
        {"name": e.name, "actions": list(e.domain.actions), "streams": [s.name for s in e.streams.streams]}
        for e in entries
    ]
    if not to_stdout(options.json):
        for entry in listed:
            print(entry["name"])
            for part in ("actions", "streams"):
                print(f"  {part}: {', '.join(entry[part])}")
    write_json(options.json, listed)
    return SOLVED


def samplers(options: argparse.Namespace) -> int:
    """Each stream of a domain with the types of its inputs and outputs, and the function that serves it."""
    entry = load_domain(options.domain)
    asked = load_task(options.task).samplers if options.task is not None else {}
    replaced = dict(options.sampler)
    resolve_samplers(entry.samplers, asked, replaced)
    listed = []
    for stream in entry.streams.streams:
        types = contract(entry, stream)
        said_by = [(replaced, "--sampler"), (asked, "the task"), (entry.samplers, "the domain")]
        layer, by = next((layer, by) for layer, by in said_by if stream.name in layer)
        listed.append(
            {
                "stream": stream.name,
                "inputs": {name: type_name(kind) for name, kind in types.inputs.items()},
                "outputs": {name: type_name(kind) for name, kind in types.outputs.items()},
                "fluents": list(stream.fluents),
                "sampler": layer[stream.name],
                "given_by": by,
            }
        )
        if not to_stdout(options.json):
            told = f", told where things are by ({', '.join(stream.fluents)})" if stream.fluents else ""
            print(f"{stream.name}{types}{told}\n    {layer[stream.name]}  (by {by})")
    write_json(options.json, listed)
    return SOLVED
