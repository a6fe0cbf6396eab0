//! What broke, as pieces at rest: each in its place in the whole object.

use crate::error::ExportError;
use crate::glb::{self, GlbUse};
use crate::table;
use crate::timeline::{BodyTrack, ExportTimeline, Scenery};
use std::collections::BTreeSet;

/// The files of a folder of pieces.
pub(crate) struct PieceFiles {
    /// Name and content of each, the table last.
    pub(crate) contents: Vec<(String, Vec<u8>)>,
    pub(crate) pieces: usize,
    pub(crate) triangles: usize,
    pub(crate) pictures: usize,
}

/// The fragments that broke no more: in their last shape where they had several.
fn last_pieces(timeline: &ExportTimeline) -> Vec<&BodyTrack> {
    let mut seen = BTreeSet::new();
    let fragments = timeline.bodies.iter().filter(|track| track.body.parent.is_some());
    let broke: BTreeSet<u64> =
        timeline.bodies.iter().filter(|track| track.broke).map(|track| track.body.id).collect();
    let whole = fragments.filter(|track| !broke.contains(&track.body.id));
    let mut pieces: Vec<&BodyTrack> =
        whole.rev().filter(|track| seen.insert(track.body.id)).collect();
    pieces.reverse();
    pieces
}

pub(crate) fn files(timeline: &ExportTimeline) -> Result<PieceFiles, ExportError> {
    let pieces = last_pieces(timeline);
    if pieces.is_empty() {
        return Err(ExportError::NoPieces);
    }
    let names: BTreeSet<&str> = pieces.iter().map(|track| track.name.as_str()).collect();
    let mut contents = Vec::with_capacity(pieces.len() + 2);
    for piece in &pieces {
        let one =
            glb::write(timeline, Scenery::Rest, GlbUse::Work, |track| track.name == piece.name)?;
        // A piece whose name is that of the file of all of them.
        let name = if piece.name == "pieces" { "pieces_" } else { &piece.name };
        contents.push((format!("{name}.glb"), one.bytes));
    }
    let all = glb::write(timeline, Scenery::Rest, GlbUse::Work, |track| {
        names.contains(track.name.as_str())
    })?;
    contents.push(("pieces.glb".to_owned(), all.bytes));
    contents.push(("pieces.csv".to_owned(), table::of_bodies(timeline, &pieces).into_bytes()));
    let (triangles, pictures) = (all.triangles, all.pictures);
    Ok(PieceFiles { contents, pieces: pieces.len(), triangles, pictures })
}
