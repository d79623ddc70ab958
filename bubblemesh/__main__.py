"""``python -m bubblemesh`` is the command ``bubblemesh``."""

from bubblemesh.cli import main

main()
