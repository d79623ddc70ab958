"""Mesh files, report and pictures."""

from bubblemesh.output.formats import FORMATS
from bubblemesh.output.history import HISTORY_FILES, history_tables
from bubblemesh.output.report import dump, plain
from bubblemesh.output.writing import file_names, write_file, write_files, write_stream

__all__ = [
    "FORMATS",
    "HISTORY_FILES",
    "dump",
    "file_names",
    "history_tables",
    "plain",
    "write_file",
    "write_files",
    "write_stream",
]
