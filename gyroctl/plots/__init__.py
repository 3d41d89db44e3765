"""Pictures that objects draw of themselves, by matplotlib: functions of the object, called by its `plot` or `bode`.

Nothing here changes a number, so that no stored result rests on it. matplotlib is loaded when a picture is drawn.
"""
