#!/bin/sh
# The library for C in somebody's own build: CMake, Make and pkg-config, for this host, where the example for the HAL of STM32 runs on
# a stub of it, and for a Cortex-M4F, where it is linked. Needs cmake, make, pkg-config, cc; for the target thumb.sh and
# arm-none-eabi-gcc (without them it is left out, unless SPLINEWAY_REQUIRE_TARGET is set).
set -eu
cd "$(dirname "$0")/.."
root=$PWD
out=$root/target/c-builds
hal=$root/host-tests/c/hal
rm -rf "$out/cmake" "$out/make" "$out/five" "$out/prefix" "$out/cmake-arm" "$out/make-arm"
mkdir -p "$out"
expect() { # what a command prints
  printed=$("$1")
  echo "$printed"
  case $printed in *"$2"*) ;; *) echo "c.sh: expected '$2'" >&2; exit 1 ;; esac
}

echo "-- CMake, host"
cmake -S "$hal" -B "$out/cmake" -DSPLINEWAY_CARGO_DIR="$out/cargo" >"$out/log" || { cat "$out/log"; exit 1; }
cmake --build "$out/cmake"
expect "$out/cmake/hal" "0 edges too near, 0 wrong"

echo "-- CMake: a project of one's own, configured for the first time"
rm -rf "$out/own"
mkdir -p "$out/own"
printf '#define SPLINEWAY_AXES 5\n' >"$out/own/splineway_config.h"
cat >"$out/own/CMakeLists.txt" <<EOF
cmake_minimum_required(VERSION 3.16)
project(own LANGUAGES C)
set(SPLINEWAY_CONFIG \${CMAKE_CURRENT_SOURCE_DIR}/splineway_config.h)
add_subdirectory($root splineway)
EOF
cmake -S "$out/own" -B "$out/own/build" >"$out/log"
grep -q "SPLINEWAY_AXES=5" "$out/log" || { cat "$out/log"; echo "c.sh: the project's header was not read" >&2; exit 1; }

echo "-- Make, host"
make -C "$hal" BUILD="$out/make" SPLINEWAY_CARGO_DIR="$out/cargo"
expect "$out/make/hal" "0 edges too near, 0 wrong"
# Nothing is linked again if nothing has changed.
if make -C "$hal" BUILD="$out/make" SPLINEWAY_CARGO_DIR="$out/cargo" | grep -e '-o '; then exit 1; fi

echo "-- CMake, installed, pkg-config: five axes, input shaping"
printf '#define SPLINEWAY_AXES 5\n#define SPLINEWAY_NODES 48\n#define SPLINEWAY_SHAPING 1\n' >"$out/five.h"
cmake -S . -B "$out/five" -DSPLINEWAY_CONFIG="$out/five.h" -DSPLINEWAY_CARGO_DIR="$out/cargo" -DCMAKE_INSTALL_PREFIX="$out/prefix" >"$out/log"
cmake --build "$out/five"
cmake --install "$out/five" >"$out/log"
export PKG_CONFIG_PATH="$out/prefix/lib/pkgconfig"
# shellcheck disable=SC2046
cc -std=c11 -Wall -Wextra -Werror -Ihost-tests/c host-tests/c/example.c host-tests/c/main.c $(pkg-config --cflags --libs splineway) -lm -o "$out/five/example"
expect "$out/five/example" "result 0 (done)"

echo "-- mistakes"
refuses() { # what, and the words
  if "$out/refused" >"$out/log" 2>&1; then echo "c.sh: $1 was taken" >&2; exit 1; fi
  tr '\n' ' ' <"$out/log" | tr -s ' ' | grep -q "$2" || { cat "$out/log"; echo "c.sh: $1: expected '$2'" >&2; exit 1; }
}
attempt() { printf '#!/bin/sh\nset -e\nrm -rf %s\n%s\n' "$out/wrong" "$1" >"$out/refused"; chmod +x "$out/refused"; }
echo '#define SPLINEWAY_AXES (2 + 1)' >"$out/wrong.h"
attempt "cmake -S $root -B $out/wrong -DSPLINEWAY_CONFIG=$out/wrong.h"
refuses "a size that is no plain number" "must be a plain number"
attempt "make -C $hal BUILD=$out/wrong SPLINEWAY_CONFIG=$out/wrong.h"
refuses "a size that is no plain number" "must be a plain number"
echo '#define SPLINEWAY_OUTPUTS' >"$out/wrong.h"
attempt "cmake -S $root -B $out/wrong -DSPLINEWAY_CONFIG=$out/wrong.h"
refuses "a feature without a number" "must be a plain number"
attempt "make -C $hal BUILD=$out/wrong SPLINEWAY_CONFIG=$out/wrong.h"
refuses "a feature without a number" "must be a plain number"
attempt "cmake -S $root -B $out/wrong -DSPLINEWAY_CONFIG=$out/nowhere.h"
refuses "no header" "there is no"
attempt "make -C $hal BUILD=$out/wrong SPLINEWAY_CONFIG=$out/nowhere.h"
refuses "no header" "there is no"

has() { command -v "$1" >/dev/null 2>&1; }
if ! has arm-none-eabi-gcc; then
  echo "c.sh: no arm-none-eabi-gcc: nothing is linked for the target" >&2
  [ -z "${SPLINEWAY_REQUIRE_TARGET:-}" ] || exit 1
  exit 0
fi
attempt "cmake -S $root -B $out/wrong -DCMAKE_TOOLCHAIN_FILE=$hal/cortex-m4f.cmake -DCMAKE_C_FLAGS='-mcpu=cortex-m0 -mthumb'"
refuses "a Cortex-M0" "no target is known"
attempt "make -C $hal BUILD=$out/wrong CC=arm-none-eabi-gcc"
refuses "no CPU" "No target is known"

echo "-- CMake, Cortex-M4F"
cmake -S "$hal" -B "$out/cmake-arm" -DCMAKE_TOOLCHAIN_FILE="$hal/cortex-m4f.cmake" -DSPLINEWAY_CARGO="$root/.ci/thumb.sh" \
  -DSPLINEWAY_CARGO_DIR="$root/target/thumb" >"$out/log" || { cat "$out/log"; exit 1; }
cmake --build "$out/cmake-arm" || { rc=$?; [ -n "${SPLINEWAY_REQUIRE_TARGET:-}" ] && exit $rc; echo "c.sh: no toolchain for the target" >&2; exit 0; }
echo "-- Make, Cortex-M4F"
make -C "$hal" TARGET=arm BUILD="$out/make-arm" SPLINEWAY_CARGO="$root/.ci/thumb.sh" SPLINEWAY_CARGO_DIR="$root/target/thumb"
for image in cmake-arm make-arm; do
  arm-none-eabi-size "$out/$image/hal"
  arm-none-eabi-nm "$out/$image/hal" | grep -q ' T splineway_tick'
done
