"""Arguments of the commands that show results: pages, pictures, the viewer."""

from __future__ import annotations

import argparse
from pathlib import Path

from tamp.arguments.kinds import Commands, command, natural, seconds


def add(commands: Commands[argparse.ArgumentParser]) -> None:
    """`report`, `render`, `view`."""
    report = command(commands, "report", "report:report", "write a report on results: one HTML file, no network")
    report.add_argument("folders", nargs="+", type=Path, metavar="DIR", help="folders of results, one a solution")
    report.add_argument("-o", "--output", type=Path, metavar="FILE", help="default: report.html in the first folder")
    report.add_argument("--pictures", type=natural, default=100, metavar="N", help="of at most N runs; default 100")
    render = command(commands, "render", "render:render", "pictures and a film of a run, without a display")
    _add_run(render)
    render.add_argument("-o", "--output", type=Path, metavar="OUT", help="folder for them; default: the run's own")
    render.add_argument(
        "--film", choices=("gif", "mp4"), default="gif", help="mp4 needs the extra 'video'; default gif"
    )
    view = command(commands, "view", "render:view", "play a run in the browser; needs the extra 'viewer'")
    _add_run(view)
    view.add_argument("--port", type=natural, default=8080, metavar="N", help="of the web server; default 8080")
    view.add_argument("--record", type=Path, metavar="FILE", help="write a page that plays by itself (.html) and end")


def _add_run(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("folder", type=Path, metavar="RUN", help="a run's folder, DIR/TASK-SEED")
    parser.add_argument("--frame", type=seconds, default=0.2, metavar="SECONDS", help="between moments; default 0.2")
    parser.add_argument("--simulate", action="store_true", help="carry the plans out again instead of playing them")
