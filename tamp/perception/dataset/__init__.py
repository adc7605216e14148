"""Labelled scenes for training and measuring: many views of a scene, with poses and masks, in BOP's layout.

May import the rest of tamp.perception; nothing imports it but commands.
"""
