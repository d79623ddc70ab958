"""What regions given by points leave of a domain: the parts between lines and rings that no point names."""

import numpy as np
import shapely

from bubblemesh.arrays import Booleans
from bubblemesh.geometry.arrangement.open_ends import OpenEnds
from bubblemesh.geometry.arrangement.regions import RestPart, RestParts
from bubblemesh.geometry.arrangement.walks import EnclosedFaces
from bubblemesh.geometry.boundary import Boundary
from bubblemesh.geometry.paths import Point

MOST_PLACES = 4  # parts with a place: to look for one takes as long as the boundary is


def rest_between(faces: EnclosedFaces, boundary: Boundary, within: Booleans) -> RestParts:
    """The faces with region 0 on sides (2 p,) of the pieces of a boundary that are ``within`` the domain."""
    region = np.concatenate([boundary.left, boundary.right])
    face = np.unique(faces.of_all_sides.ravel()[within & (region == 0)])
    bounding = faces.face >= 0
    areas = np.bincount(faces.face[bounding], faces.areas[bounding], len(faces.areas))
    face = face[np.argsort(-areas[face], kind="stable")]
    told = face if len(face) <= MOST_PLACES else np.append(face[: MOST_PLACES - 1], face[-1])
    return RestParts(len(face), tuple(RestPart(_place_in(faces, one), float(areas[one])) for one in told.tolist()))


def _place_in(faces: EnclosedFaces, face: int) -> Point:
    """A place in a face, away from its corners."""
    left, right = faces.beside == face
    chords = faces.boundary.chords()
    around = (left != right)[chords.piece]
    lines = shapely.linestrings(np.stack([chords.start[around], chords.end[around]], axis=1))
    net = shapely.geometrycollections(lines)
    area = shapely.build_area(net)
    place = shapely.point_on_surface(net if area.is_empty else area)  # of curves that touch chords may cross
    return place.x, place.y


def nothing_left(name: str, ends: OpenEnds) -> str:
    """Note on a region, named by the case, of which the points of other regions leave nothing: a line may be open."""
    advice = ends.advice(np.ones(len(ends.places), bool)) or "draw the lines that part it from the others"
    return (
        f"nothing is left of region {name!r} beside the regions that points name: {advice}; if that is meant, leave "
        "region out"
    )
