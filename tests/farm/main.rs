//! The program as processes on a network: what people and programs see of it, and what faults leave
//! of it. A suite is a module: `cargo test --release --workspace --test farm recovery::`.

#[path = "../common/mod.rs"]
mod common;

mod again;
mod batch;
mod beginning;
mod command;
mod delete;
mod endings;
mod examples;
mod faults;
mod front;
mod history;
mod http;
mod kept;
mod logs;
mod messages;
mod namespace;
mod network;
mod operations;
mod programs;
mod recovery;
mod rivals;
mod router;
mod safety;
mod service;
mod soak;
mod streams;
mod sweeps;
mod viewers;
mod web;
