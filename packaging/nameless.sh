#!/usr/bin/env bash
# The demo under the conditions of packaging/Containerfile, without an engine: a user without a name, no HOME, a folder
# that is not the user's. It takes root.
#
#   packaging/nameless.sh FOLDER_OF_PROGRAMS      e.g. .venv/bin, which this user has to be able to read
set -euo pipefail
programs=$(cd "$1" && pwd)
uid=54321
if getent passwd "$uid" > /dev/null; then echo "the user $uid has a name here"; exit 1; fi
[ "$(id -u)" = 0 ] || { echo "not root: the demo of a user without a name is left out"; exit 0; }
cd /
log=$(mktemp)
trap 'rm -f "$log"' EXIT
TIMEFORMAT="plannercheck demo, as user $uid without HOME: %lR, %lU of processor time"
time setpriv --reuid "$uid" --regid "$uid" --clear-groups --no-new-privs \
  env -i PATH="$programs" plannercheck demo > "$log" 2>&1 || { cat "$log"; exit 1; }
