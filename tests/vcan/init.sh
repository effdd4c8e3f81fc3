#!/bin/sh
# First process inside user-mode Linux: vcan0, then on_vcan.py, then power off.
# From the kernel's command line: REPOSITORY, PYTHON, and OUTSIDE, the host's folder that is
# mounted writable as /run/vcan. All else is the host's file system, read-only.
export PATH=/usr/sbin:/usr/bin:/sbin:/bin
mount -t proc proc /proc
mount -t sysfs sysfs /sys
mount -t tmpfs tmpfs /run
mkdir /run/vcan
mount -t hostfs -o "$OUTSIDE" none /run/vcan

{
  modules=/usr/lib/uml/modules/$(uname -r)/kernel
  for module in net/can/can net/can/can-raw drivers/net/can/dev/can-dev drivers/net/can/vcan \
      net/sched/sch_tbf; do
    insmod "$modules/$module.ko"
  done
  ip link add vcan0 type vcan
  export HOME=/run TMPDIR=/run PYTHONDONTWRITEBYTECODE=1
  cd "$REPOSITORY"
  "$PYTHON" -m pytest -p no:cacheprovider -s -v --no-header --tb=short tests/vcan/on_vcan.py
  echo $? > /run/vcan/status
} > /run/vcan/log 2>&1
sync
echo o > /proc/sysrq-trigger
sleep 60
