"""Files of users: opened, confined to a folder, copied, locked; temporary folders; and names that files can hold."""

from bubblemesh.files.confinement import confined_to, is_confined
from bubblemesh.files.copies import has_copies, local_copies, local_copy
from bubblemesh.files.names import (
    FORBIDDEN,
    LARGEST_ID,
    LONGEST_FILE_NAME,
    LONGEST_NAME,
    bytes_of_name,
    is_writable,
    require_name,
    with_home,
)
from bubblemesh.files.opening import (
    CASE_FILE,
    beside,
    case_text,
    content_of,
    opened,
    read_bytes,
    read_text,
    require_readable,
    sync,
)
from bubblemesh.files.reasons import (
    UnwrittenError,
    no_place,
    outer_cause,
    reason,
    unreadable,
    unwritten,
)
from bubblemesh.files.temporary import OWNER, locked, temporary_folder

__all__ = [
    "CASE_FILE",
    "FORBIDDEN",
    "LARGEST_ID",
    "LONGEST_FILE_NAME",
    "LONGEST_NAME",
    "OWNER",
    "UnwrittenError",
    "beside",
    "bytes_of_name",
    "case_text",
    "confined_to",
    "content_of",
    "has_copies",
    "is_confined",
    "is_writable",
    "local_copies",
    "local_copy",
    "locked",
    "no_place",
    "opened",
    "outer_cause",
    "read_bytes",
    "read_text",
    "reason",
    "require_name",
    "require_readable",
    "sync",
    "temporary_folder",
    "unreadable",
    "unwritten",
    "with_home",
]
