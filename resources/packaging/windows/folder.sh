# Functions of .ci/windows: the folder that runs on Windows without Python, its programs, its installer.
# They use that script's `inside`, `embedded`, `own`, `version`, `numbers`, `unpack` and `within`.

gone() { # FOLDER PATTERN...
  local one found
  for one in "${@:2}"; do
    compgen -G "$1/$one" | while read -r found; do rm -r "$found"; done || true
  done
}

# folder WHEELS: Kogao in $inside/Kogao, with Python and with what it needs of these wheels.
folder() {
  local folder=$inside/Kogao one keep
  local runtime=$folder/runtime site=$folder/runtime/site
  rm -rf "$folder"
  mkdir -p "$site" "$folder/licences"
  cp -r "$embedded/." "$runtime/"
  for one in "$1"/*.whl "$own"; do
    case ${one##*/} in
    setuptools-* | wheel-* | packaging-*) ;; # asked for by jpeglib's Python, which is left out
    *) unpack "$one" "$site" ;;
    esac
  done
  for one in "$site"/*.data/{pure,plat}lib; do [ ! -d "$one" ] || cp -r "$one/." "$site/"; done
  rm -rf "$site"/*.data
  # Python: no TLS, no asyncio, no sounds. hashlib has codes of its own.
  gone "$runtime" python.exe pythonw.exe 'python*._pth' python.cat '_ssl.pyd' 'libssl*' 'libcrypto*' \
    _hashlib.pyd winsound.pyd _overlapped.pyd _asyncio.pyd
  gone "$site" '*.dist-info/RECORD' 'click/*.pyi'
  find "$site" \( -name '*.pyi' -o -name '*.lib' -o -name '*.pdb' -o -name '*.exp' -o -name '*.h' \
    -o -name '*.pxd' -o -name '*.pyx' -o -name py.typed \) -not -path '*/kogao_*' -delete
  gone "$site" numpy/f2py numpy/_pyinstaller numpy/tests 'numpy/*/tests' numpy/doc numpy/distutils
  gone "$site" cv2/opencv_videoio_ffmpeg\*.dll
  find "$site/cv2/data" -name '*.xml' ! -name haarcascade_frontalface_alt2.xml -delete
  gone "$site" 'PIL/_imagingtk*' 'PIL/ImageTk.py' 'PIL/ImageGrab.py'
  gone "$site" pyqtgraph/examples pyqtgraph/opengl pyqtgraph/jupyter pyqtgraph/icons/peegee
  # jpeglib: one library is called, without its Python.
  find "$site/jpeglib" -type f ! -name 'cjpeglib_turbo210*.pyd' -delete
  find "$site/jpeglib" -type d -empty -delete
  # Qt: three modules and SVG; no QML, no tools, no OpenGL, no network.
  keep='__init__.py|_config.py|_git_pyside_version.py|Qt(Core|Gui|Widgets|Svg)\.pyd|Qt6(Core|Gui|Widgets|Svg)\.dll|pyside6\.abi3\.dll|msvcp140(_1|_2)?\.dll|vcruntime140(_1)?\.dll|icu.*\.dll|plugins|translations|support'
  find "$site/PySide6" -mindepth 1 -maxdepth 1 -regextype posix-extended ! -regex ".*/($keep)" -exec rm -r {} +
  find "$site/PySide6/translations" -type f ! -name '*_ja.qm' ! -name '*_en.qm' -delete
  gone "$site/PySide6/plugins" designer generic networkinformation platforminputcontexts qmltooling sqldrivers tls \
    imageformats/qpdf.dll 'platforms/qdirect2d.dll' 'platforms/qminimal.dll' 'imageformats/q[gtw]*.dll' imageformats/qicns.dll
  gone "$site" 'shiboken6/vc[ac]*' shiboken6/vcomp140.dll shiboken6/concrt140.dll shiboken6/msvcp140_codecvt_ids.dll
  # One copy of Microsoft's libraries, where all find it: the launcher adds the folder.
  cp -n "$site"/shiboken6/msvcp140*.dll "$runtime/"
  for one in "$site"/{shiboken6,PySide6}; do gone "$one" 'msvcp140*.dll' 'vcruntime140*.dll'; done
  cp LICENSE "$folder/licences/Kogao.txt"
  mv "$runtime/LICENSE.txt" "$folder/licences/Python.txt"
  cp resources/packaging/windows/licences.md "$folder/licences/README.md"
  for one in LGPL-2.1 LGPL-3 GPL-3; do cp "$system/usr/share/common-licenses/$one" "$folder/licences/$one.txt"; done
  printf '%s\n' python313.zip . site >"$runtime/python313._pth"
  { echo 'import sys; sys.frozen = True'; cat resources/packaging/start.py; } >"$runtime/start.py"
}

programs() {
  cp resources/packaging/windows/{launcher.c,kogao.rc,kogao.nsi} "$inside/"
  sed "s/@NUMBERS@/$numbers/" resources/packaging/windows/kogao.manifest >"$inside/kogao.manifest"
  cp resources/desktop/org.kogao.Kogao.svg "$inside/icon.svg"
  within "
  for size in 16 20 24 32 40 48 64 128 256; do rsvg-convert -w \$size -h \$size icon.svg -o icon-\$size.png; done
  icotool -c -o kogao.ico icon-16.png icon-20.png icon-24.png icon-32.png icon-40.png icon-48.png icon-64.png \
    icon-128.png --raw=icon-256.png
  one() {
    x86_64-w64-mingw32-windres -DNAME=\"\\\\\\\"\$1\\\\\\\"\" -DTITLE=\"\\\\\\\"\$2\\\\\\\"\" -DNUMBERS=${numbers//./,} \
      -DVERSION=\"\\\\\\\"$version\\\\\\\"\" kogao.rc -O coff -o \$1.res
    x86_64-w64-mingw32-gcc -municode -Os -s -Wall -Werror \$3 launcher.c \$1.res -o Kogao/\$1.exe
  }
  one kogao 'Kogao' -mwindows
  one kogao-cli 'Kogao, command line' -mconsole
  one kogao-edit 'Kogao, edit a photo in place' '-mwindows -DEDIT'
  "
}

# Bytecode by the same Python. It isn't tied to times, which archives and installers change.
bytecode() {
  rm -rf "$inside/compiler"
  cp -r "$embedded" "$inside/compiler"
  rm "$inside"/compiler/*._pth
  within "wine compiler/python.exe -m compileall -qq -j 1 --invalidation-mode unchecked-hash \
    -s Kogao/runtime/site Kogao/runtime/site" || true # tests of other packages
}

# packed FOLDER [FAST]: zip and installer of $inside/Kogao.
packed() {
  local name=kogao-$version-windows-x64
  rm -f "$inside"/kogao-*.zip "$inside"/kogao-*.exe
  within "zip -q -9 -r $name.zip Kogao
    makensis -V2 ${2:+-DFAST} -DVERSION=$version -DNUMBERS=$numbers -DFOLDER=Kogao -DICON=kogao.ico \
      -DOUT=$name-setup.exe kogao.nsi"
  mkdir -p "$1"
  cp "$inside/$name.zip" "$inside/$name-setup.exe" "$1/"
  du -sb "$inside/Kogao" "$1/$name.zip" "$1/$name-setup.exe"
}
