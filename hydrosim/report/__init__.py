"""Reports: one HTML file that shows a result, without a network."""

from hydrosim.report.document import replay_of, report_of, run_document
from hydrosim.report.page import written_page
