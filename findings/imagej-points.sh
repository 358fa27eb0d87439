#!/usr/bin/env bash
# Guess: ImageJ counts from the corner of the picture (its manual, and centroids of areas), so a click
#   in the middle of pixel 7, 5 is 7.5, 5.5 and half a pixel must be taken off its Results.
# What happens: the Results table says 7.000, 5.000 for a point and 7.500, 5.500 for an area of that
#   one pixel, in one table.
# Why it matters: landmarks from ImageJ lie half a pixel off if an editor "corrects" them.
# ImageJ of Debian (12: 1.53t, 13: 1.54g); 28 November 2026. Needs root for apt-get, or ImageJ, a Java
# runtime and Xvfb.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
jar=/usr/share/java/ij.jar
test -e $jar || apt-get install -y -q --no-install-recommends imagej default-jre xvfb xauth >/dev/null
cat >"$work/macro.ijm" <<MACRO
newImage("t", "8-bit black", 40, 30, 1);
setPixel(7, 5, 255);
run("Set Measurements...", "mean centroid redirect=None decimal=3");
makePoint(7, 5);
run("Measure");
makeRectangle(7, 5, 1, 1);
run("Measure");
saveAs("Results", "$work/results.csv");
run("Quit");
MACRO
timeout 100 xvfb-run -a java -jar $jar -macro "$work/macro.ijm" >"$work/log" 2>&1 || true
cat "$work/results.csv"
grep -q "^1,255.*,7.000,5.000$" "$work/results.csv"
grep -q "^2,255.*,7.500,5.500$" "$work/results.csv"
