"""Blocks of the pages: each a function from committed results to markdown."""
