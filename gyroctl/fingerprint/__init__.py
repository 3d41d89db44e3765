"""What can change a bit of a result: code, libraries, processor, and the values that a run is made of."""

from gyroctl.fingerprint.package import fingerprint, listing
from gyroctl.fingerprint.rests_on import code_of, made_with, text_of

__all__ = ["code_of", "fingerprint", "listing", "made_with", "text_of"]
