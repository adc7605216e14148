"""`tamp report`, `tamp render` and `tamp view`: results as pages, pictures and films."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from tamp.cli.options import add_simulator, command, natural, seconds
from tamp.cli.parser import Parser
from tamp.cli.paths import PAGE, distinct, output_file, output_folder
from tamp.cli.status import SOLVED

if TYPE_CHECKING:
    from tamp.cli.options import Commands
    from tamp.report.rendering.playback import Moment
    from tamp.report.runs import Recorded


def add(commands: Commands) -> None:
    """`report`, `render`, `view`."""
    parser = command(commands, "report", report, "write a report on results: one HTML file, no network")
    where = "default: report.html in the first folder"
    parser.add_argument("folders", nargs="+", type=Path, metavar="DIR", help="folders of results, one a solution")
    parser.add_argument("-o", "--output", type=output_file(PAGE), metavar="FILE", help=where)
    parser.add_argument("--pictures", type=natural, default=100, metavar="N", help="of at most N runs; default 100")
    parser = command(commands, "render", render, "pictures and a film of a run, without a display")
    _add_run(parser)
    parser.add_argument(
        "-o", "--output", type=output_folder, metavar="OUT", help="folder for them; default: the run's own"
    )
    film = "mp4 needs the extra 'video'; default gif"
    parser.add_argument("--film", choices=("gif", "mp4"), default="gif", help=film)
    as_seen = "as a camera of the set-up sees them instead: its name; needs the extra 'perception'"
    parser.add_argument("--camera", metavar="NAME", help=as_seen)
    parser.add_argument("--cameras", type=Path, metavar="FILE", help="the set-up; default: the run's, or OCRTOC 2021's")
    parser = command(commands, "view", view, "play a run in the browser; needs the extra 'viewer'")
    _add_run(parser)
    parser.add_argument("--port", type=natural, default=8080, metavar="N", help="of the web server; default 8080")
    parser.add_argument(
        "--record", type=output_file(), metavar="FILE", help="write a page that plays by itself (.html) and end"
    )


def _add_run(parser: Parser) -> None:
    parser.add_argument("folder", type=Path, metavar="RUN", help="a run's folder, DIR/TASK-SEED")
    parser.add_argument("--frame", type=seconds, default=0.2, metavar="SECONDS", help="between moments; default 0.2")
    parser.add_argument("--simulate", action="store_true", help="carry the plans out again instead of playing them")
    add_simulator(parser, "in which --simulate carries them out; default: the run's own", None)


def report(options: argparse.Namespace) -> int:
    """Write the page and say where it is."""
    from tamp.report.report import write_report

    path = options.output or options.folders[0] / "report.html"
    write_report(distinct(options.folders), path, pictures=options.pictures)
    print(path, file=options.out)
    return SOLVED


def render(options: argparse.Namespace) -> int:
    """Write start.png, goal.png, end.png and a film of a run, or a camera's pictures, and say where they are."""
    from tamp.report.rendering.film import film
    from tamp.report.rendering.images import save_image
    from tamp.report.rendering.playback import playable
    from tamp.report.rendering.scene import Stage
    from tamp.report.runs import read_run

    run = read_run(options.folder)
    task, folder = playable(run), options.output or options.folder
    start = run.plans[0].start
    if options.camera is not None:
        return _photograph(run, options)
    with Stage(task) as stage:
        pictures = {
            "start.png": stage.picture(start),
            "goal.png": stage.picture_with_goals(start, run.plans[0].goals),
            "end.png": stage.picture(run.final_poses),
        }
        for name, picture in pictures.items():
            save_image(picture, folder / name)
        moving = f"run.{options.film}"
        film(stage, [moment.frame for moment in _moments(run, options)], folder / moving)
    for name in (*pictures, moving):
        print(folder / name, file=options.out)
    return SOLVED


def _photograph(run: Recorded, options: argparse.Namespace) -> int:
    """Write NAME-start.png, NAME-goal.png, NAME-end.png as a camera sees them, and each one's depth in 0.1 mm."""
    from tamp.perception.cameras.photographs import photographs
    from tamp.report.rendering.images import save_image
    from tamp.report.rendering.playback import playable

    task, plan, recorded = playable(run), run.plans[0], run.result.settings.get("cameras")
    setup = options.cameras or (Path(recorded) if recorded else None)
    scenes = {"start": plan.start, "goal": {**plan.start, **plan.goals}, "end": run.final_poses}
    for name, color, depth in photographs(task, scenes, options.camera, setup, run.result.seed):
        for picture, suffix in ((color, ""), (depth, "-depth")):
            path = (options.output or options.folder) / f"{name}{suffix}.png"
            save_image(picture, path)
            print(path, file=options.out)
    return SOLVED


def view(options: argparse.Namespace) -> int:
    """Serve a run to the browser until interrupted, or write it as a page and end."""
    from tamp.report.rendering.playback import playable
    from tamp.report.runs import read_run
    from tamp.report.viewer import Viewer

    run = read_run(options.folder)
    task, moments = playable(run), _moments(run, options)
    viewer = Viewer(task, run.plans[0].goals, moments, port=options.port, sights=run.sights)
    try:
        if options.record is not None:
            viewer.record(options.record)
            print(options.record, file=options.out)
        else:
            address = f"http://localhost:{viewer.server.get_port()}"
            print(f"{address} plays {run.result.task}; Ctrl-C ends it", file=options.out)
            viewer.serve()
    finally:
        viewer.close()
    return SOLVED


def _moments(run: Recorded, options: argparse.Namespace) -> tuple[Moment, ...]:
    from tamp.report.rendering.playback import play, simulate

    return simulate(run, options.frame, options.simulator) if options.simulate else play(run, options.frame)
