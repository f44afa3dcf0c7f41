#!/bin/sh
# Runs every fuzz target for a while, from seeds, the same way each time:
#   fuzz.sh [RUNS] [SEED]
# For long runs, with cargo-fuzz: cargo +nightly fuzz run blocks --fuzz-dir host-tests/fuzz
set -eu
runs=${1:-20000}
seed=${2:-1}
cd "$(dirname "$0")/../host-tests/fuzz"
# libFuzzer is C++.
command -v c++ >/dev/null || { apt-get update -qq && apt-get install -y -qq --no-install-recommends g++ >/dev/null; }
# Coverage as libFuzzer reads it; no sanitizer, for there is no unsafe code to sanitise.
RUSTFLAGS="--cfg fuzzing -Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table -Cllvm-args=-sanitizer-coverage-trace-compares" \
  cargo build --release --locked --target x86_64-unknown-linux-gnu
for target in blocks gcode wire splines; do
  echo "fuzz $target: $runs runs, seed $seed"
  corpus=$(mktemp -d)
  dictionary=
  case $target in
    gcode) cp ../data/*.txt seeds/*.ngc seeds/*.gcode "$corpus" ;;
    wire) cp seeds/*.wire "$corpus" ;;
    splines) cp ../data/*.json "$corpus" ;;
  esac
  [ -f "$target.dict" ] && dictionary="-dict=$target.dict"
  "target/x86_64-unknown-linux-gnu/release/$target" -runs="$runs" -seed="$seed" -max_len=600 -timeout=20 \
    -print_final_stats=0 -verbosity=0 $dictionary "$corpus"
  rm -r "$corpus"
done
