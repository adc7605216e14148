"""A process that can do no harm: no network, no files but its own, and limits; whatever Linux has for that.

- isolation: what a sandbox is, as a protocol; limits; what becomes of a process
- process: a started one: its output, its use of memory and processor, its end with all its children
"""
