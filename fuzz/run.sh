#!/usr/bin/env bash
# Fuzz every target, one after the other, for so many seconds each.
#
#   fuzz/run.sh [seconds, 60] [target ...]
#
# Needs cargo-fuzz (cargo install cargo-fuzz) and, if there is one, a nightly compiler; else RUSTC_BOOTSTRAP makes the
# stable one act as one. SANITIZER=address checks the memory of the crates that use `unsafe`, at half the speed; the default is none.
# NICE is the niceness, by default 19. KEEP=1 adds inputs that reach something new to fuzz/corpus. An input that ends a
# target is left in fuzz/artifacts.
# Exits with 1 when there is one.
set -euo pipefail

cd "$(dirname "${BASH_SOURCE[0]}")"
seconds="${1:-60}"
shift || true
sanitizer="${SANITIZER:-none}"
built="${CARGO_TARGET_DIR:-$PWD/target}/fuzz"

if cargo +nightly --version >/dev/null 2>&1; then
    export RUSTUP_TOOLCHAIN=nightly
else
    export RUSTC_BOOTSTRAP=1
fi
host="$(rustc -vV | sed -n 's/^host: //p')"
targets=("$@")
if [[ ${#targets[@]} -eq 0 ]]; then
    mapfile -t targets < <(cargo fuzz list)
fi
cargo fuzz build --sanitizer "$sanitizer" --target-dir "$built"

# In memory where that can be: every request is synced to the disk.
work="$(mktemp --directory --tmpdir="$([[ -w /dev/shm ]] && echo /dev/shm || echo "${TMPDIR:-/tmp}")" landmarkd-fuzz-XXXXXX)"
trap 'rm --recursive --force "$work"' EXIT
mkdir --parents artifacts
found=0
printf '%-16s %10s %8s %9s %9s %8s\n' target inputs seconds per_s coverage crashes
for target in "${targets[@]}"; do
    mkdir --parents "corpus/$target" "$work/$target/new" "$work/$target/tmp" "$work/seeds/$target"
    binary="$built/$host/release/$target"
    began=$SECONDS
    TMPDIR="$work/$target/tmp" LANDMARKD_FUZZ_SEEDS="$work/seeds/$target" \
        nice -n "${NICE:-19}" "$binary" -max_total_time="$seconds" -timeout=100 -report_slow_units=100 -rss_limit_mb=3072 -max_len=65536 -dict="$work/seeds/words" \
        -print_final_stats=1 -artifact_prefix="artifacts/$target-" \
        "$work/$target/new" "$work/seeds/$target" "corpus/$target" >"$work/$target/log" 2>&1 || true
    took=$((SECONDS - began))
    inputs="$(sed -n 's/^stat::number_of_executed_units: *//p' "$work/$target/log" | tail -n 1)"
    inputs="${inputs:-$(grep -oE '^#[0-9]+' "$work/$target/log" | tail -n 1 | tr -d '#' || true)}"
    coverage="$(grep -oE 'cov: [0-9]+' "$work/$target/log" | tail -n 1 | cut -d' ' -f2 || true)"
    crashes="$(grep -c '^artifact_prefix=\|Test unit written to' "$work/$target/log" || true)"
    printf '%-16s %10s %8s %9s %9s %8s\n' \
        "$target" "${inputs:-0}" "$took" "$((${inputs:-0} / (took > 0 ? took : 1)))" "${coverage:-0}" "$crashes"
    if [[ "$crashes" -gt 0 || -z "$coverage" ]]; then
        found=1
        grep -v '^#\|^NEW_FUNC\|^INFO' "$work/$target/log" | tail -n 40
    fi
    if [[ "${KEEP:-}" == 1 ]]; then
        TMPDIR="$work/$target/tmp" "$binary" -merge=1 -max_len=4096 "corpus/$target" "$work/$target/new" >/dev/null 2>&1 || true
    fi
    rm --recursive --force "$work/$target"
done
exit "$found"
