"""The contest as a web service: teams, submissions, a queue that survives restarts, workers, pages.

- contest: rules and tasks of a contest, read once
- store: the database; conditions: under what runs are done, and what becomes of them where rules or tasks change
- teams, submissions: who may hand in what
- queue: which run is done next, by whom, and that each is done once
- worker: a process that does runs; films: moving pictures of them
- board: the leaderboard
- web: pages and API; serve: all processes together
"""
