"""`tamp contest`: other people's solutions, run in isolation and scored; the web service; its teams."""

from __future__ import annotations

import argparse
import importlib.util
import json
import secrets
import shutil
import sys
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from tamp.cli.options import add_json, command, natural, positive_int, seconds
from tamp.cli.output import to_stdout, write_json, write_text
from tamp.cli.paths import output_folder
from tamp.cli.status import SOLVED, UNSOLVED
from tamp.errors import TampError
from tamp.execution.simulators import DEFAULT

if TYPE_CHECKING:
    from tamp.cli.options import Commands
    from tamp.cli.parser import Parser
    from tamp.contest.evaluation.trial import Trial
    from tamp.contest.rules import Rules
    from tamp.task import Task


def add(commands: Commands) -> None:
    """`contest` and what it does."""
    text = "run other people's solutions against a standard API, in isolation"
    parser = commands.add_parser("contest", help=text, description=f"{text[:1].upper()}{text[1:]}.")
    actions = parser.add_subparsers(title="actions", metavar="ACTION", required=True)
    _add_run(command(actions, "run", run, "run a solution on tasks and score it"))
    _add_service(actions)


def _add_run(parser: Parser) -> None:
    add = parser.add_argument
    add("solution", metavar="SOLUTION", help="a .py, a folder, a .zip, a .whl, or a sample: nothing, scripted, planner")
    add("--tasks", nargs="+", type=Path, metavar="TASK.yaml", help="default: the trial tasks of the rules")
    add("--rules", type=Path, metavar="contest.yaml", help="default: the paper's")
    add("--simulator", nargs="+", metavar="NAME", help="in place of the rules' simulators")
    add("--runs", type=positive_int, metavar="N", help="on each task and simulator, in place of the rules'")
    add("--wall", type=seconds, metavar="SECONDS", help="real time of a run, in place of the rules'")
    add("--library", action="append", metavar="NAME", help="a distribution to offer, beside the rules'; repeat it")
    add("-o", "--output", type=output_folder, metavar="DIR", help="runs.jsonl, results.json, and what each run printed")
    add(
        "--resume",
        action="store_true",
        help="run what DIR lacks, or has of another solution, task or rules",
    )
    add("--overwrite", action="store_true", help="replace the results that DIR has")
    add_json(parser)
    _add_isolation(parser)


def _add_isolation(parser: Parser) -> None:
    parser.add_argument("--sandbox", metavar="NAME", help="bubblewrap or namespaces; default: the first that works")
    text = "run solutions as ordinary processes where there is no sandbox: only what you trust"
    parser.add_argument("--no-isolation", action="store_true", help=text)


def run(options: argparse.Namespace) -> int:
    """Print a table of what counted and write all runs; exit status 0 whatever the solution did."""
    from tamp.cli.contest_runs import RESULTS, Runs
    from tamp.contest.evaluation.evaluate import evaluate, solution_path, summary, table
    from tamp.contest.sandbox.choice import choose

    if options.resume and options.output is None:
        raise TampError("--resume goes on with the runs of a folder: give it by -o DIR")
    solution, rules = solution_path(options.solution), _rules(options)
    tasks = _tasks(options, rules)
    sandbox = choose(name=options.sandbox, insecure=options.no_isolation)
    printed = False
    with ExitStack() as opened:
        kept = None
        if options.output is not None:
            kept = opened.enter_context(
                Runs(
                    options.output, solution, tasks, rules, sandbox.name,
                    resume=options.resume, overwrite=options.overwrite,
                )
            )  # fmt: skip

        def seen(trial: Trial) -> None:
            nonlocal printed
            printed = printed or bool(trial.log)
            if kept is not None:
                kept.add(trial)
            if getattr(options, "verbose", 0):
                _show(trial)

        results = evaluate(solution, tasks, rules, sandbox, seen, () if kept is None else kept.known)
        found = summary(solution.stem, results, tasks, rules) | {"isolation": sandbox.name}
        if options.output is not None:
            write_text(options.output / RESULTS, json.dumps(found, indent=1, allow_nan=False) + "\n")
    write_json(options, found)
    if not to_stdout(options):
        print("\n".join(table(results, tasks, rules)), file=options.out)
        if printed and options.output is None and not getattr(options, "verbose", 0):
            print("what it printed is shown by -v, and kept by -o DIR", file=options.out)
    return SOLVED


def _show(trial: Trial) -> None:
    """What a solution printed in a run, line by line, on standard error."""
    from tamp.contest.sandbox.isolation import visible

    name = f"{trial.result.task}, {trial.result.simulator}, run {trial.result.seed}"
    lines = trial.log.decode("utf-8", errors="replace").splitlines()
    print(*(f"{name}: {visible(line)}\n" for line in lines), sep="", end="", file=sys.stderr)


def _rules(options: argparse.Namespace) -> Rules:
    """Those of the file, changed as the command line says."""
    from tamp.contest.rules import Rules, load_rules

    rules = Rules() if options.rules is None else load_rules(options.rules)
    if options.simulator is not None:
        rules = replace(rules, simulators=tuple(options.simulator))
    if options.runs is not None:
        rules = replace(rules, runs=options.runs)
    if options.wall is not None:
        rules = replace(rules, limits=replace(rules.limits, wall_s=options.wall))
    return replace(rules, libraries=(*rules.libraries, *(options.library or ())))


def _tasks(options: argparse.Namespace, rules: Rules) -> Sequence[Task]:
    from tamp.contest.rules import task_files
    from tamp.task.files.load import load_task

    paths = task_files(rules, "trial") if options.tasks is None else tuple(options.tasks)
    if not paths:
        raise TampError("there is no task to run on; give --tasks TASK.yaml ..., or rules with trial tasks")
    return tuple(load_task(path, allow_outside=True) for path in paths)


def _add_service(actions: Commands) -> None:
    parser = command(actions, "new", new, "begin a contest: a folder with rules and trial tasks")
    parser.add_argument("folder", type=Path, metavar="DIR")
    parser = command(actions, "team", team, "add a team and print its token; needs the extra 'contest'")
    parser.add_argument("name", metavar="NAME")
    parser.add_argument("--renew", action="store_true", help="a new token for a team that there is")
    _add_data(parser)
    parser = command(actions, "serve", serve, "the web service with its workers; needs the extra 'contest'")
    parser.add_argument("--host", default="127.0.0.1", metavar="ADDRESS", help="default: this machine only")
    parser.add_argument("--port", type=positive_int, default=8000, metavar="N", help="default 8000")
    parser.add_argument("--workers", type=natural, default=1, metavar="N", help="processes that evaluate; default 1")
    _add_work(parser)
    text = "after a change of rules or tasks: hold all submissions against the new ones; needs the extra 'contest'"
    parser = command(actions, "again", again, text)
    parser.add_argument("--all", action="store_true", help="do every run anew, as after an upgrade")
    parser.add_argument("--restore", nargs="+", default=(), metavar="NUMBER", help="submissions that were withdrawn")
    _add_data(parser)
    text = "take submissions, or a team with its token, out of the contest; needs the extra 'contest'"
    parser = command(actions, "withdraw", withdraw, text)
    parser.add_argument("numbers", nargs="*", metavar="NUMBER", help="of a submission, as 'status' lists it")
    parser.add_argument("--team", metavar="NAME", help="all of its submissions, and its token")
    parser.add_argument("--why", default="", metavar="TEXT", help="what its team is told")
    parser.add_argument("--give-back", action="store_true", help="it does not count among those of its month")
    _add_data(parser)
    parser = command(actions, "status", status, "list submissions and what waits; needs the extra 'contest'")
    _add_data(parser)
    text = "add the teams of another contest, such as last season's, with their tokens; needs the extra 'contest'"
    parser = command(actions, "carry", carry, text)
    parser.add_argument("source", type=Path, metavar="FOLDER", help="of the other contest")
    parser.add_argument("--from-database", metavar="URL", help="its database; default: SQLite in its folder")
    _add_data(parser)
    parser = command(actions, "work", work, "one more worker, on this machine or another; needs the extra 'contest'")
    parser.add_argument(
        "--parent", type=positive_int, metavar="PID", help="end when this process, its parent, has ended"
    )
    parser.add_argument("--until-empty", action="store_true", help="end when every run is done, or cannot be begun")
    _add_work(parser)


def _add_data(parser: Parser) -> None:
    parser.add_argument("--data", type=Path, required=True, metavar="DIR", help="the folder with contest.yaml")
    parser.add_argument("--database", metavar="URL", help="default: SQLite in the folder; postgresql+psycopg://...")


def _add_work(parser: Parser) -> None:
    _add_data(parser)
    parser.add_argument(
        "--lease", type=_lease, default=60.0, metavar="SECONDS", help="how long a worker may be silent, up to an hour"
    )
    _add_isolation(parser)


def _lease(text: str) -> float:
    from tamp.contest.rules import LONGEST_LEASE_S

    if (lease_s := seconds(text)) > LONGEST_LEASE_S:
        raise argparse.ArgumentTypeError(f"{text} s are longer than the {LONGEST_LEASE_S:g} s that a lease may take")
    return lease_s


NEW = """\
# The rules of this contest; what is left out is as the paper has it. See docs/guides/contest.md.
name: {name}
about: Bring every object to its goal.
trial: [tasks/trial/*.yaml]
contest: [tasks/contest/*.yaml]
simulators: [{simulator}]
runs: 3
seed: {seed}  # of the sensors' noise and calibration, drawn for this contest: keep it to yourself
"""

TRIAL = ("one_object", "swap", "five_apart", "reverse_tower", "clutter_ten")
"""Installed tasks that a new contest offers to practise on."""


def new(options: argparse.Namespace) -> int:
    """Write contest.yaml and trial tasks into a folder that has none."""
    from importlib.resources import files

    folder: Path = options.folder
    if (folder / "contest.yaml").exists():
        raise TampError(f"{folder / 'contest.yaml'}: exists already; nothing was changed")
    name = json.dumps(folder.resolve().name)
    # A secret, and no choice that a run should repeat: solutions that know it could take the sensors' noise away.
    write_text(folder / "contest.yaml", NEW.format(name=name, simulator=DEFAULT, seed=secrets.randbelow(1 << 31)))
    for task in TRIAL:
        _copy(Path(str(files("tamp"))) / "scenarios" / f"{task}.yaml", folder / "tasks" / "trial")
    (folder / "tasks" / "contest").mkdir(parents=True, exist_ok=True)
    print(
        f"{folder / 'contest.yaml'}: the rules; put the hidden tasks into {folder / 'tasks' / 'contest'}, such as by\n"
        f"  tamp generate -n 5 --seed DIGITS -o {folder / 'tasks' / 'contest'}\n"
        "then make a team and start the service:\n"
        f'  tamp contest team "Our team" --data {folder}\n'
        f"  tamp contest serve --data {folder}",
        file=options.out,
    )
    return SOLVED


def _copy(task: Path, folder: Path) -> None:
    """Copy a task file and the meshes beside it that it names."""
    from tamp.task import Mesh
    from tamp.task.files.load import load_task

    meshes = [item.shape.path for item in load_task(task).objects if isinstance(item.shape, Mesh)]
    for file in (task, *meshes, *(mesh.with_name("visual.ply") for mesh in meshes)):
        if file.is_file():
            target = folder / file.resolve().relative_to(task.resolve().parent)
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(file, target)


def team(options: argparse.Namespace) -> int:
    """Print the token of a new team, or a new one of an old team."""
    _require_extra()
    from tamp.contest.service.serve import rules_file
    from tamp.contest.service.store import open_store
    from tamp.contest.service.teams import add_team, renew_token

    rules_file(options.data)  # a token for a folder that is none would be worth nothing
    make = renew_token if options.renew else add_team
    print(make(open_store(options.data, options.database), options.name), file=options.out)
    return SOLVED


def serve(options: argparse.Namespace) -> int:
    """Serve until interrupted."""
    _require_extra()
    from tamp.contest.sandbox.choice import choose
    from tamp.contest.service import serve as service

    sandbox = choose(name=options.sandbox, insecure=options.no_isolation)  # refused here, and not by each worker
    service.rules_file(options.data)
    passed = ["--lease", str(options.lease)]
    passed += ["--sandbox", options.sandbox] if options.sandbox else []
    passed += ["--no-isolation"] if options.no_isolation else []
    workers = [service.worker_command(options.data, options.database, passed)] * options.workers
    listening = service.listen(options.host, options.port)
    host = f"[{options.host}]" if ":" in options.host else options.host
    url = f"http://{host}:{listening.getsockname()[1]}"

    def ready() -> None:
        print(url, file=options.out, flush=True)

    service.serve(options.data, options.database, listening, workers, sandbox, ready)
    return SOLVED


def again(options: argparse.Namespace) -> int:
    """Queue what rules and tasks ask for as they are now."""
    _require_extra()
    from tamp.contest.service import serve as service

    found = service.again(options.data, options.database, everything=options.all, restored=options.restore)
    print(f"{len(found.queued)} runs are to be done, {found.aside} no longer count", file=options.out)
    return SOLVED


def withdraw(options: argparse.Namespace) -> int:
    """Withdraw submissions, or all of a team and its token."""
    _require_extra()
    from tamp.contest.service import withdrawn
    from tamp.contest.service.serve import rules_file
    from tamp.contest.service.store import open_store
    from tamp.contest.service.teams import renew_token

    rules_file(options.data)
    if bool(options.numbers) == (options.team is not None):
        raise TampError("say what is withdrawn: numbers of submissions, or --team NAME")
    store, numbers = open_store(options.data, options.database), tuple(options.numbers)
    if options.team is not None:
        renew_token(store, options.team)  # the new one is nobody's
        numbers = withdrawn.submissions_of(store, options.team)
    withdrawn.withdraw(store, numbers, options.why, counts=not options.give_back)
    print(f"{len(set(numbers))} submissions are withdrawn", file=options.out)
    return SOLVED


def status(options: argparse.Namespace) -> int:
    """A line a submission, the newest first, and what cannot be begun."""
    _require_extra()
    from tamp.contest.service.board import progress
    from tamp.contest.service.queue import put_off_now
    from tamp.contest.service.serve import rules_file
    from tamp.contest.service.store import open_store
    from tamp.contest.service.withdrawn import withdrawn

    rules_file(options.data)
    store = open_store(options.data, options.database)
    for s in progress(store):
        print(f"{s.id}  {s.kind:7s}  {s.state:9s}  {s.done}/{s.total}  {s.team}: {s.file}", file=options.out)
    for w in withdrawn(store):
        why = f" ({w.why})" if w.why else ""
        print(f"{w.id}  {w.kind:7s}  withdrawn  {w.team}: {w.file}{why}", file=options.out)
    put_off = put_off_now(store)
    print("nothing is put off" if put_off is None else put_off, file=options.out)
    return SOLVED


def carry(options: argparse.Namespace) -> int:
    """Add another contest's teams."""
    _require_extra()
    from tamp.contest.service.serve import rules_file
    from tamp.contest.service.store import open_store
    from tamp.contest.service.teams import carry_teams

    rules_file(options.source)
    rules_file(options.data)
    source = open_store(options.source, options.from_database)
    count = carry_teams(source, open_store(options.data, options.database))
    print(f"{count} teams are new here; their tokens are as they were", file=options.out)
    return SOLVED


def work(options: argparse.Namespace) -> int:
    """Evaluate until terminated, or until every run is done; exit status 1 where some could not be begun."""
    _require_extra()
    from tamp.contest.sandbox.choice import choose
    from tamp.contest.service import serve as service

    sandbox = choose(name=options.sandbox, insecure=options.no_isolation)
    left = service.work(
        options.data,
        options.database,
        sandbox,
        options.lease,
        until_empty=options.until_empty,
        parent=options.parent,
    )
    if left is None:
        return SOLVED
    print(f"{left}; they stay in the queue", file=options.out)
    return UNSOLVED


def _require_extra() -> None:
    missing = [name for name in ("fastapi", "sqlalchemy", "uvicorn") if importlib.util.find_spec(name) is None]
    if missing:
        raise TampError(f"{', '.join(missing)} not installed: pip install 'tabletop-tamp[contest]'")
