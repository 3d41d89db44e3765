"""The numerical example of Zhang et al. (2017): figures 8 to 15, and its statements beside ours.

The paper's captions were not available. Each figure shows what the paper states about the numerical example, with
ensembles and intervals where the paper has one realisation.
"""

from gyroctl.studies.paper.ensembles import Setup
from gyroctl.studies.paper.reproduce import EXTRAS, FIGURES, reproduce

__all__ = ["EXTRAS", "FIGURES", "Setup", "reproduce"]
