"""A robot held against what planning, checking and execution count on, in the order in which mistakes mislead.

What two rooms compute is computed twice: the planner's kinematics are Pinocchio's, the checker's are its own.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

import numpy as np

from tamp.checking.robot.kinematics import KinematicTree
from tamp.checking.robot.links import Links, read_links
from tamp.conformance.findings import Finding
from tamp.conformance.robot.hints import described, free_home, often_touching
from tamp.conformance.robot.pads import beyond, finger_points, inner, past_ends
from tamp.conformance.robot.ranges import faster, on_table, too_wide, widths
from tamp.conformance.robot.standing import stand
from tamp.errors import RobotError, TaskError
from tamp.execution.simulators import installed
from tamp.streams.hand.hand_boxes import hand_boxes
from tamp.task import RobotSpec, Table
from tamp.task.mesh.mesh_file import read_mesh
from tamp.task.mesh.parts import convex_hull
from tamp.task.mesh.surface import oriented, volume
from tamp.world.geometry.convex_union import separation, solid
from tamp.world.kinematics.freedom import confined
from tamp.world.kinematics.inverse import inverse
from tamp.world.robot.hand import hand_poses
from tamp.world.robot.model import RobotModel, robot_model
from tamp.world.scene import Scene
from tamp.world.world import World

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

AGREED = 1e-6  # two forward kinematics agree to this [m, and as much in a rotation's entries]
CONFIGURATIONS = 200  # at which forward kinematics are compared, and to whose tool poses the way back is looked for
HITS = 0.95  # least share of reachable poses that inverse kinematics finds
OPENINGS = 9  # at which the pads are looked at
PADS = 0.002  # how far the fingers' hulls may be from where the opening says [m]
ASIDE = 0.001  # how far the pads' middle may be beside the tool's axis, and pads may reach beyond the fingers [m]
HOME = 0.02  # how far the arm keeps from everything in a home that is proposed [m]
FAT = 3.0  # a hull of so many times its mesh's volume is worth a note
RINGS = np.arange(0.2, 1.3, 0.05)  # distances from the base's axis at which the hand comes straight down [m]
HEIGHTS = (0.03, 0.15)  # of the tool over the table there [m]
TURNS = 4  # of the hand about the vertical, at each of as many directions
EASY = 0.9  # share of them from which on a distance is well within reach


@dataclass(frozen=True)
class RobotJudgement:
    """All findings on one robot.

    Attributes:
        robot: its name or path.
        findings: in the order of the checks.
        numbers: what was measured.
    """

    robot: str
    findings: tuple[Finding, ...]
    numbers: Mapping[str, Any] = field(default_factory=dict)

    @property
    def fits(self) -> bool:
        """Whether nothing is wrong."""
        return all(finding.outcome != "wrong" for finding in self.findings)

    @property
    def drawable(self) -> bool:
        """Whether its description can be read."""
        return not any(f.check == "description" and f.outcome == "wrong" for f in self.findings)

    def as_dict(self) -> dict[str, Any]:
        """JSON-like values."""
        findings = [{"check": f.check, "outcome": f.outcome, "text": f.text} for f in self.findings]
        return {"robot": self.robot, "fits": self.fits, "findings": findings, "numbers": dict(self.numbers)}

    def __str__(self) -> str:
        wrong = sum(f.outcome == "wrong" for f in self.findings)
        lines = [f"  {f.outcome:5s}  {f.check:12s}  {f.text}" for f in self.findings]
        return "\n".join([self.robot, *lines, "it fits" if self.fits else f"{wrong} thing{'s' * (wrong > 1)} wrong"])


def check_robot(spec: RobotSpec, *, seed: int = 0) -> RobotJudgement:
    """Hold a robot against what it is used for.

    Args:
        spec: the robot.
        seed: decides every random choice.
    """
    findings: list[Finding] = []
    try:
        findings += described(spec)
        trial = _Trial(spec, robot_model(spec), read_links(spec), np.random.default_rng(seed))
    except (RobotError, TaskError) as error:
        return RobotJudgement(spec.name, (*findings, Finding("description", "wrong", str(error))))
    checks = (
        trial.limits, trial.kinematics, trial.gripper, trial.hand, trial.hulls, trial.collisions, trial.inverse,
        trial.reach, trial.simulation,
    )  # fmt: skip
    try:
        for check in checks:
            findings += check()
    except RobotError as error:
        findings.append(Finding(check.__name__, "wrong", str(error)))
    return RobotJudgement(spec.name, tuple(findings), trial.numbers)


@dataclass
class _Trial:
    """One robot at work; each method is one check."""

    spec: RobotSpec
    robot: RobotModel
    links: Links
    rng: np.random.Generator
    numbers: dict[str, Any] = field(default_factory=dict)

    @property
    def tree(self) -> KinematicTree:
        """The checker's kinematics."""
        return self.links.tree

    def limits(self) -> Iterator[Finding]:
        """Ranges of joints, and whether the limits are within the URDF's."""
        spec = self.spec
        for text in faster(spec):
            yield Finding("limits", "note", text)
        if spec.still:
            told = _some([f"{name} at {value:g}" for name, value in spec.still])
            yield Finding("limits", "note", f"joints that nothing drives stand still: {told}; posture: moves them")
        self.numbers["ranges"] = (np.array(spec.upper) - np.array(spec.lower)).round(3).tolist()
        if wide := too_wide(self.robot):
            yield Finding("limits", "wrong", wide)
            return
        yield Finding("limits", "ok", f"home is inside; the joints' ranges are {', '.join(widths(self.robot))}")

    def kinematics(self) -> Iterator[Finding]:
        """Planner and checker have every link and the tool in the same place, and the arm is one chain."""
        q = self.rng.uniform(self.robot.lower, self.robot.upper, (CONFIGURATIONS, self.robot.dof))
        openings = self.rng.uniform(0.0, self.spec.gripper.stroke, CONFIGURATIONS)
        worst, where = 0.0, "the tool"
        for row, opening in zip(q, openings, strict=True):
            placed = self.tree.forward(row[None], float(opening))
            poses = self.robot.joint_poses(row[None], float(opening))[0]
            off = float(np.abs(self.tree.tool(row[None])[0] - self.robot.forward(row)).max())
            pairs = [(off, "the tool")]
            for solid_, T in ((s, placed[s.name][0]) for s in self.links.solids):
                own = np.concatenate([p.part.vertices for p in solid_.pieces]) @ T[:3, :3].T + T[:3, 3]
                theirs = np.concatenate(
                    [
                        b.hull.vertices @ poses[b.joint][:3, :3].T + poses[b.joint][:3, 3]
                        for b in self.robot.bodies
                        if b.name == solid_.name
                    ]
                )
                pairs.append((float(np.abs(own - theirs).max()), solid_.name))
            worst, where = max((worst, where), *pairs)
        self.numbers["kinematics_m"] = worst
        if worst < AGREED:
            text = f"two forward kinematics agree to {worst:.1e} m at {CONFIGURATIONS} configurations and openings"
            yield Finding("kinematics", "ok", text)
        else:
            text = f"two forward kinematics differ by {worst:.1e} m at {where}; at most {AGREED:g} is valid"
            yield Finding("kinematics", "wrong", text)

    def gripper(self) -> Iterator[Finding]:
        """The pads are as far apart as the opening says, with their middle on the tool's axis."""
        spec, linkage = self.spec, self.robot.linkage
        if not all(any(b.name == name for b in self.robot.bodies) for name in spec.gripper.fingers):
            return
        bodies = {name: solid([b.hull for b in self.robot.bodies if b.name == name]) for name in spec.gripper.fingers}
        index = {self.robot.bodies[i].name: k for k, i in enumerate(self.robot.hand)}
        gaps, middles, across, ends = [], [], [], []
        openings = np.linspace(0.0, spec.gripper.stroke, OPENINGS)
        for opening in openings:
            poses = hand_poses(self.robot, float(opening))
            first, second = (poses[index[name]] for name in spec.gripper.fingers)
            left, right = (bodies[name] for name in spec.gripper.fingers)
            gaps.append(separation(left, right, np.linalg.inv(first) @ second))
            fingers, depth = finger_points(self.robot, float(opening)), float(linkage.depth(opening))
            middles.append(sum(inner(spec.gripper, points) for points in fingers) / 2)
            across += [beyond(spec.gripper, points) for points in fingers]
            ends += [past_ends(spec.gripper, points, depth) for points in fingers]
        off = float(np.abs(np.array(gaps)[1:] - openings[1:]).max())
        aside = float(np.abs(middles).max())
        over = max(across)
        tips, backs = (float(max(side)) for side in zip(*ends, strict=True))
        travel = float(np.ptp(linkage.depth(openings)))
        self.numbers |= {"pads_off_m": off, "pads_aside_m": aside, "pads_beyond_m": over, "pads_travel_m": travel}
        self.numbers |= {"pads_past_tips_m": tips, "pads_past_backs_m": backs}
        if off > PADS:
            yield Finding(
                "gripper",
                "wrong",
                f"at openings of {1000 * openings[-1]:.1f} and {1000 * openings[1]:.1f} mm the fingers' hulls are "
                f"{1000 * gaps[-1]:.1f} and {1000 * gaps[1]:.1f} mm apart: give gripper.pads, another stroke or limits",
            )
        if aside > ASIDE:
            text = f"the pads' middle is {1000 * aside:.1f} mm beside the tool's z axis"
            yield Finding("gripper", "wrong", f"{text}; move the tool or turn gripper.axis")
        if over > ASIDE:
            text = f"pads of gripper.pad's width reach {1000 * over:.1f} mm beyond the fingers, across their closing"
            yield Finding("gripper", "wrong", f"{text}; move the tool, or give the pads' width")
        for past, end in ((tips, "fingertips"), (backs, "fingers' other ends")):
            if past > ASIDE:
                text = f"pads of gripper.pad's length reach {1000 * past:.1f} mm beyond the {end}, along the approach"
                middle = "move the tool" if spec.gripper.pads is None else "move gripper.pads"
                yield Finding("gripper", "wrong", f"{text}; {middle} to the pads' middle, or give their length")
        if off <= PADS and max(aside, over, tips, backs) <= ASIDE:
            text = f"opens to {1000 * spec.gripper.stroke:.1f} mm, pads right to {1000 * off:.2f} mm"
            text += f", {1000 * travel:.1f} mm of way along the approach" if travel else ""
            yield Finding("gripper", "ok", text)

    def hand(self) -> Iterator[Finding]:
        """How much room the hand takes over the stroke, and how deep its throat is."""
        boxes = hand_boxes(self.robot)
        lower, upper = boxes.opened(np.linspace(0.0, self.spec.gripper.stroke, OPENINGS))
        width = float((upper.max(axis=(0, 1)) - lower.min(axis=(0, 1))) @ np.abs(self.spec.gripper.axis))
        if not (boxes.side != 0.0).any():
            text = "closed fingers reach over the middle between them: their zero is not closed, or the tool is aside"
            yield Finding("hand", "wrong", text)
            return
        tip, throat = boxes.tip(0.0), np.inf
        if (boxes.side == 0.0).any():
            throat = tip - boxes.palm(0.0)
        self.numbers |= {"hand_width_m": width, "tip_m": tip, "throat_m": throat if np.isfinite(throat) else None}
        if tip <= 0.0 or tip > 0.1:
            text = f"the fingers end {1000 * tip:.0f} mm along z from the tool; the tool belongs between the pads"
            yield Finding("hand", "wrong", text)
            return
        if throat <= 0.0:
            text = f"what is no finger reaches {-1000 * throat:.0f} mm beyond the fingertips along the tool's z"
            yield Finding("hand", "wrong", f"{text}; turn the tool: its z points out of the hand, along the fingers")
            return
        text = f"sweeps {1000 * width:.0f} mm across, fingertips {1000 * tip:.0f} mm beyond the tool"
        deep = f", the palm {1000 * throat:.0f} mm behind them" if np.isfinite(throat) else ""
        yield Finding("hand", "ok", text + deep)
        deepest = max(self.spec.gripper.depths)
        if deepest > throat:
            yield Finding("hand", "note", f"depths of up to {1000 * deepest:.0f} mm reach into the palm")

    def hulls(self) -> Iterator[Finding]:
        """Convex hulls are not much fatter than the links, and every moving link has one."""
        root = ElementTree.fromstring(self.spec.description)
        ratios: dict[str, float] = {}
        bare = []
        for link in root.findall("link"):
            name = link.get("name", "")
            if link.find("collision") is None and link.find("visual") is not None:
                bare.append(name)
            for element in link.iterfind("collision/geometry/mesh"):
                ratios[name] = max(ratios.get(name, 0.0), _fatness(element))
        self.numbers |= {
            "fatness": {name: round(ratio, 2) for name, ratio in ratios.items()},
            "without_collision": bare,
        }
        unseen = [
            link.get("name", "")
            for link in root.findall("link")
            if link.find("collision") is not None and link.find("visual") is None
        ]
        if unseen:
            text = f"not drawn, for want of a <visual> whose mesh is found: {_some(unseen)}"
            yield Finding("hulls", "note", text)
        if bare:
            text = f"nothing meets links that are drawn but have no collision geometry: {_some(bare)}"
            yield Finding("hulls", "note", text)
        fat = [f"{name} {ratio:.1f}" for name, ratio in ratios.items() if ratio > FAT]
        if fat:
            text = f"hulls of so many times their mesh's volume: {_some(fat)}; cut those into several <collision>"
            yield Finding("hulls", "note", text)
        yield Finding("hulls", "ok", f"{len(self.robot.bodies)} hulls; {len(ratios)} links have meshes")

    def collisions(self) -> Iterator[Finding]:
        """At home nothing touches, and which links are looked at."""
        bodies = self.robot.bodies
        pairs = sorted({f"{bodies[a].name} and {bodies[b].name}" for a, b in self.robot.pairs})
        self.numbers |= {"self_collision_pairs": pairs, "pairs_of_the_checker": len(self.links.pairs)}
        yield Finding(
            "collisions",
            "ok" if pairs else "note",
            f"{len(pairs)} pairs of links can meet, as sampled (--json has them)",
        )
        world, opened = World(self.robot, {}, Table()), Scene(opening=self.spec.gripper.stroke)
        checker = world.checker(opened, margin=0.002)
        often = often_touching(self.robot, checker)
        self.numbers["often_touching"] = dict(often)
        if often:
            told = _some([f"{pair} at {share:.0%}" for pair, share in often])
            text = f"links that are in each other at so many of all configurations: {told}; where the real ones are"
            yield Finding("collisions", "note", f"{text} not, give disable_collisions, or cut their meshes")
        if not checker.free(self.robot.home):
            met, home = checker.contact(self.robot.home), free_home(self.robot, world.checker(opened, margin=HOME))
            told = "" if home is None else f"; free is [{', '.join(f'{v:.2f}' for v in home)}]"
            yield Finding("collisions", "wrong", f"at home: {met}; choose another home, or lift the base{told}")

    def inverse(self) -> Iterator[Finding]:
        """Tool poses that the arm can take are found again."""
        found, times = 0, []
        for _ in range(CONFIGURATIONS):
            T = self.robot.forward(self.rng.uniform(self.robot.lower, self.robot.upper))
            began = time.process_time()
            q = next(iter(inverse(self.robot, T, self.rng, count=1)), None)
            times.append(time.process_time() - began)
            found += q is not None and bool(np.abs(self.robot.forward(q) - T).max() < 2e-4)
        share = found / CONFIGURATIONS
        self.numbers |= {"ik_hits": share, "ik_ms": 1000 * float(np.median(times[1:]))}
        text = f"{share:.0%} of {CONFIGURATIONS} reachable tool poses found"
        yield Finding("inverse", "ok" if share >= HITS else "wrong", text)
        if confined(self.robot):
            text = "the arm cannot turn its tool every way: it grasps from straight above only"
            yield Finding("inverse", "note", f"{text}, and leaves what would have to be turned over or laid down")

    def reach(self) -> Iterator[Finding]:
        """The hand comes straight down to the table within `reach`."""
        near, far = self.spec.reach
        if off := on_table(self.spec):
            yield Finding("reach", "wrong", off)
            return
        shares = {round(float(r), 2): self._hits_at(float(r)) for r in RINGS}
        self.numbers["from_above"] = shares
        good = [r for r, share in shares.items() if share >= EASY]
        inside = [share for r, share in shares.items() if near <= r <= far]
        if not good:
            text = "the hand comes straight down hardly anywhere on the table: are base, home and tool right?"
            yield Finding("reach", "wrong", text)
            return
        share = min(inside, default=0.0)
        if not any(share >= EASY for share in inside):
            text = f"arm.reach says {near:g} to {far:g} m, where the hand hardly comes straight down to the table; well"
            yield Finding("reach", "wrong", f"{text} within reach are {good[0]:.2f} to {good[-1]:.2f} m")
            return
        told = f"straight down it reaches the table well from {good[0]:.2f} to {good[-1]:.2f} m"
        text = f"{told}; arm.reach says {near:g} to {far:g} m, where it is {share:.0%} at worst"
        yield Finding("reach", "ok" if share >= EASY else "note", text)

    def simulation(self) -> Iterator[Finding]:
        """What every simulator that is installed makes of it."""
        for name in installed():
            standing = stand(name, self.spec)
            self.numbers[f"standing_in_{name}"] = {
                "off": standing.off,
                "shut_m": standing.shut,
                "open_m": standing.open,
            }
            yield Finding("simulation", "wrong" if standing.complaint else "ok", f"{name}: {standing}")

    def _hits_at(self, radius: float) -> float:
        base, hits, tried = self.spec.T_world_base, 0, 0
        for direction in np.linspace(-np.pi / 4, np.pi / 4, TURNS):
            c, s = np.cos(direction), np.sin(direction)
            place = base.matrix[:3, :3] @ (radius * np.array([c, s, 0.0])) + np.array(base.xyz)
            for turn in range(TURNS):
                c, s = np.cos(turn * np.pi / TURNS), np.sin(turn * np.pi / TURNS)
                for height in HEIGHTS:
                    T = np.eye(4)
                    T[:3, :3] = np.diag([1.0, -1.0, -1.0]) @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
                    T[:3, 3] = *place[:2], height
                    hits += next(iter(inverse(self.robot, T, np.random.default_rng(0), count=1)), None) is not None
                    tried += 1
        return hits / tried


def _some(names: list[str]) -> str:
    """The first few of many names."""
    more = f" and {len(names) - 6} more" if len(names) > 6 else ""
    return ", ".join(names[:6]) + more


def _fatness(element: ElementTree.Element) -> float:
    """Volume of a mesh's hull against its own, 1 where the mesh is not closed and has none."""
    x, y, z = map(float, element.get("scale", "1 1 1").split())
    mesh = read_mesh(Path(element.get("filename", "")), (x, y, z))
    faces = np.concatenate(mesh.groups)
    if not oriented(faces):
        return 1.0
    hull = convex_hull(mesh.vertices)
    return abs(volume(hull.vertices, hull.faces) / volume(mesh.vertices, faces))
