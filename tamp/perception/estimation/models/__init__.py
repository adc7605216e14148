"""What is known of an object before it is seen: points, normals and colours of its surface, and its symmetries.

May import what `tamp.perception.estimation` may, and nothing of that.
"""
