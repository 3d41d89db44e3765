"""Tuning of laws on tuning seeds: one goal, one search, one budget of simulated time for every law."""
