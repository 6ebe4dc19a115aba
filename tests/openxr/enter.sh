#!/usr/bin/env bash
# enter.sh ROOT PROJECT [NAME=VALUE...] CMD...: runs CMD in the root; started by root.entered in namespaces of its own.
set -euo pipefail
ROOT=$1 PROJECT=$2 OURS=/tmp; shift 2

# The network is the loopback alone.
ip link set lo up 2>/dev/null || python3 -c '
import fcntl, socket, struct
fcntl.ioctl(socket.socket(), 0x8914, struct.pack("16sH14x", b"lo", 0x41))'  # SIOCSIFFLAGS: IFF_UP | IFF_RUNNING

# Several may be in the root at once: nothing in it is written to but what is mounted over it here.
mount --bind "$ROOT" "$ROOT"
mkdir -p "$ROOT/project"
mount -t proc proc "$ROOT/proc"
mount -t tmpfs -o mode=755 tmpfs "$ROOT/dev"
for node in null zero full random urandom tty; do
  [ -e "/dev/$node" ] || continue
  touch "$ROOT/dev/$node"
  mount --bind "/dev/$node" "$ROOT/dev/$node"
done
mkdir -m 1777 "$ROOT/dev/shm"
mount -t tmpfs -o mode=1777 tmpfs "$ROOT$OURS"
mkdir -m 700 "$ROOT$OURS/home"
[ ! -s "$ROOT/var/cache/hmdwarp-warm.tar" ] || tar -C "$ROOT$OURS" -xf "$ROOT/var/cache/hmdwarp-warm.tar"
mount --bind "$PROJECT" "$ROOT/project"
mount -o remount,bind,ro "$ROOT/project"
mount -o remount,bind,ro "$ROOT"

# No exec: process 1 of the namespace is a shell that reaps what is orphaned, and CMD gets the signals it expects.
chroot "$ROOT" /usr/bin/env -i --chdir=/project HOME=$OURS/home LANG=C.UTF-8 PATH=/usr/bin:/bin \
  PYTHONPATH=/project:/project/tests PYTHONPYCACHEPREFIX=$OURS/pycache PYTHONUNBUFFERED=1 "$@"
