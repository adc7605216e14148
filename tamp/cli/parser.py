"""An argument parser that says what was probably meant."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from typing import Any, NoReturn

from tamp.errors import nearest


class Parser(argparse.ArgumentParser):
    """As argparse has it; an unknown command, choice or option is refused with the nearest one that there is."""

    def parse_known_args(self, args: Sequence[str] | None = None, namespace: Any = None) -> Any:  # type: ignore[override]
        """Refuse what is left over, and do it here: only the command's own parser knows its options."""
        self._refuse_before_commands(sys.argv[1:] if args is None else args)
        found, extras = super().parse_known_args(args, namespace)
        if extras:
            options = [option.strip("-") for option in self._option_string_actions if option.startswith("--")]
            words = (word.strip("-").partition("=")[0] for word in extras if word.startswith("-"))
            near = next(filter(None, (nearest(word, options) for word in words)), None)
            hint = f"; did you mean --{near}?" if near else ""
            self.error(f"unrecognized arguments: {' '.join(extras)}{hint}")
        return found, extras

    def _refuse_before_commands(self, args: Sequence[str]) -> None:
        """Refuse a command's option before the command, whose value would be taken for a command."""
        commands = any(isinstance(action, argparse._SubParsersAction) for action in self._actions)
        if not commands or not args or not args[0].startswith("--"):
            return
        word = args[0].partition("=")[0]
        if not any(option.startswith(word) for option in self._option_string_actions):
            self.error(f"{word} is no option of {self.prog} itself; options stand behind the command they are for")

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is None or value in action.choices:
            return
        valid = list(map(str, action.choices))
        near = nearest(value, valid)
        hint = f"; did you mean {near}?" if near else ""
        if isinstance(action, argparse._SubParsersAction):
            self.error(f"there is no command {value!r}{hint}")
        raise argparse.ArgumentError(action, f"{value!r} is not valid{hint or '; valid are ' + ', '.join(valid)}")

    def error(self, message: str) -> NoReturn:
        """Say what is wrong in one sentence, with where help is; exit status 2."""
        self.exit(2, f"tamp: {message} (see {self.prog} --help)\n")
