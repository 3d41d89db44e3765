"""Machine code that is kept between runs, by the content of what was compiled and not by where its text lies.

numba keeps the code of a function beside its file: another folder, environment or installation compiles the same text
again. Here it is kept in the one folder of this package's cache, under a stamp of its sources; numba itself adds
signature, processor and its own version. A function whose file is gone, or was never there, can be kept as well.

numba's files are pickles, which can do anything when they are read. So they lie in a folder of this user alone, each
under a seal of that folder; what has another seal is not looked into, but compiled again and replaced.
"""

from __future__ import annotations

import glob
import hashlib
import os
import pickle
import re
from collections.abc import Callable
from functools import cached_property
from pathlib import Path
from typing import Any

from numba.core import sigutils
from numba.core.caching import CompileResultCacheImpl, FunctionCache, IndexDataCacheFile, NullCache, _CacheLocator
from numba.core.ccallback import CFunc

from gyroctl.cache import cache_folder, private_folder, sealed, unsealed

FOLDER, OURS = "machine-code", "gyroctl"

VERSIONS = 24
"""Stamps of one function that stay: who changes a source and changes it back finds the code again."""

STAMP = re.compile("[_-][0-9a-f]{16}")
"""In the name of a file, behind that of the function."""

UNREADABLE = (OSError, EOFError, pickle.UnpicklingError, AttributeError, ImportError, IndexError, ValueError)
"""What a file gives that was cut short, or written by something else."""


def folder() -> Path | None:
    """A folder of our own in $NUMBA_CACHE_DIR, or in this package's cache; None where nothing can be kept.

    What is named there is other projects' as well, and may be shared: it is neither closed nor cleared.
    """
    wanted = os.environ.get("NUMBA_CACHE_DIR")
    if wanted:
        return private_folder(Path(wanted) / OURS)
    cache = cache_folder()
    return private_folder(cache / FOLDER) if cache else None


def kept(name: str) -> bool:
    """Whether there is code of a function, ``file.function``, in any version."""
    place = folder()
    return place is not None and any(place.glob(f"{name}*.nbi"))


class _Locator(_CacheLocator):  # type: ignore[misc]
    """Where numba puts the code of a function whose attribute ``kept_under`` is its stamp."""

    def __init__(self, stamp: str, file: str) -> None:
        self.stamp, self._py_file = stamp, file  # numba names the file where it warns

    def get_cache_path(self) -> str:
        place = folder()
        if place is None:
            raise OSError("there is no folder to keep machine code in")
        return str(place)

    def get_source_stamp(self) -> str:
        return self.stamp

    def get_disambiguator(self) -> str:
        return self.stamp[:16]

    @classmethod
    def from_function(cls, py_func: Any, py_file: str) -> _Locator:
        return cls(py_func.kept_under, py_file)


class _Entry(CompileResultCacheImpl):  # type: ignore[misc]
    _locator_classes = [_Locator]  # noqa: RUF012 - as numba has it


class _Index(IndexDataCacheFile):  # type: ignore[misc]
    """Which file holds the code of which signature, each under a name of its own, and all of them under seals.

    numba numbers them by what its index knows: two processes that compile two signatures at the same time would take
    the same number, and each of them the other's code.
    """

    def save(self, key: Any, data: Any) -> None:
        name = f"{Path(self._index_name).stem}.{hashlib.sha256(repr(key).encode()).hexdigest()[:16]}.nbc"
        self._save_data(name, data)
        self._save_index({**self._load_index(), key: name})

    def _load_index(self) -> dict[Any, str]:
        try:
            version, stamp, names = self._load_data(self._index_name)
        except UNREADABLE:  # or not there: it is written anew
            return {}
        return names if (version, stamp) == (self._version, self._source_stamp) else {}

    def _save_index(self, overloads: dict[Any, str]) -> None:
        self._save_data(self._index_name, (self._version, self._source_stamp, overloads))

    def _load_data(self, name: str) -> Any:
        path = Path(self._data_path(name))
        return pickle.loads(unsealed(path.parent, name, path.read_bytes()))

    def _save_data(self, name: str, data: Any) -> None:
        path = Path(self._data_path(name))
        with self._open_for_write(path) as file:
            file.write(sealed(path.parent, name, self._dump(data)))


class _Files(FunctionCache):  # type: ignore[misc]
    _impl_class = _Entry

    def __init__(self, function: Any) -> None:
        super().__init__(function)
        self._cache_file = _Index(self.cache_path, self._impl.filename_base, self._impl.locator.stamp)


class _Kept(NullCache):  # type: ignore[misc]
    """numba's cache of a function, opened when it is first asked: an import touches no file."""

    def __init__(self, function: Any, stamp: Callable[[], str]) -> None:
        self.function, self._told = function, stamp

    @cached_property
    def stamp(self) -> str:
        return self._told()

    @cached_property
    def files(self) -> Any:
        self.function.kept_under = self.stamp
        return _Files(self.function)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        try:
            return self.files.load_overload(sig, target_context)
        except UNREADABLE:
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        try:
            self.files.save_overload(sig, data)
            _forget(self.files._impl.filename_base)
        except UNREADABLE:
            pass  # to keep it is a comfort: a full disk is no reason not to compute


def keep(compiled: Any, stamp: Callable[[], str]) -> Any:
    """Let a function of numba keep its code under a stamp of all that is compiled into it; returns that function."""
    function = compiled.__wrapped__ if isinstance(compiled, CFunc) else compiled.py_func
    compiled._cache = _Kept(function, stamp)
    return compiled


def kept_callback(function: Any, signature: Any, stamp: str, **options: Any) -> Any:
    """Compile a function of one signature to a function pointer as `numba.cfunc` does, or find it under its stamp."""
    callback = keep(CFunc(function, sigutils.normalize_signature(signature), locals={}, options=options), lambda: stamp)
    callback.compile()
    return callback


def _forget(base: str) -> None:
    """Remove the oldest versions of a function's code, given the name of one of them."""
    place = folder()
    if place is None:
        return
    name = glob.escape(STAMP.split(base)[0])
    indices = sorted(place.glob(f"{name}[_-]*.nbi"), key=lambda path: path.stat().st_mtime, reverse=True)
    for index in indices[VERSIONS:]:
        for path in (index, *place.glob(f"{glob.escape(index.stem)}.*.nbc")):
            path.unlink(missing_ok=True)
