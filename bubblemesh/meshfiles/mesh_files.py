"""Where the files of a mesh go: their folder, their names and their formats."""

from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

from bubblemesh.errors import CaseError, FileError
from bubblemesh.files import LONGEST_FILE_NAME, bytes_of_name
from bubblemesh.meshfiles.formats import (
    FORMATS,
    Format,
    FormatName,
    formats_by_ending,
    stem_of,
    unknown_ending,
)
from bubblemesh.messages import shown
from bubblemesh.records import record


@record
class MeshFiles:
    """Folder of the files of a mesh, which is made if it is missing, the stem of their names, and their formats.

    If two formats have the same ending, the files of the second one are NAME.FORMAT.ENDING.
    """

    folder: Path
    name: str
    formats: Sequence[FormatName]
    ending: str | None = None  # of a single mesh file, as the user spells it: NAME.MSH
    lasting: bool = True  # whether the files must survive a power cut; files that are read at once need not

    @classmethod
    def at(cls, path: Path) -> "MeshFiles":
        """The files of a path, in the format of its ending; CaseError for an unknown one."""
        formats = formats_by_ending(path.name)
        if not formats:
            raise unknown_ending(str(path))
        name = stem_of(path.name, formats[0])
        return cls(path.parent, name, formats[:1], path.name.removeprefix(name))

    @property
    def stems(self) -> list[tuple[Format, str]]:
        """Each format with the stem of its files: the name; with that of the format if another one has its ending.

        Of several with one ending the first in the table has the plain name, in whatever order they come: the general
        one.
        """
        last_first = sorted(self.formats, key=[*FORMATS].index, reverse=True)
        plain = {FORMATS[form].files[0]: form for form in last_first}
        return [
            (FORMATS[form], self.name if form in plain.values() else f"{self.name}.{form}") for form in self.formats
        ]

    def file_names(self, parts: int, more: Iterable[str]) -> list[str]:
        """Names of the files of a mesh in so many parts, and of others by the ends of their names.

        CaseError if the name cannot be that of a file, or is too long for one of them.
        """
        meshes = [stem + end for form, stem in self.stems for end in form.ends(parts)]
        meshes[:1] = meshes[:1] if self.ending is None else [self.name + self.ending]
        return _checked(self.name, [*meshes, *(self.name + end for end in more)])

    def require_distinct(self, names: Sequence[str]) -> None:
        """Check that no two files have the same name; FileError if they have."""
        repeated = [name for name, count in Counter(names).items() if count > 1]
        if repeated:
            place = self.folder / repeated[0]
            raise FileError(f"{place}: more than one output would have this name; name each format once")


def _checked(name: str, files: list[str]) -> list[str]:
    """The files of a name; CaseError if it cannot be that of a file, or is too long for one of them."""
    if not name.isprintable() or name in {"", ".", ".."} or "/" in name or "\\" in name:
        raise CaseError(f"{name!r} cannot be the name of a file; use a name without slashes")
    longest = max(files, key=bytes_of_name)
    if bytes_of_name(longest) > LONGEST_FILE_NAME:
        size = f"with {longest.removeprefix(name)} it has {bytes_of_name(longest)} bytes"
        raise CaseError(f"{shown(repr(name))} is too long a name: {size}, files up to {LONGEST_FILE_NAME}: shorten it")
    return files
