"""Where each key of a case belongs: a table made from the models."""

from collections.abc import Iterable, Iterator, Sequence
from difflib import get_close_matches
from functools import cache
from typing import Annotated, Any, NamedTuple, get_args, get_origin

from pydantic import BaseModel, Tag

from bubblemesh.messages import closest, either, meant

MOST_SHOWN = 3
ALIKE, VERY_MUCH_ALIKE = 0.8, 0.9  # difflib's ratios from which on a word may be a misspelling of another one

Model = type[BaseModel]
KeyPath = tuple[str, ...]


class Home(NamedTuple):
    """A mapping that may have a key: its path, without indices of lists, and the key that shows its kind."""

    path: KeyPath
    beside: str | None = None

    def __str__(self) -> str:
        where = f"under {'.'.join(self.path)}" if self.path else "at the top level"
        return where if self.beside is None else f"{where}, beside {self.beside}"

    def distance(self, path: KeyPath) -> int:
        """Number of steps up and down from another mapping to this one."""
        shared = next((k for k, (a, b) in enumerate(zip(self.path, path, strict=False)) if a != b), None)
        common = min(len(self.path), len(path)) if shared is None else shared
        return len(self.path) + len(path) - 2 * common


def is_mark(part: str | int) -> bool:
    """Whether a part of a location is a choice's tag or Pydantic's mark of a key, rather than a key of the file."""
    return isinstance(part, str) and (part == "[key]" or (part.startswith("<") and part.endswith(">")))


def key_of(name: str, model: Model) -> str:
    """Key of the file that is a model's field."""
    return model.model_fields[name].alias or name


def models_in(annotation: Any, tag: str | None = None) -> Iterator[tuple[str | None, Model]]:
    """Models in a type, each with the key that shows its kind if it is one of a choice."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield (tag if tag in annotation.model_fields else None), annotation
        return
    if get_origin(annotation) is Annotated:
        tag = next((note.tag[1:-1] for note in get_args(annotation) if isinstance(note, Tag)), tag)
    for part in get_args(annotation):
        yield from models_in(part, tag)


def model_at(model: Model, loc: Sequence[str | int]) -> Model | None:
    """Model of the mapping at a location of Pydantic's errors, if there is one."""
    models = [model]
    for part in loc:
        if is_mark(part):
            # A tag is the key that shows which of several models is meant.
            models = [one for one in models if str(part)[1:-1] in one.model_fields] or models
        elif isinstance(part, str):
            names = [name for name in models[0].model_fields if key_of(name, models[0]) == part] if models else []
            models = [one for name in names for _, one in models_in(models[0].model_fields[name].annotation)]
    return models[0] if models else None


def keys_of(model: Model) -> list[str]:
    """Keys that a mapping may have, its own before those of its bases."""
    own_first = dict.fromkeys(name for base in model.__mro__ for name in vars(base).get("__annotations__", ()))
    return [key_of(name, model) for name in own_first if name in model.model_fields]


@cache
def homes(model: Model) -> dict[str, tuple[Home, ...]]:
    """For each key, all mappings within a model, or the model itself, that may have it; the outermost first.

    Of a model within itself, such as a ring that is made of rings, only the outer one counts.
    """
    found: dict[str, dict[Home, None]] = {}
    level: list[tuple[Home, Model, frozenset[Model]]] = [(Home(()), model, frozenset())]
    while level:
        below = []
        for home, one, above in level:
            for name, field in one.model_fields.items():
                key = key_of(name, one)
                found.setdefault(key, {})[home._replace(beside=None) if key == home.beside else home] = None
                for tag, inner in models_in(field.annotation):
                    if inner not in above | {one}:
                        below.append((Home((*home.path, key), tag), inner, above | {one}))
        level = below
    return {key: tuple(places) for key, places in found.items()}


@cache
def _option_homes(model: Model) -> dict[str, tuple[Home, ...]]:
    """Sections that may have each option of a method, in a case."""
    if not {"packing", "schedule"} <= model.model_fields.keys():
        return {}
    # Imported here since the methods need SciPy, and errors in a case should come at once.
    from bubblemesh.packing.configure import all_options

    found: dict[str, tuple[Home, ...]] = {}
    for option in all_options():
        found[option.key] = (*found.get(option.key, ()), Home((option.section,)))
    return found


class Advice(NamedTuple):
    """Advice on an unknown key, and the missing keys beside it that would be there if it is followed."""

    text: str
    explains: tuple[str, ...] = ()


def advice_on(key: str, loc: Sequence[str | int], model: Model) -> Advice:
    """Advice on an unknown key of the mapping at a location: the key that may be meant, or where this key belongs.

    The same key elsewhere is preferred to a similar key here; a very similar key elsewhere comes last.
    """
    own, path = model_at(model, loc), keys_of_location(loc)
    known = keys_of(own) if own else []
    close = closest(key, known)
    here = [] if close is None else [close]
    alike = [word for word in here if key in word or word in key or get_close_matches(key, [word], cutoff=ALIKE)]
    places = homes(model).get(key) or _option_homes(model).get(key, ())
    if places:
        near = nearest(places, path)
        first = f"did you mean {alike[0]!r}? {key!r}" if alike else "it"
        return Advice(f"{first} belongs {_listed(near, path, model)}", (*alike, *_next_steps(near, path)))
    for word in () if alike else get_close_matches(key, homes(model), n=1, cutoff=VERY_MUCH_ALIKE):
        near = nearest(homes(model)[word], path)
        return Advice(f"did you mean {word!r}? It belongs {_listed(near, path, model)}", _next_steps(near, path))
    return Advice(meant(key, known), tuple(here))


def home_of_no_option(key: str, path: Sequence[str], model: Model) -> str | None:
    """Where a key among the options of a method belongs, if it is not an option but a key of other mappings."""
    places = () if key in _option_homes(model) else homes(model).get(key, ())
    return f"it belongs {_listed(nearest(places, tuple(path)), tuple(path), model)}" if places else None


def nearest(places: Sequence[Home], path: KeyPath) -> list[Home]:
    """The places to which the fewest steps lead from a mapping."""
    least = min(place.distance(path) for place in places)
    return [place for place in places if place.distance(path) == least]


def _next_steps(places: Sequence[Home], path: KeyPath) -> tuple[str, ...]:
    """Keys of a mapping that lead to the places."""
    return tuple(place.path[len(path)] for place in places if place.path[: len(path)] == path and place.path != path)


def _listed(places: Sequence[Home], here: KeyPath, model: Model) -> str:
    """Text with the first places, with the kind of mapping where only some kinds have the key, or there are many."""
    shown = []
    for path in dict.fromkeys(place.path for place in places):
        kinds = {place.beside for row in homes(model).values() for place in row if place.path == path} - {None}
        fitting = [place.beside for place in places if place.path == path]
        named = [kind for kind in fitting if kind is not None]
        if path == here and named:
            return f"beside {either(named)}"
        tells = len(named) == len(fitting) <= MOST_SHOWN and {*named} < kinds
        shown.append(str(Home(path, either(named) if tells else None)))
    return either(shown[:MOST_SHOWN])


def keys_of_location(loc: Sequence[str | int]) -> KeyPath:
    """Keys of a location, without indices of lists and marks."""
    return tuple(part for part in loc if isinstance(part, str) and not is_mark(part))


def strange_keys(keys: Iterable[str], loc: Sequence[str | int], model: Model) -> list[str]:
    """The keys that no kind of mapping at a location has."""
    path, table = keys_of_location(loc), homes(model)
    return [key for key in keys if all(place.path != path for place in table.get(key, ()))]


def homes_below(keys: Sequence[str], loc: Sequence[str | int], model: Model) -> list[str]:
    """Keys of the mapping at a location whose values may have all of the given keys."""
    path, table = keys_of_location(loc), homes(model)
    fitting = [[place.path[-1] for place in table.get(key, ()) if place.path[:-1] == path] for key in keys]
    return [one for one in dict.fromkeys(fitting[0]) if all(one in others for others in fitting)] if fitting else []
