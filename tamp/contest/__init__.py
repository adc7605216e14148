"""The contest: other people's solutions run in isolation against a standard API, scored, and ranked.

- api: what a solution sees; needs nothing but NumPy, and imports nothing else of the program
- sandbox: a process without network and file system, with limits
- evaluation: the simulated cell behind the API, one run, all runs of a solution, and what counts of them
- service: the web service: teams, submissions, a durable queue, workers, pages
- samples: solutions to begin with
"""
