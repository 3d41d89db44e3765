"""gyroctl: semi-active control, lock and stability margins of a gyroscopic wave energy converter.

The flow: sea -> waves -> plant -> law -> trajectory -> metrics -> report. The public names stand in ``__init__.pyi``,
and are loaded when they are first used.
"""

import os

import lazy_loader

from gyroctl.version import VERSION

__version__ = VERSION

if not os.path.isdir(os.path.join(os.path.dirname(__file__), "controllers")):
    # a checkout without symbolic links: laws and studies are found in the folder above
    __path__.append(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
