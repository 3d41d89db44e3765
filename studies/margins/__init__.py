"""Margins of a lock."""
