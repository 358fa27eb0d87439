# Run by .ci/windows in the Debian 13, with a screen: the installer, a folder in a place with spaces
# and Japanese letters that can't be written, the programs, and what an uninstallation leaves.
set -eu
fail() { echo "FAILED: $1"; exit 1; }
window() { # TITLE: wait until one stands there; sets WINDOW, WIDTH and HEIGHT
  local found
  for _ in $(seq 120); do
    found=$(xdotool search --onlyvisible --name "$1" 2>/dev/null | tail -n 1)
    [ -z "$found" ] || { eval "$(xdotool getwindowgeometry --shell "$found")"; sleep 3; return; }
    sleep 1
  done
  fail "no window '$1'"
}
keys() { window "$1"; xdotool windowfocus --sync "$WINDOW" key "$2"; }
shot() { cp /kogao/screen/Xvfb_screen0 "$shots/$1.xwd"; }
on() { # TITLE NAME: by mouse, the button that leads on, page after page, to the end
  window "$1"
  for page in $(seq 300); do
    [ "$page" -gt 1 ] || shot "$2"
    xdotool mousemove --window "$WINDOW" $((WIDTH - 137)) $((HEIGHT - 21)) click 1 2>/dev/null || return 0
    sleep 2
  done
  fail "'$1' never ends"
}
shots=/kogao/shots
rm -rf $shots && mkdir -p $shots
user=$(wine cmd /c 'echo %USERPROFILE%' | tr -d '\r'); user=$(winepath -u "$user")
home=$user/AppData/Local/Programs/Kogao
classes='HKCU\Software\Classes'
data=$user/AppData/Local/kogao
rm -rf "$data" "$home"

menu="$user/AppData/Roaming/Microsoft/Windows/Start Menu/Programs/Kogao.lnk"
installed() {
  [ -f "$home/kogao.exe" ] || fail "$1"
  [ -f "$menu" ] || fail "start menu"
  wine reg query "$classes\\.jpg\\OpenWithProgids" | grep -q Kogao.Photo || fail "open with"
  wine reg query "$classes\\Kogao.Photo\\shell\\open\\command" | grep -q 'kogao.exe" "%1"' || fail "the command of open with"
}
uninstalled() {
  for _ in $(seq 60); do [ ! -d "$home" ] || sleep 1; done
  [ ! -d "$home" ] || fail "uninstallation left $(ls "$home")"
  [ ! -f "$menu" ] || fail "the start menu is left"
  for key in Kogao.Photo 'Applications\kogao.exe' '.jpg\OpenWithProgids'; do
    ! wine reg query "$classes\\$key" 2>/dev/null | grep -i kogao || fail "the registry keeps $key"
  done
  [ -d "$data/originals" ] || fail "the originals went"
  echo "what stays: $(cd "$data" && ls | tr '\n' ' ')"
}

wine kogao-*-setup.exe /S
installed "silent installation"

place="$WINEPREFIX/drive_c/写真 フォルダ é"
[ ! -e "$place" ] || chmod -R u+w "$place"
rm -rf "$place" && mkdir "$place" && cp -r "$home" "$place/小 顔"
chmod -R a-w "$place/小 顔"
cli() { wine "$place/小 顔/kogao-cli.exe" "$@"; }
cd "$place"
photo="$home/runtime/site/kogao_resources/samples/women.jpg"
cli --version && cli doctor | tail -n 1 || fail "doctor"
cli warp --sample -o 'a 一.jpg' >/dev/null && [ -s 'a 一.jpg' ] || fail "warp"
cp "$photo" '元 é.jpg'
cli warp '元 é.jpg' -o 'b 二.jpg' >said && grep 'of the JPEG unchanged' said || fail "blocks: $(cat said)"
mkdir in && cp "$photo" in/1.jpg && cp "$photo" in/2.jpg
cli batch in -o out --jobs 2 >/dev/null; [ -s out/1.jpg ] && [ -s out/2.jpg ] || fail "batch"
cp "$photo" 'in place é.jpg'
cli warp --in-place 'in place é.jpg' >/dev/null && ! cmp -s "$photo" 'in place é.jpg' || fail "in place"
cli restore 'in place é.jpg' >/dev/null && cmp "$photo" 'in place é.jpg' || fail "restore"
wine "$place/小 顔/kogao.exe" --sample --screenshot window.png && [ -s window.png ] || fail "window"
wine "$place/小 顔/kogao.exe" --sample --language ja --screenshot japanese.png && ! cmp -s window.png japanese.png || fail "Japanese"
cp window.png japanese.png $shots

# What Lightroom and Capture One do: a program without options gets a photo, and gives it back.
cp "$photo" 'edit me é.jpg'
wine "$place/小 顔/kogao-edit.exe" "$(winepath -w "$place/edit me é.jpg")" &
edits=$!
for _ in $(seq 60); do
  kill -0 $edits 2>/dev/null || break
  xdotool search --name 'edit me' windowfocus key ctrl+shift+Return >/dev/null 2>&1 || true
  sleep 2
done
wait $edits || fail "kogao-edit ended with $?"
! cmp -s "$photo" 'edit me é.jpg' || fail "kogao-edit changed nothing"
cli restore 'edit me é.jpg' >/dev/null && cmp "$photo" 'edit me é.jpg' || fail "no original of the edited photo"

[ -z "$(find "$place/小 顔" -newer 'a 一.jpg' -type f)" ] || fail "a file was written into the folder"
[ -z "$(find "$place" -name '.kogao-*')" ] || fail "temporary folders were left"
wine "$home/uninstall.exe" /S
uninstalled

cd /kogao
wine kogao-*-setup.exe &
on 'Kogao Setup' setup
installed "installation by mouse"
window 'Kogao$' # the last page has started it
shot start
keys 'Kogao$' ctrl+o
window '^Open'
shot dialog
keys '^Open' Escape
keys 'Kogao$' ctrl+q
for _ in $(seq 30); do ! wine tasklist | grep -q kogao.exe || sleep 1; done
wine "$home/uninstall.exe" &
on 'Kogao Uninstall' uninstall
uninstalled
chmod -R u+w "$place" && rm -rf "$place" "$data"
echo "folder and installer: all is well"
