"""Edits as JSON, for the journal."""

from typing import Any, get_args

from fcw.json_form import tagged_from_json, tagged_to_json
from fcw_viz.calibrate_app.document.edits import Edit

EDIT_FIELD = "edit"


def edit_to_json(edit: Edit) -> dict[str, Any]:
    """An edit as an object with its name."""
    return tagged_to_json(edit, EDIT_FIELD)


def edit_from_json(value: dict[str, Any]) -> Edit:
    """The edit.

    Raises:
        ValueError: there is no such edit, or its fields are not as expected.
    """
    return tagged_from_json(get_args(Edit), value, EDIT_FIELD)
