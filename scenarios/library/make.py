"""Drawing objects of the parametric kinds: our own library, and libraries that nobody has seen.

python -m tamp.scenarios.library.make                       our library anew, the same bytes
python -m tamp.scenarios.library.make --seed 7 -o FOLDER    another one: the same kinds in other sizes
"""

from __future__ import annotations

import argparse
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from tamp.scenarios.library import implements, packages, toys, vessels
from tamp.scenarios.library.kinds import Body, Kind
from tamp.scenarios.library.model import FILE, FOLDER, SETS
from tamp.scenarios.parts import obj_text, volume, write_obj

KINDS: tuple[Kind, ...] = (*vessels.KINDS, *packages.KINDS, *implements.KINDS, *toys.KINDS)

HEADER = """\
# Household objects in metres and kilograms; the format is described in scenarios/library/model.py.
# Written by `python -m tamp.scenarios.library.make --seed {seed}`: change the kinds there, not this file.
"""


@dataclass(frozen=True, eq=False)
class Drawn:
    """One object of a kind.

    Attributes:
        kind: the kind.
        sizes: what was drawn [m].
        body: what the kind makes of them.
    """

    kind: Kind
    sizes: dict[str, float]
    body: Body

    @property
    def mass(self) -> float:
        """Of its parts at the kind's density, whole grams [kg]."""
        return round(self.kind.density * volume(self.body.parts), 3)


def draw(kind: Kind, *seed: int) -> Drawn:
    """An object of a kind; the same for the same seed, and independent of what else is drawn."""
    name = int.from_bytes(kind.name.encode(), "big")
    sizes = kind.draw(np.random.default_rng((*seed, name)))
    return Drawn(kind, sizes, kind.build(**sizes))


def write_library(folder: Path, seed: int = 0) -> None:
    """Write a library with one object of every kind in the trial set and one in the contest set."""
    entries = []
    for kind in KINDS:
        for number, of_set in enumerate(SETS, start=1):
            drawn = draw(kind, seed, number)
            name = f"{kind.name}_{number}"
            write_obj(folder / f"{name}.obj", obj_text(f"{name}, in metres", drawn.body.parts))
            entries.append(_entry(name, of_set, drawn))
    lines = [yaml.safe_dump([entry], sort_keys=False, default_flow_style=True, width=10_000) for entry in entries]
    listed = "".join(f"  - {line.strip()[1:-1]}\n" for line in lines)
    (folder / FILE).write_text(HEADER.format(seed=seed) + "objects:\n" + listed, encoding="utf-8", newline="\n")


def _entry(name: str, of_set: str, drawn: Drawn) -> dict[str, Any]:
    kind, body = drawn.kind, drawn.body
    entry: dict[str, Any] = {"name": name, "category": kind.category, "set": of_set, "mesh": f"{name}.obj"}
    entry |= {"mass": drawn.mass, "friction": kind.friction}
    entry["symmetry"] = {axis: fold for axis, fold in asdict(kind.symmetry).items() if fold != 1}
    for key, area in (("top", body.top), ("hollow", body.hollow)):
        if area is not None:
            entry[key] = [round(side, 4) for side in area]
    return {**entry, "made": {"kind": kind.name, **drawn.sizes}}


def main() -> None:
    """Write a library from the command line."""
    parser = argparse.ArgumentParser(prog="python -m tamp.scenarios.library.make")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("-o", "--output", type=Path, default=FOLDER)
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    write_library(options.output, options.seed)


if __name__ == "__main__":
    main()
