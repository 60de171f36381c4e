#!/usr/bin/env bash
# Install seoro from the wheel WHEEL, a path or a URL, with the extras EXTRAS.
set -euo pipefail

[ -n "${WHEEL:-}" ] || { echo "error: WHEEL is empty; expected the path or URL of the wheel of seoro" >&2; exit 2; }
case $WHEEL in
    *://*) url=$WHEEL ;;
    *)
        [ -f "$WHEEL" ] || { echo "error: file not found: $WHEEL (input \`wheel\`)" >&2; exit 2; }
        url="file://$(realpath "$WHEEL")"
        ;;
esac
python -m pip install --quiet --disable-pip-version-check "seoro[${EXTRAS:-mujoco,test}] @ $url"
