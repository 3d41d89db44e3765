"""Waves out again: a realisation as a table for spreadsheets, or as WEC-Sim imports an elevation."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from gyroctl.errors import InputError
from gyroctl.waves.realisation import WaveRealisation
from gyroctl.writing import write_rows, written_whole

FORMS = {".csv": "table", ".mat": "WEC-Sim", ".txt": "WEC-Sim"}
"""What a file is by its ending."""

VARIABLE = "elevationData"
"""Name of the one variable of a MATLAB file: WEC-Sim takes the only one, whatever its name."""

HEADER = ("time [s]", "elevation [m]", "Me1 [Nm]", "Me3 [Nm]")


def form_of(path: Path) -> str:
    """What a file is to hold, by its ending.

    Raises
    ------
    InputError
        Field ``out``: an ending of no form.
    """
    form = FORMS.get(path.suffix.lower())
    if form is None:
        mend = "Give waves.csv for a table, waves.mat or waves.txt for WEC-Sim"
        raise InputError("out", str(path), "tells no form by its ending", mend)
    return form


def write_waves(path: Path, waves: WaveRealisation) -> Path:
    """Write a realisation, whole or not at all.

    Parameters
    ----------
    path : Path
        ``.csv``: a table with a heading, of time, elevation at the float's centre and both excitation moments.
        ``.mat`` or ``.txt``: time and elevation as WEC-Sim takes them for ``waves.elevationFile`` of a
        ``waveClass('elevationImport')``, one variable of two columns, or two columns without a heading.
    waves : WaveRealisation
        As it acts: led in from the regular wave where it is.

    Returns
    -------
    Path
        The file. Every number in it is read back as the same.

    Raises
    ------
    InputError
        Field ``out``: an ending of no form.
    """
    form = form_of(path)
    if form == "table":
        columns = (waves.time, waves.elevation, waves.moments[0], waves.moments[1])
        return write_rows(path, [HEADER, *zip(*(column.tolist() for column in columns), strict=True)])
    pairs = np.column_stack((waves.time, waves.elevation))
    with written_whole(path) as part:
        if path.suffix.lower() == ".mat":
            from scipy.io import savemat

            with part.open("wb") as stream:
                savemat(stream, {VARIABLE: pairs}, oned_as="column")
        else:
            lines = (f"{t!r} {eta!r}\n" for t, eta in pairs.tolist())
            part.write_text("".join(lines), encoding="ascii", newline="\n")
    return path
