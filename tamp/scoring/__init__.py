"""How well a task was done: the paper's EDE and its baselines."""

from tamp.scoring.ede import ede, upper_error_bound
from tamp.scoring.score import ObjectScore, Score, score

__all__ = ["ObjectScore", "Score", "ede", "score", "upper_error_bound"]
