"""Whether a module's source can define a solution, told without running any of it. A program of its own.

What compiles strangers' source may need any memory, or end the interpreter: it is a process with limits. Where it is
ended, or the source makes names as it runs, nothing is said against it: a run tells.
"""

from __future__ import annotations

import ast
import resource
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

PROCESSOR_S, MEMORY = 3, 1 << 30
"""What reading a module may take: processor time [s] and memory [bytes]."""

METHODS = {"Solution": {"run", "draw_action"}, "MyAgent": {"draw_action"}}
"""The class that counts, the first one that there is -> what makes it a solution; see `tamp.contest.api.host.load`."""

MAKERS = frozenset(("exec", "globals", "locals", "vars", "setattr", "modules", "__getattr__", "run", "draw_action"))
"""What may give a module or a class names that are not written where they belong."""

LACKING = "has no class Solution with run(self, goal, robot), nor MyAgent with draw_action(self, observation)"

SCOPES = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef, ast.Lambda)


def objection(source: Path) -> str:
    """Why no solution can be in a module, in a line; empty where it may hold one.

    Raises:
        OSError: where no process can be started.
    """
    command = [sys.executable, "-I", "-S", "-X", "utf8", str(Path(__file__)), str(source)]
    try:
        ended = subprocess.run(command, capture_output=True, check=False, timeout=20 * PROCESSOR_S)
    except subprocess.TimeoutExpired:
        return ""
    said = ended.stdout.decode(errors="replace").strip() if ended.returncode == 0 else ""
    return said + "; import it there from where it is" * (said == LACKING and source.name == "__init__.py")


def lacking(code: bytes) -> str:
    """What of a module's source keeps it from defining a solution; empty where that cannot be told."""
    try:
        tree = ast.parse(code)
        compile(tree, "solution", "exec", dont_inherit=True)
    except SyntaxError as error:
        where = f"line {error.lineno}: " if error.lineno else ""
        return f"is no Python {sys.version_info[0]}.{sys.version_info[1]}: {where}{error.msg}"
    except ValueError as error:  # how some versions tell a zero byte
        return f"is no Python source: {error}"
    if _made_elsewhere(tree):
        return ""
    bound = list(_bound(tree))
    name = next((name for name in METHODS if name in bound), None)
    if name is None:
        return LACKING
    classes = [node for node in _of_scope(tree) if isinstance(node, ast.ClassDef) and node.name == name]
    plain = len(classes) == bound.count(name) and not any(c.bases or c.keywords or c.decorator_list for c in classes)
    methods = {method for one in classes for method in _bound(one)}
    return LACKING if plain and not methods & METHODS[name] else ""


def _made_elsewhere(tree: ast.Module) -> bool:
    """Whether names may come about by what is not seen in the scope that they are in."""
    for node in ast.walk(tree):
        used = (getattr(node, "id", None), getattr(node, "attr", None))
        if isinstance(node, ast.Global) or MAKERS.intersection(used):
            return True
        if isinstance(node, ast.ImportFrom) and node.names[0].name == "*":
            return True
    return "__getattr__" in _bound(tree)


def _bound(scope: ast.AST) -> Iterator[str]:
    """The names that the statements of a scope give something, as often as they do."""
    for node in _of_scope(scope):
        if isinstance(node, ast.alias):
            yield node.asname or node.name.partition(".")[0]
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.id
        elif isinstance(name := getattr(node, "name", None), str):
            yield name


def _of_scope(scope: ast.AST) -> Iterator[ast.AST]:
    """All nodes under one, but for those in functions and classes of their own."""
    waiting = list(ast.iter_child_nodes(scope))
    while waiting:
        node = waiting.pop()
        yield node
        if not isinstance(node, SCOPES):
            waiting += ast.iter_child_nodes(node)


if __name__ == "__main__":
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CPU, (PROCESSOR_S, PROCESSOR_S))
    resource.setrlimit(resource.RLIMIT_CORE, (1, 1))  # by 0, the machine's program for core files would be started
    print(lacking(Path(sys.argv[1]).read_bytes()))
