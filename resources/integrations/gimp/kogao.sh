#!/bin/sh
# GIMP 2.10 starts this script, which runs the plug-in with Kogao's Python or any other.
for python in @PYTHON@ python3; do
  command -v "$python" >/dev/null && exec "$python" "$(dirname "$0")/gimp_2_10.py" "$@"
done
echo "Kogao needs a Python 3" >&2
exit 127
