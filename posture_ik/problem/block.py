"""What every block of a problem file has in common."""

from pydantic import BaseModel, ConfigDict


class Block(BaseModel):
    """A block of a problem file: unknown keys are refused, nothing changes after it is read."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)
