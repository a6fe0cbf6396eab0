//! Sites that keep cracks on scored lines.
//!
//! The face between two sites that mirror each other at the plane of a groove lies in that plane.
//! Pairs along the groove, nearer to it than any other site, so have all its faces in it. One that
//! lies in the cell of a site on its own side takes that site's label, and the cell ends at the
//! line; one that lies in a cell from the other side gets a label of its own, and so parts that
//! cell.

use cullet_geometry::Vec3;
use cullet_model::strength::Region;
use std::collections::BTreeMap;

/// Distance of pairs along a groove, and down it, over the diagonal of the body \[1\].
const STEP: f64 = 0.03;
/// Distance of the two of a pair over that of pairs \[1\].
const APART: f64 = 0.5;
/// No other site is nearer to a groove than this many distances of pairs: a place of it is no
/// farther than √(1/2 + 1/16) of them from one of a pair \[1\].
const CLEAR: f64 = 1.0;
/// Most pairs: a body whose lines would take more has them farther apart.
const MOST_PAIRS: f64 = 2000.0;
/// Distances to grooves that differ by less than this share of the diagonal are one \[1\].
const ALIKE: f64 = 1e-9;

/// Sites with the pairs behind them, and the label of each.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct ScoredSites {
    pub(super) sites: Vec<Vec3>,
    pub(super) labels: Vec<u32>,
}

/// A groove with its own axes.
struct Groove {
    from: Vec3,
    to: Vec3,
    /// Along the line, and down \[m\].
    along: Vec3,
    down: Vec3,
    /// Unit normal of its plane.
    across: Vec3,
}

impl Groove {
    fn of(region: &Region) -> Option<Self> {
        let Region::Groove { from, to, inward, .. } = *region else { return None };
        let along = to - from;
        let across = along.cross(&inward).try_normalize(0.0)?;
        Some(Self { from, to, along, down: inward, across })
    }

    /// Signed distance to its plane \[m\].
    fn side(&self, place: &Vec3) -> f64 {
        (place - self.from).dot(&self.across)
    }

    /// From the place of it that is nearest to another to that \[m\].
    fn off(&self, place: &Vec3) -> Vec3 {
        let off = place - self.from;
        let share = |way: &Vec3| (off.dot(way) / way.norm_squared()).clamp(0.0, 1.0);
        off - self.along * share(&self.along) - self.down * share(&self.down)
    }

    /// Pairs of sites \[m\], those on the side of its normal first.
    fn pairs(&self, step: f64) -> Vec<[Vec3; 2]> {
        let count = |way: &Vec3| (way.norm() / step).ceil().max(1.0) as usize;
        let (columns, rows) = (count(&self.along), count(&self.down));
        let middle = |k: usize, of: usize| (k as f64 + 0.5) / of as f64;
        let off = self.across * (0.5 * APART * step);
        let pair = |k: usize| {
            let (column, row) = (k % columns, k / columns);
            let on = self.along * middle(column, columns) + self.down * middle(row, rows);
            [self.from + on + off, self.from + on - off]
        };
        (0..columns * rows).map(pair).collect()
    }
}

/// The lines that grooves make: each begins where the last ends.
fn lines(grooves: &[Groove]) -> impl Iterator<Item = &[Groove]> {
    grooves.chunk_by(|last, next| last.to == next.from)
}

/// Whether a place is on the side of a line that its normals point to. By the groove that it is
/// nearest to; where two grooves meet, by the one from whose plane it is farther.
fn is_ahead(line: &[Groove], place: &Vec3, slack: f64) -> bool {
    let far: Vec<f64> = line.iter().map(|groove| groove.off(place).norm()).collect();
    let least = far.iter().copied().fold(f64::INFINITY, f64::min);
    let near = line.iter().zip(&far).filter(|(_, far)| **far <= least + slack);
    let sides = near.map(|(groove, _)| groove.side(place));
    sides.fold(0.0_f64, |most, side| if side.abs() > most.abs() { side } else { most }) >= 0.0
}

/// The sites of a pattern in a body of that diagonal \[m\], moved off the grooves, and the pairs
/// that keep its cracks on these.
pub(super) fn along_lines(sites: &[Vec3], scored: &[Region], diagonal: f64) -> ScoredSites {
    let grooves: Vec<Groove> = scored.iter().filter_map(Groove::of).collect();
    let area: f64 = grooves.iter().map(|g| g.along.norm() * g.down.norm()).sum();
    let step = (STEP * diagonal).max((area / MOST_PAIRS).sqrt());
    let mut own = sites.to_vec();
    for site in &mut own {
        for groove in &grooves {
            let off = groove.off(site);
            if off.norm() < CLEAR * step {
                let way = off.try_normalize(ALIKE * diagonal).unwrap_or(groove.across);
                *site += way * (CLEAR * step) - off;
            }
        }
    }
    let owner = |place: &Vec3| -> usize {
        let far = |site: &Vec3| (site - place).norm_squared();
        let nearest = own.iter().enumerate().min_by(|a, b| far(a.1).total_cmp(&far(b.1)));
        nearest.map_or(0, |(k, _)| k)
    };
    let mut labels: Vec<u32> = (0..own.len() as u32).collect();
    let (mut pairs, mut parted) = (Vec::new(), BTreeMap::new());
    for line in lines(&grooves) {
        let all = line.iter().flat_map(|groove| groove.pairs(step));
        for (place, ahead) in all.flat_map(|[a, b]| [(a, true), (b, false)]) {
            let cell = owner(&place);
            let next = (own.len() + parted.len()) as u32;
            labels.push(match is_ahead(line, &own[cell], ALIKE * diagonal) == ahead {
                true => cell as u32,
                false => *parted.entry((cell, ahead)).or_insert(next),
            });
            pairs.push(place);
        }
    }
    own.extend(pairs);
    ScoredSites { sites: own, labels }
}
