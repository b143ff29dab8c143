"""Joints that are constraints: those that close loops, and locks."""
