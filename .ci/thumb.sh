#!/bin/sh
# Runs cargo for thumbv7em-none-eabihf with whatever toolchain can build for it:
#   thumb.sh build --release --package splineway
# An installed target is used as it is; else `core` is built from its sources (rust-src of the
# rustc in the path, or of Debian's rustc-web). Exit 77: there is no toolchain for the target.
set -eu
T=thumbv7em-none-eabihf
V=CARGO_TARGET_THUMBV7EM_NONE_EABIHF
export CARGO_TARGET_DIR="${THUMB_TARGET_DIR:-target/thumb}" CARGO_BUILD_TARGET=$T
has() { command -v "$1" >/dev/null 2>&1; }
has_core() { ls "$("$1" --print target-libdir --target $T 2>/dev/null)"/libcore-*.rlib >/dev/null 2>&1; }
has_src() { [ -f "$("$1" --print sysroot)/lib/rustlib/src/rust/library/Cargo.lock" ]; }
own_lld() {
  p="$("$1" --print sysroot)/lib/rustlib/$("$1" -vV | sed -n 's/^host: //p')/bin/rust-lld"
  [ -x "$p" ] && echo "$p"
}
if has rustc && has_core rustc; then
  mode=installed-target
else
  lld=""
  if has rustc; then lld=$(own_lld rustc || true); fi
  if has rustc && has_src rustc; then
    mode=build-std
  elif [ -x /usr/bin/rustc ] && [ -x /usr/bin/cargo ] && has_src /usr/bin/rustc; then
    mode=system-build-std
    PATH=/usr/bin:/bin
    export PATH
  else
    echo "thumb.sh: no toolchain for $T" >&2
    exit 77
  fi
  # Building core from source is an unstable feature of the stable compiler.
  export RUSTC_BOOTSTRAP=1 CARGO_UNSTABLE_BUILD_STD=core
  flavour=""
  if [ -z "$lld" ] && ! has rust-lld; then
    for l in ld.lld ld.lld-22 arm-none-eabi-ld; do
      if has $l; then
        lld=$l
        case $l in arm*) flavour=ld ;; *) flavour=ld.lld ;; esac
        break
      fi
    done
    [ -n "$lld" ] || { echo "thumb.sh: no linker for $T" >&2; exit 77; }
  fi
  if [ -n "$lld" ]; then export ${V}_LINKER="$lld"; fi
  flags="-C target-cpu=${THUMB_CPU:-cortex-m4}"
  if [ -n "$flavour" ]; then flags="-C linker-flavor=$flavour $flags"; fi
  export ${V}_RUSTFLAGS="$flags"
fi
echo "thumb.sh: $mode, $(rustc -V)" >&2
exec cargo "$@"
