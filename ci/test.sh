#!/usr/bin/env bash
# Check and run the scenarios of PATHS, or of the project; only part SHARD, such as 2/5. Results go to RESULTS.
set -euo pipefail

read -ra paths <<<"${PATHS:-}"
options=(--junit "${RESULTS:-results.xml}" --output-format "${FORMAT:-text}")
[ -z "${SHARD:-}" ] || options+=(--shard "$SHARD")
seoro check --output-format "${FORMAT:-text}" "${paths[@]:-.}"
seoro test "${options[@]}" "${paths[@]}"
