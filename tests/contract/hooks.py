"""Bodies that schemathesis can't invent: pictures, archives, artifacts; and none that no client can send."""

import os
from pathlib import Path

import schemathesis
from hypothesis import strategies

import pictures

numbers = strategies.integers(min_value=0, max_value=5)
png = numbers.map(pictures.scene)
PICTURES = {
    "image/png": png,
    # The bytes decide the format, so that any declared one will do.
    "image/jpeg": png,
    "image/x-portable-graymap": numbers.map(lambda number: pictures.map_of(number, colour=False)),
    "image/x-portable-pixmap": numbers.map(lambda number: pictures.map_of(number, colour=True)),
}
for media_type, strategy in PICTURES.items():
    schemathesis.openapi.media_type(media_type, strategy)
# File parts of forms.
schemathesis.openapi.format("binary", png)
schemathesis.openapi.media_type("application/x-tar", strategies.lists(numbers, max_size=3).map(pictures.archive))
schemathesis.openapi.media_type(
    "application/octet-stream", strategies.just(Path(os.environ["CONTRACT_ARTIFACT"]).read_bytes())
)


@schemathesis.serializer(*PICTURES)
def picture(context, value):
    """Bytes are sent as they are."""
    return value


@schemathesis.hook
def map_case(context, case):
    """Names of parts in printable ASCII: the others must be escaped in a form (RFC 7578, 5.1), which isn't done."""
    if case.meta.generation.mode.is_negative:
        return case
    if case.media_type == "multipart/form-data" and isinstance(case.body, dict):
        case.body = {name: part for name, part in case.body.items() if name.isascii() and name.isprintable() and name}
    return case
