"""Which bodies may meet in a motion or a fall, and what comes of it: what is pushed, struck, knocked over, or jams.

May import the other rooms of the checker; nothing of the actions around it.
"""
