"""Mesh files, report and pictures."""

from bubblemesh.output.formats import FORMATS
from bubblemesh.output.report import dump, plain
from bubblemesh.output.writing import write_file, write_files, write_stream

__all__ = ["FORMATS", "dump", "plain", "write_file", "write_files", "write_stream"]
