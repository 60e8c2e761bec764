"""Plants from and to files and libraries; plants made smaller."""

from .build import Content
from .door import (
    from_control,
    from_json,
    from_mat,
    from_scipy,
    load_plant,
    read_content,
    read_plant,
    reduced_to,
    to_control,
    to_json,
    to_mat,
)

__all__ = [
    "Content",
    "from_control",
    "from_json",
    "from_mat",
    "from_scipy",
    "load_plant",
    "read_content",
    "read_plant",
    "reduced_to",
    "to_control",
    "to_json",
    "to_mat",
]
