"""Mesh files, report and pictures."""

from bubblemesh.output.formats import FORMATS
from bubblemesh.output.history import history_tables
from bubblemesh.output.report import dump, plain
from bubblemesh.output.writing import write_file, write_files, write_stream

__all__ = ["FORMATS", "dump", "history_tables", "plain", "write_file", "write_files", "write_stream"]
