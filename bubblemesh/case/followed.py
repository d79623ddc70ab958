"""Keys of rings of many short edges that are followed as curves."""

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BaseModel, Field, ValidationInfo, field_validator
from pydantic_core import PydanticCustomError

from bubblemesh.case.fields import Positive
from bubblemesh.errors import GeometryError

if TYPE_CHECKING:
    from bubblemesh.geometry import rings


class Traced(BaseModel):
    """What a ring of straight sides may be followed by."""

    corners: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=180)] | None = Field(
        default=None, description="Only vertices that turn by more degrees are nodes; the rest is spaced anew."
    )
    smooth: bool = Field(default=False, description="With corners: follow a spline through the vertices between them.")
    tolerance: Positive | None = Field(
        default=None, description="With corners: largest distance of the mesh from the ring as given."
    )

    @field_validator("smooth", "tolerance")
    @classmethod
    def _with_corners(cls, value: Any, info: ValidationInfo) -> Any:
        if value and info.data.get("corners", 0.0) is None:
            raise PydanticCustomError("traced", "needs corners: give the angle above which vertices stay nodes")
        return value

    def traced(self, ring: "rings.Ring") -> "rings.Ring":
        """The ring, followed as the keys say.

        Raises
        ------
        GeometryError
            If a spline departs from it by too much; with the file and place that it comes from.
        """
        from bubblemesh.geometry.followed import Following

        if self.corners is None:
            return ring
        try:
            return replace(Following(self.corners, self.smooth, self.tolerance)(ring), origin=ring.origin)
        except GeometryError as error:
            raise GeometryError(f"{ring.origin}: {error}" if ring.origin else str(error)) from None
