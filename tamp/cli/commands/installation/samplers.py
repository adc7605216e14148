"""`tamp samplers`: which functions serve a domain's streams, and whether one fits its stream."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from tamp import plugins
from tamp.cli.options import add_json, add_trust, command, load, natural, replacement
from tamp.cli.output import to_stdout, write_json
from tamp.cli.status import SOLVED, UNSOLVED

if TYPE_CHECKING:
    from tamp.cli.options import Commands


def add(commands: Commands) -> None:
    """`samplers` and `samplers check`."""
    parser = command(commands, "samplers", samplers, "list the streams and the samplers that serve them")
    parser.add_argument("--domain", default="tabletop", metavar="NAME", help="default: tabletop")
    parser.add_argument("--task", type=Path, metavar="TASK.yaml", help="show the samplers that this task asks for")
    parser.add_argument("--sampler", type=replacement, action="append", default=[], metavar="NAME=MODULE:FUNCTION")
    add_trust(parser)
    add_json(parser)
    text = "hold a sampler against its stream; exit status 1 where anything is wrong"
    kit = command(parser.add_subparsers(metavar="check"), "check", check, text)
    kit.add_argument("address", metavar="MODULE:FUNCTION")
    kit.add_argument("--stream", required=True, metavar="NAME")
    kit.add_argument("--domain", default="tabletop", metavar="NAME", help="default: tabletop")
    kit.add_argument("--task", type=Path, metavar="TASK.yaml", help="where to try it; default: built-in scenarios")
    kit.add_argument("--seed", type=natural, default=0, metavar="N")
    add_trust(kit)
    add_json(kit)


def samplers(options: argparse.Namespace) -> int:
    """Each stream of a domain with the types of its inputs and outputs, and the function that serves it."""
    from tamp.domains.catalog import contract, load_domain, type_name
    from tamp.domains.samplers import resolve_samplers

    entry = load_domain(options.domain)
    asked = load(options.task, options).samplers if options.task is not None else {}
    replaced = dict(options.sampler)
    resolve_samplers(entry.samplers, asked if options.trust_task_code else {}, replaced)
    listed = []
    for stream in entry.stream_file.streams:
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
        if not to_stdout(options):
            told = f", told where things are by ({', '.join(stream.fluents)})" if stream.fluents else ""
            print(f"{stream.name}{types}{told}\n    {layer[stream.name]}  (by {by})", file=options.out)
    if not to_stdout(options):
        for name, address in plugins.addresses("samplers").items():
            print(f"installed as {name!r}: {address}", file=options.out)
    write_json(options, listed)
    return SOLVED


def check(options: argparse.Namespace) -> int:
    """Print what the conformance kit has found; exit status 1 where anything is wrong."""
    from tamp.conformance import check_sampler
    from tamp.pipeline.options.trust import refuse_code

    tasks = None if options.task is None else [load(options.task, options)]
    for task in tasks or ():  # its domain is imported to set it up; its samplers are not asked
        refuse_code(replace(task, samplers={}), trusted=options.trust_task_code)
    judgement = check_sampler(options.address, options.stream, domain=options.domain, tasks=tasks, seed=options.seed)
    if not to_stdout(options):
        print(judgement, file=options.out)
        if options.verbose:
            print("\n".join(judgement.details), file=options.out)
    write_json(options, judgement.as_dict())
    return SOLVED if judgement.fits else UNSOLVED
