"""`tamp render` and `tamp view`."""

from __future__ import annotations

import argparse

from tamp.cli import SOLVED
from tamp.report.filmstrip import film
from tamp.report.images import save_image
from tamp.report.playback import Moment, play, playable, simulate
from tamp.report.render import Stage
from tamp.report.runs import Recorded, read_run
from tamp.report.viewer import Viewer


def render(options: argparse.Namespace) -> int:
    """Write start.png, goal.png, end.png and a film of a run, and say where they are."""
    run = read_run(options.folder)
    task, folder = playable(run), options.output or options.folder
    start = run.plans[0].start
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
        print(folder / name)
    return SOLVED


def view(options: argparse.Namespace) -> int:
    """Serve a run to the browser until interrupted, or write it as a page and end."""
    run = read_run(options.folder)
    task, moments = playable(run), _moments(run, options)
    viewer = Viewer(task, run.plans[0].goals, moments, port=options.port)
    try:
        if options.record is not None:
            viewer.record(options.record)
            print(options.record)
        else:
            print(f"http://localhost:{viewer.server.get_port()} plays {run.result.task}; Ctrl-C ends it")
            viewer.serve()
    finally:
        viewer.close()
    return SOLVED


def _moments(run: Recorded, options: argparse.Namespace) -> tuple[Moment, ...]:
    return simulate(run, options.frame) if options.simulate else play(run, options.frame)
