#!/bin/sh
# Started by GIMP 2.10: looks for a Python for what lies beside, Kogao's own or else any.
for python in @PYTHON@ python3; do
  command -v "$python" >/dev/null && exec "$python" "$(dirname "$0")/gimp_2_10.py" "$@"
done
echo "Kogao needs a Python 3" >&2
exit 127
