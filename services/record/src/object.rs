//! Objects as viewers get them.

use std::collections::BTreeSet;

/// Bytes of viewers' messages a run, before compression. Past its share of this a moving object is
/// drawn less often; the lossless track is not touched.
const DRAW_BYTES: f64 = 200e6;

/// Bytes of drawings a simulated second \[bytes/s\].
pub(super) fn rate(duration: f64) -> f64 {
    DRAW_BYTES / duration.max(1.0)
}

/// An object of the scene: what is left of it, and when it was last drawn.
#[derive(Debug, Default)]
pub(super) struct Object {
    pub(super) parts: BTreeSet<u64>,
    pub(super) moved: bool,
    pub(super) changed: bool,
    pub(super) drawn_at: Option<f64>,
}

/// The viewers' topic of an object.
pub(super) fn scene_topic(object: &str) -> String {
    topic("/scene/", object)
}

/// The viewers' topic of a sheet, which no object has.
pub(super) fn sheet_topic(sheet: &str) -> String {
    topic("/scene/sheets/", sheet)
}

fn topic(under: &str, name: &str) -> String {
    let mut topic = under.to_owned();
    for c in name.chars() {
        match c {
            c if c.is_alphanumeric() || "-_.".contains(c) => topic.push(c),
            c => topic.push_str(&format!("_{:x}_", u32::from(c))),
        }
    }
    topic
}
