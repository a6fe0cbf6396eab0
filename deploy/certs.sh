#!/bin/sh
# Development certificates: an authority and one identity for each name, each in a folder of its
# own with ca.pem, cert.pem and key.pem, as --tls needs it. The authority's key stays in FOLDER/ca.
# If you run it again with more names, it adds them and keeps what exists.
#
#   deploy/certs.sh FOLDER NAME…        such as: deploy/certs.sh certs router coordinator a b ann
#   CULLET_HOSTS=farm.example,10.0.0.5  more hosts for which the certificates are valid
#   CULLET_DAYS=90                      how many days they are valid
#   CULLET_FROM, CULLET_UNTIL           or their first and last moment, as 20270131235959Z
set -eu

case ${1:-} in -*) set -- ;; esac
[ $# -ge 2 ] || { echo "certs.sh FOLDER NAME…" >&2; exit 64; }
folder=$1
shift
hosts="DNS:localhost,IP:127.0.0.1,IP:::1"
for host in $(echo "${CULLET_HOSTS:-}" | tr ',' ' '); do
    case $host in
        *[!0-9.]*) hosts="$hosts,DNS:$host" ;;
        *) hosts="$hosts,IP:$host" ;;
    esac
done

umask 077
mkdir -p "$folder/ca"
ca=$folder/ca
if [ ! -f "$ca/key.pem" ]; then
    openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -days 365 \
        -subj "/CN=cullet development authority" \
        -addext "basicConstraints=critical,CA:TRUE" -addext "keyUsage=critical,keyCertSign" \
        -keyout "$ca/key.pem" -out "$ca/cert.pem" 2>/dev/null
fi
: > "$ca/index"
cat > "$ca/config" <<END
[ca]
default_ca = authority
[authority]
database = $ca/index
new_certs_dir = $ca
certificate = $ca/cert.pem
private_key = $ca/key.pem
default_md = sha256
rand_serial = yes
unique_subject = no
policy = names
x509_extensions = identity
[names]
commonName = supplied
[identity]
subjectAltName = $hosts
extendedKeyUsage = serverAuth,clientAuth
END
for name in "$@"; do
    case $name in
        '' | *[!a-z0-9-]*) echo "$name: a name is of a-z, 0-9 and -" >&2; exit 64 ;;
    esac
    own=$folder/$name
    [ ! -f "$own/cert.pem" ] || continue
    mkdir -p "$own"
    openssl req -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -subj "/CN=$name" \
        -keyout "$own/key.pem" -out "$own/request.pem" 2>/dev/null
    openssl ca -batch -notext -config "$ca/config" -in "$own/request.pem" -out "$own/cert.pem" \
        -days "${CULLET_DAYS:-90}" ${CULLET_FROM:+-startdate "$CULLET_FROM"} \
        ${CULLET_UNTIL:+-enddate "$CULLET_UNTIL"} 2>/dev/null || {
        echo "$name: openssl signs no certificate" >&2
        exit 1
    }
    cp "$ca/cert.pem" "$own/ca.pem"
    rm "$own/request.pem"
done
rm -f "$ca"/index* "$ca/config" "$ca"/[0-9A-F]*.pem
