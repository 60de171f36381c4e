"""Client process of an executor, which prints its observations at once as lines of JSON.

python -m tests.chaos.client ENDPOINT EXECUTOR SCENARIO [LAB WAIT]
"""

from __future__ import annotations

import asyncio
import json
import sys

import seoro


def print_record(**known: object) -> None:
    """Print a line for the round."""
    sys.stdout.write(json.dumps(known) + "\n")
    sys.stdout.flush()


async def main(endpoint: str, executor: str, scenario: str, lab: str = "", wait: str = "") -> None:
    """Submit a scenario, and follow the run."""
    options = (
        {} if not lab else {"lab": seoro.Lab(lab), "leasing": seoro.Leasing(wait=float(wait) if wait else None)}
    )
    try:
        async with seoro.Client(endpoint) as client:
            run = await client.submit(executor, scenario, **options)  # type: ignore[arg-type]
            print_record(submitted=run.id)
            verdict = await run.result()
            print_record(verdict=verdict.status.value, reason=verdict.reason)
    except seoro.UsageError as error:
        print_record(invalid=str(error))
    except seoro.SeoroError as error:
        print_record(error=str(error))


if __name__ == "__main__":
    asyncio.run(main(*sys.argv[1:]))
