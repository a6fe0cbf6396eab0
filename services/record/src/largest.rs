//! The largest pieces that objects have come to, in two runs side by side.

use super::Recording;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

/// One of the largest pieces of an object in a run, and the one of the same rank in another.
#[derive(Clone, Debug, PartialEq)]
pub struct PieceRank {
    /// The object, or the sheet.
    pub object: String,
    /// Its place among the object's pieces, the largest being 1.
    pub rank: usize,
    /// Mass in the run that is judged \[kg\]; 0 where it has fewer pieces.
    pub mass: f64,
    /// Mass in the run that it is judged by \[kg\].
    pub reference: f64,
}

impl PieceRank {
    /// By how much its mass differs, over the reference's \[1\].
    #[must_use]
    pub fn difference(&self) -> f64 {
        self.mass / self.reference - 1.0
    }
}

/// The `count` largest pieces of all that broke or tore in either run, objects by name: as many
/// ranks of each as `reference` has pieces. An object that only one of the runs has is left out.
#[must_use]
pub fn ranks(run: &Recording, reference: &Recording, count: usize) -> Vec<PieceRank> {
    let (run, reference) = (pieces(run), pieces(reference));
    let mut ranks = Vec::new();
    for (object, there) in &reference {
        let Some(here) = run.get(object).filter(|here| here.len().max(there.len()) > 1) else {
            continue;
        };
        for (index, &reference) in there.iter().take(count).enumerate() {
            let mass = here.get(index).copied().unwrap_or(0.0);
            ranks.push(PieceRank { object: object.clone(), rank: index + 1, mass, reference });
        }
    }
    ranks
}

/// Masses of the pieces of each object and sheet at the end, largest first \[kg\].
fn pieces(recording: &Recording) -> BTreeMap<String, Vec<f64>> {
    let parents: BTreeSet<u64> = recording.bodies.iter().filter_map(|body| body.parent).collect();
    let mut objects: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for body in recording.bodies.iter().filter(|body| !parents.contains(&body.id)) {
        objects.entry(body.object.clone()).or_default().push(body.mass);
    }
    let names: BTreeMap<u32, &str> =
        recording.sheet_frames.iter().map(|frame| (frame.sheet, frame.name.as_str())).collect();
    let last: BTreeMap<u32, _> = recording.windows.iter().map(|w| (w.sheet, w)).collect();
    for (sheet, window) in last {
        let Some(name) = names.get(&sheet) else { continue };
        let masses = window.pieces.iter().map(|piece| piece.mass);
        objects.entry((*name).to_owned()).or_default().extend(masses);
    }
    for masses in objects.values_mut() {
        masses.sort_by(|a, b| b.total_cmp(a));
    }
    objects
}

/// The ranks as a table, a line each, and the greatest difference below.
#[must_use]
pub fn rank_table(ranks: &[PieceRank]) -> String {
    let width = ranks.iter().map(|rank| rank.object.chars().count()).max().unwrap_or(0).max(6);
    let mut text = format!("{:width$}  rank  mass [kg]    reference [kg]  difference\n", "object");
    for rank in ranks {
        let PieceRank { object, rank: place, mass, reference } = rank;
        let apart = 100.0 * rank.difference();
        let _never = writeln!(
            text,
            "{object:width$}  {place:4}  {mass:<11.4e}  {reference:<14.4e}  {apart:+.1} %"
        );
    }
    let worst = ranks.iter().map(|rank| rank.difference().abs()).fold(0.0, f64::max);
    let _never = match ranks.is_empty() {
        true => writeln!(text, "nothing broke or tore in either run"),
        false => writeln!(text, "at most {:.1} % apart", 100.0 * worst),
    };
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_piece_that_is_missing_is_all_of_it_apart() {
        let rank = |mass| PieceRank { object: "a".into(), rank: 1, mass, reference: 2.0 };
        assert_eq!(rank(2.2).difference(), 2.2 / 2.0 - 1.0);
        assert_eq!(rank(0.0).difference(), -1.0);
        let text = rank_table(&[rank(2.2), rank(0.0)]);
        assert!(text.contains("+10.0 %") && text.ends_with("at most 100.0 % apart\n"), "{text}");
    }
}
