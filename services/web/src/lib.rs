//! A farm as a page in a browser: its queue, runs, workers, pictures and reports, as they change.
//!
//! Whoever owns the farm publishes what there is into a [`Feed`]; whoever watches gets it from
//! there. Nothing that a watcher does or leaves undone reaches the owner: there is one slot for the
//! present state, a reader that is slow misses what was in between, and one that takes nothing is
//! sent away. The page only shows: there is GET and HEAD, and nothing can be changed.

mod events;
mod feed;
mod figures;
mod headers;
mod pictures;
mod reports;
mod routes;
mod server;
mod site;
mod stall;
#[cfg(test)]
mod tests;
mod tls;
mod view;
mod viewers;

pub use feed::Feed;
pub use pictures::Illustrator;
pub use server::{TextAnswers, TextServer};
pub use site::{WebConfig, WebError, WebIdentity, Website};
pub use view::{FarmNews, FarmView, RunFigures, RunNews, RunView, WorkerView};
pub use viewers::{StreamChannel, ViewerServer};
