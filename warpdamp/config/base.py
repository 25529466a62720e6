"""Base class and common constraints of the configuration's models."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

POSITIVE, NOT_NEGATIVE = Field(gt=0), Field(ge=0)


class Model(BaseModel):
    """A part of the configuration: no unknown keys, no changes, only finite numbers.

    The text behind a field says what it does: in the schema, in editors and in the reference; it is read from the
    source when the schema is asked for.  A model is built when it is first used, mostly as a part of the one above it.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, defer_build=True)
