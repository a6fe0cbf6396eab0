//! Limits of jobs, windows, specimens and verdicts. They are re-exported where they belong; here
//! they depend on nothing, so that each kind of message can be held to those of another.

/// Most pieces that a scene can ask for.
pub const MAX_PIECES: u32 = 4_096;
/// Most guide points of a body: they travel in the header.
pub const MAX_GUIDES: usize = 1_024;
/// Most regions of a body that stay whole: they travel in the header, too.
pub const MAX_WHOLE: usize = 64;
/// Most hits in one job: they travel in the header.
pub const MAX_IMPACTS: usize = 256;
/// Most supports in one job: they travel in the header too.
pub const MAX_SUPPORTS: usize = 256;
/// Longest solver name \[bytes\].
pub const MAX_SOLVER: usize = 64;

/// Most rigid bodies in one window.
pub const MAX_PROXIES: usize = 1_024;
/// Most convex parts of a body in reach.
pub const MAX_PARTS_OF_PROXY: usize = 4_096;
/// Most steps of the rigid world in one window.
pub const MAX_WINDOW_STEPS: u64 = 1_024;

/// Most samples of a probe.
pub const MAX_SAMPLES: u64 = 1 << 20;
/// Most probes.
pub const MAX_PROBES: u64 = 1024;
/// Most frames.
pub const MAX_FRAMES: u64 = 10_000;
/// Longest name of a family \[bytes\].
pub const MAX_FAMILY: u64 = 64;

/// Most fragments of one body: an order above what a scene may ask for.
pub const MAX_FRAGMENTS: usize = 16_384;
/// Most convex parts of one fragment.
pub const MAX_HULLS: usize = 4_096;
/// Most grains of debris of one body.
pub const MAX_GRAINS: usize = 65_536;
/// Most warnings in a report; further ones are counted in the last.
pub const MAX_WARNINGS: usize = 32;
/// Most figures of a family's own in a report; further ones are left out.
pub const MAX_DETAILS: usize = 64;
/// Longest text \[bytes\]; the rest is cut off.
pub const MAX_TEXT: usize = 1_024;

const _: () = assert!(MAX_PIECES as usize <= MAX_FRAGMENTS);

/// The text, up to [`MAX_TEXT`] bytes of it.
#[must_use]
pub fn cut(text: &str) -> String {
    text[..text.floor_char_boundary(MAX_TEXT)].to_owned()
}
