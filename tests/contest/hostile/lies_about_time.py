"""raised: time goes on"""


class Solution:
    def run(self, goal, robot):
        before, gained = robot.time_left, []
        for seconds in (-1.0, -1e308, float("nan"), float("inf"), 1e308, True, "1", None, [1], 61):
            try:
                robot._connection.call("wait", seconds=seconds)
            except (TypeError, ValueError, AttributeError, RuntimeError):
                pass
            if not robot.time_left <= before:
                gained.append(seconds)
        raise RuntimeError(f"gained by {gained}" if gained else "time goes on")
