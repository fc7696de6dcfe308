#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# usage: tools/uml run -v -o DIR sh debian.sh PACKAGE.deb DIR, where every change to the system is lost
set -eu
exec >"$2/log" 2>&1
set -x
# Those of the host may be unreadable: its user is an ordinary one.
rm -f /var/lib/dpkg/lock* /var/lib/dpkg/triggers/Lock /var/log/dpkg.log
rm -f /etc/.pwd.lock /etc/shadow /etc/gshadow
touch /etc/shadow /etc/gshadow
mkdir -p /usr/share/doc/camturn # the file system of the test kernel cannot rename a new folder
dpkg --no-pager -i "$1"
id -nG camturn | grep -x 'camturn gpio'
dpkg -L camturn >"$2/files"

sed -i "s/\"can0\"/\"vcan0\"/; s/\"gpiochip0\"/\"$CAMTURN_GPIOCHIP\"/" /etc/camturn.toml
mkdir /var/lib/camturn # by systemd
$(sed -n 's/^ExecStart=//p' /usr/lib/systemd/system/camturn.service) 2>"$2/said" &
sleep 2
kill $!
wait $!
echo kept >/var/lib/camturn/parameters.toml

left() {
    while read -r file; do
        [ -d "$file" ] || [ ! -e "$file" ] || echo "$file"
    done <"$2/files"
    ls /var/lib/camturn 2>/dev/null || true
}
dpkg -r camturn
left "$@" >"$2/removed"
dpkg -P camturn
left "$@" >"$2/purged"
