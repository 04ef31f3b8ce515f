#!/bin/sh
# SPDX-License-Identifier: LGPL-2.1-or-later
# resources/setup.sh on machines that it meets: everything there; something missing with apt as
# root, with apt that fails, without apt. apt-get, dpkg-query and id are played by small scripts.
. "${TSOLID_SOURCE_DIR:?}/tests/check.sh"
list=$TSOLID_SOURCE_DIR/resources/packages.txt
tools=$work/tools
mkdir "$tools"
for tool in sh awk sed grep cat dirname tail head gcc locale pkg-config env touch as ld; do
  place=$(command -v "$tool") && ln -s "$place" "$tools/$tool"
done

play() { # name, then the script on stdin
  { echo '#!/bin/sh' && cat; } >"$tools/$1"
  chmod +x "$tools/$1"
}

# run SECTION...: setup_need with the tools above only; output in $work/said.
run() {
  env PATH="$tools" "$tools/sh" -c 'root=$1; shift; . "$root/resources/setup.sh"; setup_need "$@"' \
    - "$TSOLID_SOURCE_DIR" "$@" >"$work/said" 2>&1 </dev/null
}
said() { grep -qF -e "$1" "$work/said"; }
not_said() { ! said "$1"; }

play id <<'END'
echo 0
END
play apt-get <<END
echo "called: \$* frontend=\${DEBIAN_FRONTEND-}"
case " \$* " in *" install "*) touch "$work/installed" ;; esac
END

play dpkg-query <<'END'
echo installed
END
check "everything installed" run build freecad tests
check "apt is left alone" not_said "called:"

play dpkg-query <<'END'
case $* in *ninja-build* | *locales-all*) exit 1 ;; *python3-vtk9*) echo config-files ;; *) echo installed ;; esac
END
check "three packages missing" run build tests
check "exactly these are installed" said "install --no-install-recommends ninja-build python3-vtk9 locales-all"
check "without questions" said "frontend=noninteractive"
check "the lists are fetched first" grep -q "update" "$work/said"
rm -f "$work/installed"
check "only the section asked for" run freecad
check "apt is left alone" test ! -e "$work/installed"

play apt-get <<'END'
exit 100
END
check_fails "apt fails and something is missing" run build
check "names the command" said "command:ninja (Debian package ninja-build)"
check "names nothing that is there" not_said "(Debian package gcc)"

rm "$tools/apt-get"
check_fails "no apt" run build
check "names the command" said "command:cmake (Debian package cmake)"
rm "$tools/dpkg-query"
check_fails "no Debian at all" run build
check "names the command" said "command:cmake (Debian package cmake)"
for tool in cmake ninja; do ln -s "$(command -v $tool)" "$tools/$tool"; done
check "no Debian, but everything is there" run build

play id <<'END'
echo 1000
END
play dpkg-query <<'END'
exit 1
END
play apt-get <<'END'
echo "called as a user"
END
rm "$tools/cmake"
check_fails "no root and no sudo" run build
check "apt is left alone" not_said "called"
play sudo <<'END'
[ "$1" = -n ] && shift && echo "sudo: $1" && exec "$@"
END
check "with sudo" run build
check "apt through sudo" said "sudo: apt-get"

# The list itself: packages once, sections known, uses of known kinds.
sed 's/#.*//' "$list" | awk 'NF && !/^\[/ {print $1}' | sort >"$work/packages"
check "more than ten packages" test "$(wc -l <"$work/packages")" -gt 10
check "each once" test -z "$(uniq -d "$work/packages")"
check "sections" test "$(grep '^\[' "$list" | tr -d '\n')" = "[build][freecad][tests]"
sed 's/#.*//' "$list" | awk '!/^\[/ {for (i = 2; i <= NF; i++) print $i}' >"$work/uses"
check "kinds" sh -c '! grep -vE "^(command|header|library|python|locale):[^ ]+$" "$1"' - "$work/uses"
check "both commands use the list" grep -q 'setup_need build freecad' \
  "$TSOLID_SOURCE_DIR/tests/run.sh" "$TSOLID_SOURCE_DIR/resources/demo.sh"
check ".ci/run calls tests/run.sh" grep -qx 'exec sh tests/run.sh' "$TSOLID_SOURCE_DIR/.ci/run"
check_done
