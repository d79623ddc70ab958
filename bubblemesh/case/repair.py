"""Keys that have rings changed: mended where they bound no area, without small parts, or with fewer vertices."""

from typing import Annotated

from pydantic import BaseModel, Discriminator, Field, Tag

from bubblemesh.case.fields import Positive, PositiveArea, Strict


class GapKeys(Strict):
    """Keys of the repair of rings."""

    gap: Positive = Field(
        description="Widest gap between ends of lines, between areas, or between holes, that is closed."
    )


RepairValue = Annotated[
    Annotated[bool, Field(strict=True), Tag("<asked>")] | Annotated[GapKeys, Tag("<gap>")],
    Discriminator(lambda value: "<gap>" if isinstance(value, dict | BaseModel) else "<asked>"),
]


class RepairKeys(Strict):
    """Keys by which rings are changed before they are used; files are changed in their own lengths."""

    repair: RepairValue = Field(
        default=False,
        description="Mend rings that cross or touch themselves or each other, overlapping areas, and gaps up to 1e-4 "
        "of the size, or up to another width: {gap: 0.01}.",
    )
    smallest: PositiveArea | None = Field(
        default=None,
        description="Leave out islands and holes of less area than this; among regions of a file they become part of a "
        "neighbour.",
    )
    simplify: Positive | None = Field(
        default=None,
        description="Leave out vertices of straight sides that are no farther than this length from the ring left.",
    )
