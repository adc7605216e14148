"""`tamp perceive`: where objects are, from the pictures of a set-up's cameras."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from tamp.cli.options import add_trust, command, load, natural
from tamp.cli.paths import DATA, output_file, output_folder
from tamp.cli.status import SOLVED, UNSOLVED

if TYPE_CHECKING:
    from tamp.cli.options import Commands


def add(commands: Commands) -> None:
    """`perceive`."""
    parser = command(
        commands, "perceive", perceive, "estimate poses from rendered pictures; needs the extra 'perception'"
    )
    add = parser.add_argument
    add("task", type=Path, metavar="TASK.yaml")
    add(
        "-o", "--output", type=output_file(DATA), default=Path("poses.json"), metavar="FILE", help="default: poses.json"
    )
    add("--perceiver", default="fit", metavar="NAME", help="a name, or package.module:function; default: fit")
    add("--setup", type=Path, metavar="FILE", help="the cameras; default: those of OCRTOC 2021")
    add("--visuals", type=Path, metavar="DIR", help="coloured meshes, MODEL.ply; default: visual.ply beside each mesh")
    add("--masks", action="store_true", help="tell the perceiver which object each pixel shows")
    add("--pictures", type=output_folder, metavar="DIR", help="write every frame with the estimates drawn over it")
    add("--seed", type=natural, default=0, metavar="N", help="of noise and guesses")
    add_trust(parser)


def perceive(options: argparse.Namespace) -> int:
    """Print what was seen and how sure that is, and write it; exit status 1 where something was not seen."""
    from tamp.perception.cameras.setup import OCRTOC_2021
    from tamp.perception.perceive import perceive_task, report, save_sight

    sight = perceive_task(
        load(options.task, options),
        perceiver=options.perceiver,
        setup=options.setup or OCRTOC_2021,
        visuals=options.visuals,
        masks=options.masks,
        seed=options.seed,
    )
    print("\n".join(report(sight)), file=options.out)
    for path in save_sight(sight, options.output, options.pictures):
        print(path, file=options.out)
    return SOLVED if all(e.pose is not None for e in sight.estimates.values()) else UNSOLVED
