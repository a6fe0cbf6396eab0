#!/bin/sh
# A farm on this machine in one command: a router, a coordinator and two workers, with mutual TLS
# and access control by role. Ctrl-C ends all of it; started again, its runs continue.
#
#   deploy/local.sh [FOLDER]            default: .farm
#   CULLET=path/to/cullet PORT=7447
set -eu

case ${1:-} in
    -h | --help) sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit 0 ;;
    -*) echo "local.sh [FOLDER]; --help says more" >&2; exit 64 ;;
esac
here=$(dirname "$0")
folder=${1:-.farm}
cullet=${CULLET:-cullet}
endpoint=tls/127.0.0.1:${PORT:-7447}
command -v "$cullet" >/dev/null || { echo "there is no $cullet; name it in CULLET" >&2; exit 127; }
user=$(id -un | tr 'A-Z_.' 'a-z--' | tr -cd 'a-z0-9-' | cut -c1-40)
user=${user:-user}

"$here/certs.sh" "$folder/certs" router coordinator worker-1 worker-2 "$user"
printf 'workers = ["worker-1", "worker-2"]\noperators = ["%s"]\n' "$user" > "$folder/roles.toml"

"$cullet" router --listen "$endpoint" --tls "$folder/certs/router" \
    --roles "$folder/roles.toml" &
all=$!
"$cullet" coordinator --router "$endpoint" --state "$folder/state" \
    --tls "$folder/certs/coordinator" --roles "$folder/roles.toml" &
all="$all $!"
vital=$all
for worker in worker-1 worker-2; do
    "$cullet" worker --connect "$endpoint" --tls "$folder/certs/$worker" &
    all="$all $!"
done
trap 'kill $all 2>/dev/null; wait; exit 0' INT TERM
cat <<END
In another terminal:

  export CULLET_CONNECT=$endpoint CULLET_TLS=$folder/certs/$user
  $cullet doctor
  $cullet submit scenes/pot

END
# The farm needs its router and its coordinator; workers may exit.
alive() { for one in $vital; do kill -0 "$one" 2>/dev/null || return 1; done; }
while alive; do sleep 1; done
kill $all 2>/dev/null || true
wait
echo "the router or the coordinator has ended, so the others were stopped" >&2
exit 1
