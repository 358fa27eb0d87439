#!/usr/bin/env bash
# Guess: darktable's filter "module order: all images", with which a new user starts, shows all images.
# What happens: it shows only photos that were never edited or exported. With the first edit or export
#   a photo leaves the lighttable at the next refresh, and results beside it, too. "custom" and then
#   "all images" again brings them back: the first setting is "%", which counts as "none".
# Why it matters: who sends a portrait from darktable to an editor sees neither it nor the result, and
#   buttons of scripts do nothing, because the photo below the pointer isn't in the collection.
# darktable 5.0.1 of Debian 13; 28 November 2026. Needs root for apt-get, or darktable and Xvfb.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
command -v darktable xvfb-run >/dev/null || apt-get install -y -q --no-install-recommends darktable xvfb xauth >/dev/null
mkdir "$work/photos"
{ printf 'P6\n300 200\n255\n'; head -c 180000 /dev/zero | tr '\0' '\170'; } >"$work/photos/a.ppm"
cat >"$work/look.lua" <<LUA
local dt = require "darktable"
dt.films.new("$work/photos")
dt.new_format("jpeg"):write_image(dt.database.import("$work/photos/a.ppm"), "$work/export.jpg")
dt.gui.libs.collect.filter(dt.gui.libs.collect.filter()) -- refreshes the lighttable
local out = io.open("$work/seen", "a")
out:write(#dt.collection, " of ", #dt.database, "\n")
out:close()
os.exit(0)
LUA
timeout 300 xvfb-run -a darktable --configdir "$work/config" --cachedir "$work/cache" \
  --library :memory: --disable-opencl -d sql --luacmd "dofile('$work/look.lua')" >"$work/log" 2>&1 || true
printf 'photos in the lighttable after an export: '
cat "$work/seen"
clause="id NOT IN (SELECT imgid FROM main.module_order)" # the query for "none"
printf 'queries with "%s": ' "$clause"
grep -c "$clause" "$work/log"
test "$(cat "$work/seen")" = "0 of 1"
