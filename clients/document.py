#!/usr/bin/env python3
"""Rewrite the service's OpenAPI document so that generators of clients read it right.

    clients/document.py FROM TO

The contract stays the same. Each rewriting prints how often it applied; one that applies no longer may be deleted.
"""

import json
import sys
from pathlib import Path
from typing import Any

Schema = dict[str, Any]


def one_type_of_body(document: Schema) -> int:
    """What may be sent as it is or as a form is sent as it is; a picture of whatever type as bytes: the service looks.

    Generators choose badly between several types of body, or send the form without its boundary.
    """
    count = 0
    for item in document["paths"].values():
        for operation in item.values():
            content = operation.get("requestBody", {}).get("content", {})
            raw = "image/png" if "image/png" in content else "application/x-tar"
            if len(content) > 1 and raw in content:
                name = "application/octet-stream" if raw == "image/png" else raw
                operation["requestBody"]["content"] = {name: content[raw]}
                count += 1
    return count


def one_type_one_name(document: Schema) -> int:
    """The items of a list are referred to where they stand spelt out, so that `list` and `get` give one type."""
    schemas = document["components"]["schemas"]
    names = {json.dumps(schema, sort_keys=True): name for name, schema in schemas.items()}
    count = 0
    for name, schema in schemas.items():
        if not name.startswith("Page_"):
            continue
        items = schema["properties"]["items"]
        known = names.get(json.dumps(items["items"], sort_keys=True))
        if known is not None:
            items["items"] = {"$ref": f"#/components/schemas/{known}"}
            count += 1
    return count


def choices_outside(document: Schema) -> int:
    """An `allOf` over a `oneOf` becomes a `oneOf`: generators can't merge fields with a choice of fields."""
    schemas = document["components"]["schemas"]
    count = 0
    # One may be made of another: until nothing changes.
    for _ in range(len(schemas)):
        changed = False
        # From the end: TimingsBody comes before RecognitionBody, which holds it.
        for name, schema in reversed(list(schemas.items())):
            parts = schema.get("allOf", [])
            for place, part in enumerate(parts):
                choice = schemas.get(part.get("$ref", "").rpartition("/")[2], part)
                if "oneOf" not in choice:
                    continue
                others = parts[:place] + parts[place + 1 :]
                alternatives = []
                for alternative in choice["oneOf"]:
                    kind = kind_of(alternative["$ref"])
                    merged = f"{kind}{name}"
                    schemas[merged] = {
                        "description": schema.get("description", ""),
                        "allOf": [alternative, *(with_kind(other, kind, schemas) for other in others)],
                    }
                    alternatives.append({"$ref": f"#/components/schemas/{merged}"})
                del schema["allOf"]
                schema["oneOf"] = alternatives
                count += 1
                changed = True
                break
        if not changed:
            break
    return count


def kind_of(reference: str) -> str:
    """`Landmark` or `Object`, by the name of the schema that holds what is of that kind alone."""
    name = reference.rpartition("/")[2]
    return next(kind for kind in ("Landmark", "Object") if name.startswith(kind))


def with_kind(schema: Schema, kind: str, schemas: Schema) -> Schema:
    """Fields that go with every kind, for one of the kinds: their `kind` is its word, their timings are its own."""
    if "properties" not in schema:
        return schema
    properties = dict(schema["properties"])
    if "kind" in properties:
        properties["kind"] = {"type": "string", "enum": [f"{kind.lower()}s"]}
    timings = properties.get("timings_ms", {}).get("$ref", "")
    merged = f"{kind}{timings.rpartition('/')[2]}"
    if timings and merged in schemas:
        properties["timings_ms"] = {"$ref": f"#/components/schemas/{merged}"}
    return {**schema, "properties": properties}


def robot_headers(document: Schema) -> int:
    """`X-Robot-Id`, `X-Frame-Id` and `X-Stamp` go with every call that takes a picture."""
    count = 0
    for path, item in document["paths"].items():
        operation = item.get("post", {})
        takes = operation.get("requestBody", {}).get("content", {})
        # Pictures for a calibration are no robot's.
        pictures = "multipart/form-data" in takes and not path.startswith("/v1/calibrations")
        parameters = operation.get("parameters", [])
        if not pictures or any(parameter["name"] == "X-Robot-Id" for parameter in parameters):
            continue
        for name, what in ROBOT_HEADERS.items():
            parameters.append({"name": name, "in": "header", "description": what, "schema": {"type": "string"}})
        operation["parameters"] = parameters
        count += 1
    return count


ROBOT_HEADERS = {
    "X-Robot-Id": "Who sends it; comes back in `header`.",
    "X-Frame-Id": "The robot's name for the frame; comes back in `header`.",
    "X-Stamp": "When it was taken, RFC 3339 or `sec.nanosec`; comes back in `header`.",
}
REWRITINGS = (
    robot_headers,
    one_type_of_body,
    one_type_one_name,
    choices_outside,
)


def main() -> None:
    """Read, rewrite, write."""
    source, target = map(Path, sys.argv[1:])
    document = json.loads(source.read_text(encoding="utf-8"))
    for rewrite in REWRITINGS:
        print(f"{rewrite.__name__}: {rewrite(document)}", file=sys.stderr)
    target.write_text(json.dumps(document, indent=1, ensure_ascii=False), encoding="utf-8")


if __name__ == "__main__":
    main()
