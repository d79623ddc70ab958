"""Write the table of keys in methods.md from the schemes, where they are described: python docs/make_methods.py."""

from pathlib import Path

from bubblemesh.packing.configure import all_options, options
from bubblemesh.packing.methods import METHODS

PAGE = Path(__file__).with_name("methods.md")


def made(text: str) -> str:
    """The page's text with its table made anew."""
    lines = text.splitlines()
    rows = [number for number, line in enumerate(lines) if line.startswith("|")]
    return "\n".join([*lines[: rows[0]], *table(), *lines[rows[-1] + 1 :], ""])


def table() -> list[str]:
    """Lines of the table: each key, its value in each method that uses it, and what it means."""
    values = {name: options(method) for name, method in METHODS.items()}
    rows = [["key", *METHODS, "meaning"], ["---"] * (len(METHODS) + 2)]
    for option in all_options():
        shown = (str(value[option.section].get(option.key, "")) for value in values.values())
        rows.append([f"`{option.section}.{option.key}`", *shown, option.meaning])
    return [f"| {' | '.join(row)} |" for row in rows]


if __name__ == "__main__":
    PAGE.write_text(made(PAGE.read_text()))
