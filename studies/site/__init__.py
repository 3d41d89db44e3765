"""A site: a scatter table of sea states, and what a device with each law gives there in a year.

Every run is a work item with its own stored result, so that a study that was stopped goes on where it was, and another
table of the same site computes only the sea states that are new.
"""

from gyroctl.studies.site.read_scatter import read_scatter
from gyroctl.studies.site.report import site_report
from gyroctl.studies.site.request import SiteRequest, site_request
from gyroctl.studies.site.scatter import Bin, Scatter

__all__ = ["Bin", "Scatter", "SiteRequest", "read_scatter", "site_report", "site_request"]
