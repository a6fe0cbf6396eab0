//! Specimens of the whole: a scene that is run as any other, and what is read off its recording.

pub mod format;
mod read;
mod scene;
mod schema;
#[cfg(test)]
mod tests;
mod watch;

pub(super) use read::read;
pub use scene::Whole;
pub use schema::schema;
pub use watch::ResolvedProbe;
