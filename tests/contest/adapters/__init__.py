"""Tests of what runs solutions that were written for OCRTOC."""
