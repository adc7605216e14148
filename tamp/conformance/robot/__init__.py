"""The kit for robots: does a robot's file fit what planning, checking and execution count on?"""

from tamp.conformance.robot.kit import RobotJudgement, check_robot

__all__ = ["RobotJudgement", "check_robot"]
