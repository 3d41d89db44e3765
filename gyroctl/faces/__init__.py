"""What an object shows of itself: a few lines in a terminal, a card with a small picture in a notebook.

A class gets both by `show.shown` and a function that tells its face: title, facts, picture. The rooms that use it hand
over the object; nothing here changes a number, so that no stored result rests on it.
"""
