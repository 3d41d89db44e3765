"""The version of this package, once."""

VERSION = "0.2.0"
