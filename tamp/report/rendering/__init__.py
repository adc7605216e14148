"""Pictures, films and playback of scenes and runs.

May import tamp.execution, tamp.world and the runs of tamp.report.
"""
