#!/bin/sh
# Builds the image, runs it in QEMU, and prints the port for a sender of grbl:
#   firmware/mps2/run.sh [RECORD]
# RECORD: a file for what the pins do. Ctrl-C ends it.
set -eu
cd "$(dirname "$0")/../.."
.ci/thumb.sh build --quiet --profile firmware --package splineway-mps2 --locked
record=null
if [ $# -gt 0 ]; then record="file:$1"; fi
echo "The port for the sender is the one that QEMU calls serial0; what follows is the board's log."
exec qemu-system-arm -M mps2-an386 -icount shift=3,align=on -nographic -monitor none \
  -serial pty -serial "$record" -serial stdio -serial null \
  -kernel "${THUMB_TARGET_DIR:-target/thumb}/thumbv7em-none-eabihf/firmware/mps2"
