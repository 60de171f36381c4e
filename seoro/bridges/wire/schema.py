"""JSON Schema of the protocol of nodes, generated from its messages.

`protocol.schema.json` beside this file is its text; `make goldens` writes it.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from pydantic.json_schema import models_json_schema

from seoro.bridges import wire

FILE = "protocol.schema.json"


def protocol_schema() -> dict[str, Any]:
    """Return the schema: all messages in `$defs`, and for each verb its request, reply, role and limits.

    Strings with the format `binary` are `bin` in msgpack. Sizes are in bytes.
    """
    verbs = wire.NODE_VERBS.values()
    messages = {model for verb in verbs for model in (verb.request, verb.reply)} | {wire.Refusal}
    ordered = sorted(messages, key=lambda model: model.__name__)
    references, schema = models_json_schema(
        [(model, "validation") for model in ordered], title=f"Nodes of seoro, protocol {wire.MAJOR}"
    )
    named = {model: reference for (model, _), reference in references.items()}
    described = {
        verb.name: {
            "request": named[verb.request],
            "reply": named[verb.reply],
            "role": verb.role.value,
            "maxRequestSize": verb.limits.size,
            "maxReplySize": verb.reply_limits.size,
        }
        for verb in sorted(verbs, key=lambda verb: verb.name)
    }
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "keys": {
            "request": wire.node_command("namespace", "node", "verb"),
            "liveliness": wire.node_token("namespace", "node", "start"),
        },
        "refusal": named[wire.Refusal],
        "verbs": described,
        **schema,
    }


def schema_text() -> str:
    """Return the schema as the text of the file."""
    return json.dumps(protocol_schema(), indent=1) + "\n"


if __name__ == "__main__":
    Path(__file__).with_name(FILE).write_text(schema_text(), encoding="utf-8")
