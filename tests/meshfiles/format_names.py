"""Names of formats that tests go through."""

from bubblemesh.meshfiles.formats import FORMATS

# Those that share an ending with an earlier one cannot stand beside it.
ALL = tuple(name for name, form in FORMATS.items() if name == form.files[0][1:])  # one for each ending
IN_SLICES = [name for name, form in FORMATS.items() if form.slices is not None]
