# Everyday commands. Each calls what CONTRIBUTING.md names; nothing needs `just`.

# List the commands
default:
    @just --list

# Build the program, target/release/cullet
build:
    cargo build --release

# Run the fast tests and the smoke suite
fast:
    cargo test --locked --release --workspace --lib --bins --test fast --test smoke

# Run the tests that are not long: fast, farm, verification, and the programs in the documentation
test:
    cargo test --release --workspace

# Check format and lints
lint:
    cargo fmt --all --check
    cargo clippy --release --workspace --all-targets -- -D warnings

# Write the documentation of the crates, target/doc/cullet/index.html
doc:
    cargo doc --release --workspace --no-deps

# Do what CI does before a change lands
ci:
    .ci/run

# Do everything that CI can do
full:
    .ci/full
