"""Waves: from a sea and a seed to the excitation moments of the float.

A sea is a frozen value (`SeaState`, `DriftingSea`, `TabulatedSpectrum`, `Regular`, `Bichromatic`, `ElevationRecord`).
`realise` turns it and a seed into one `WaveRealisation`; `prepare` does once what is common to all seeds, and its
`Synthesis` gives the moments of many. The names stand in ``__init__.pyi`` and are loaded when they are first used:
those of `estimation` bring compiled code along.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
