"""Pages of runs for the tests."""

from datetime import datetime
from html.parser import HTMLParser

from bubblemesh.pages.report import report_page

CASE = """
name: composite
domain:
  outer: {rectangle: [10, -3, 12, -2], labels: [bottom, right, top, left]}
  region: matrix
  regions: [{name: fibre, ring: {circle: {center: [11.4, -2.5], radius: 0.2}}, spacing: 0.06}]
  holes: [{circle: {center: [10.5, -2.5], radius: 0.2}, label: hole}]
  points: [{at: [10.9, -2.8], label: well}]
spacing: 0.1
"""


NASTY = ["</script><script>alert(1)</script>", "a\"b onload='x'", "it's & <b>", "漢字 größe $name", "<!--", "\\u003c"]


WRITTEN = datetime(2024, 3, 7, 16, 5)


FILES = ["composite.msh", "composite.report.json", "composite.html"]


def page_of(result, mesh=None, **changes):
    report = {**result.report, "files": FILES, **changes}
    return report_page(mesh or result.mesh, result.fields, report, result.speeds, WRITTEN)


class Elements(HTMLParser):
    """The elements of a page in their order, and the text of each."""

    def __init__(self, text):
        super().__init__()
        self.found = []
        self.feed(text)

    def handle_starttag(self, name, attributes):
        self.found.append([name, dict(attributes), ""])

    def handle_data(self, data):
        if self.found:
            self.found[-1][2] += data

    def named(self, name, **attributes):
        return [e for e in self.found if e[0] == name and attributes.items() <= e[1].items()]
