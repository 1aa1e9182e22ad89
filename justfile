# What must hold before a change is merged, recipe by recipe; .ci/run installs what they need and runs all of them.
# just comes from `cargo install just`, `pip install rust-just` or a distribution. `just` alone lists the recipes.

target := env("CARGO_TARGET_DIR", "target")
binary := target / "release/landmarkd"
# Programs of Python packages: pip install schemathesis==4.32.5; the clients' environment is made when it is missing.
schemathesis := env("SCHEMATHESIS", "schemathesis")
venv := env("LANDMARKD_CLIENTS_VENV", target / "clients")

[private]
default:
    @just --list --unsorted

# The release binary and the examples of the library.
build:
    cargo build --locked --release --workspace --bins --examples

# Format, lints, the locks, the length of the console's lines.
lint:
    cargo fmt --all --check
    cargo clippy --locked --workspace --all-targets -- -D warnings
    cargo metadata --locked --format-version 1 --manifest-path fuzz/Cargo.toml >/dev/null
    ! LC_ALL=C.UTF-8 grep --recursive --line-number --extended-regexp '.{141,}' console templates

# All tests that need no data and no other program.
test:
    cargo test --locked

# Several processes on PostgreSQL and a bucket. Needs PostgreSQL's server programs and moto_server.
fleet:
    cargo test --locked --package landmarkd --lib store:: -- --ignored --nocapture
    cargo test --locked --test fleet -- --ignored --nocapture --test-threads 2

# Kills, damaged files and backups; `just crash` takes hours, `just crash every_byte twenty_backups` a minute.
crash *filters:
    cargo test --locked --test crash -- --ignored --nocapture {{ filters }}

# Too much load, and clients that misbehave; prints figures.
load:
    cargo test --locked --release --test load -- --ignored --nocapture --test-threads 1

# The claims of both papers on the pictures in LANDMARKD_DATA (docs/data.md).
claims:
    cargo test --locked --release --test claims -- --include-ignored --nocapture

# The running service against its OpenAPI document. Needs schemathesis.
contract: build
    tests/contract/run.py --binary {{ binary }} --refusals
    tests/contract/run.py --binary {{ binary }} --schemathesis {{ schemathesis }} --examples 10

# The console in a browser. Needs Node and chromium.
console: build
    tests/browser/run.sh {{ binary }}

# The clients, and every command of the pages. Needs Python; Node for the types in TypeScript.
clients: build
    clients/test.sh {{ binary }} {{ venv }}
    tests/pages/run.py {{ binary }} --venv {{ venv }}
