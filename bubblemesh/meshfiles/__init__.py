"""Mesh files, report and pictures."""

from bubblemesh.meshfiles.formats import FORMATS, formats_by_ending, require_order
from bubblemesh.meshfiles.history import HISTORY_FILES, history_tables
from bubblemesh.meshfiles.names import LABELS_FILE
from bubblemesh.meshfiles.report_json import dump, plain
from bubblemesh.meshfiles.writing import PAGE_FILE, file_names, write_file, write_files, write_stream

__all__ = [
    "FORMATS",
    "HISTORY_FILES",
    "LABELS_FILE",
    "PAGE_FILE",
    "dump",
    "file_names",
    "formats_by_ending",
    "history_tables",
    "plain",
    "require_order",
    "write_file",
    "write_files",
    "write_stream",
]
