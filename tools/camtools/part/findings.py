"""Turn pydantic's findings into one line each: file, dotted field, value, problem, remedy.

>>> remedy_for("missing", {})
'add it'
>>> remedy_for("less_than_equal", {"le": 6.25})
'give at most 6.25'
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from camtools.base.errors import InputError, one_line

_PROBLEMS = {
    "missing": "is missing",
    "extra_forbidden": "unknown key",
    "string_pattern_mismatch": "not a usable name",
}
_REMEDIES = {
    "missing": "add it",
    "extra_forbidden": "remove it or correct its spelling; tools/docs/PARTFILE.md lists every key",
    "finite_number": "give a finite number",
    "float_type": "give a number without quotes",
    "string_type": 'give text in "quotes"',
    "list_type": "give a list: [value, value]",
    "model_type": "give a table: [name] on a line of its own",
    "model_attributes_type": "give a table: [name] on a line of its own",
    "greater_than_equal": "give at least {ge}",
    "greater_than": "give more than {gt}",
    "less_than_equal": "give at most {le}",
    "too_short": "give at least {min_length} entries",
    "too_long": "give at most {max_length} entries",
    "string_too_short": "give at least {min_length} characters",
    "string_too_long": "give at most {max_length} characters",
    "string_pattern_mismatch": "use 1 to 31 letters, digits, _ and -, a letter or digit first",
    "literal_error": "use one of: {expected}",
}


def remedy_for(kind: str, context: Mapping[str, Any]) -> str:
    """Return what the user can do about a pydantic error of this kind."""
    if "remedy" in context:
        return str(context["remedy"])
    return _REMEDIES.get(kind, "see tools/docs/PARTFILE.md").format_map(context)


def describe(file: str, finding: ErrorDetails) -> str:
    """Return one finding as one line."""
    context = finding.get("ctx", {})
    path = [str(step) for step in finding["loc"]] + [context.get("field", "")]
    shown = (step for step in path if step and not step.startswith("("))  # not a union's member
    field = one_line(".".join(shown))
    value = None if finding["type"] == "missing" else context.get("value", finding["input"])
    problem = _PROBLEMS.get(finding["type"], finding["msg"])
    return str(InputError(file, field, value, problem, remedy_for(finding["type"], context)))


def describe_all(file: str, error: ValidationError) -> list[str]:
    """Return all findings of a validation, one line each, pydantic's order kept.

    Of a part of unknown kind only the kind is reported, because the keys depend on it.
    """
    findings = error.errors(include_url=False)
    of_kind = [finding for finding in findings if finding["loc"] == ("part", "kind")]
    return [describe(file, finding) for finding in of_kind or findings]
