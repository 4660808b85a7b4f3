#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The two programs together, as a user runs them: programs_test.sh GEOND GEON SOURCE_FOLDER
set -euo pipefail
geond=$1 geon=$2 source=$3
folder=$(mktemp -d)
export GEOND_SOCKET=$folder/socket
set_all=(--config "$source/config/geond.toml" --set "api.unix_socket=$GEOND_SOCKET" --set api.port=0 --set http.port=-1
         --set robot.port=-1 --set "store.folder=$folder/store" --set scan.triangles=1200 --set scan.picture=false)
fail() { echo "FAILED: $*" >&2; exit 1; }
start() {
  "$geond" "${set_all[@]}" 2>>"$folder/log" &
  pid=$!
  until "$geon" status >/dev/null 2>&1; do kill -0 $pid || { cat "$folder/log"; fail "geond did not start"; }; done
}
trap 'kill -9 $pid 2>/dev/null || true; rm -rf "$folder"' EXIT

"$geond" "${set_all[@]}" --check >/dev/null || fail "--check"
"$geond" "${set_all[@]}" --safe-off || fail "--safe-off"
"$geond" --set scan.veiws=3 --check 2>/dev/null && fail "a misspelt key passed"
start
"$geon" doctor >/dev/null || fail "doctor"
"$geon" scan --views 6 --json >"$folder/one.json" || { cat "$folder/log"; fail "scan"; }
grep -q '"type":"ellipsoid"' "$folder/one.json" || fail "no ellipsoid: $(cat "$folder/one.json")"
grep -q '"type":"tapered_cylinder"' "$folder/one.json" || fail "no tapered cylinder: $(cat "$folder/one.json")"

# Killed in mid-scan it loses no view it has acknowledged, and the resumed scan ends with the same description.
"$geon" watch --json >"$folder/events" 2>/dev/null &
watcher=$!
until grep -q '"event":"state"' "$folder/events" || "$geon" scan --views 6 --detach >/dev/null 2>&1; do :; done
until grep -q '"view":2' "$folder/events" || "$geon" scans --json | grep -q '"scan":2,"state":"done"'; do :; done
kill -9 $pid
wait $pid $watcher 2>/dev/null || true
start
"$geon" scans --json | grep -q '"scan":2,"state":"\(interrupted\|done\)"' || fail "the scan is not known: $("$geon" scans)"
if "$geon" scans --json | grep -q '"scan":2,"state":"interrupted"'; then
  "$geon" scan --resume 2 --json >"$folder/two.json" || fail "resume"
  grep -q '"type":"tapered_cylinder"' "$folder/two.json" || fail "the resumed description differs"
fi

kill -TERM $pid
wait $pid || fail "geond did not end well"
"$geon" status >/dev/null 2>&1 && fail "it still answers"

# Every configuration file travels in the package, and is kept there as the site has changed it.
for file in $(cd "$source/config" && find . -name '*.toml' | sed 's,^\./,,'); do
  grep -qx "/etc/geond/$file" "$source/systemd/debian/conffiles" || fail "config/$file is no conffile of the package"
done
echo "all is well"
