//! Sites that keep cracks on scored lines.
//!
//! The face between two sites that mirror each other at the plane of a groove lies in that plane.
//! Pairs along the groove, nearer to it than any other site, so have all its faces in it. One that
//! no line parts from the site in whose cell it lies takes that site's label; all those that the
//! same lines part from it get a label of their own, and so part that cell along these lines.

use cullet_geometry::inside::{Inside, Nearest};
use cullet_geometry::math::unit;
use cullet_geometry::{TriMesh, Vec3};
use cullet_model::strength::Region;
use std::collections::BTreeMap;
use std::ops::Range;

/// Distance of pairs along a groove, and down it, over the diagonal of the body \[1\].
const STEP: f64 = 0.03;
/// Distance of the two of a pair over that of pairs \[1\].
const APART: f64 = 0.5;
/// No other site is nearer to a groove than this many distances of pairs: a place of it is no
/// farther than √(1/2 + 1/16) of them from one of a pair \[1\].
const CLEAR: f64 = 1.0;
/// Sites are moved off a groove this often; one that then is too near to another is left out.
const MOVES: usize = 4;
/// Distance of pairs is such that about this many cover all lines of a body, if it is more.
const MANY_PAIRS: f64 = 2000.0;
/// Where two grooves meet, or nearly so, a line is crossed that passes the gap within this many
/// distances of pairs \[1\].
const GAP: f64 = 0.5;
/// Sites of pairs are shaken by this share of the distance of pairs \[1\]: pairs on a lattice along
/// an axis would lie on common spheres, which leaves open whose cells meet there.
const SHAKE: f64 = 1e-6;
/// Key of the draws of these shakes.
const STREAM: u64 = 8;
/// Distances to grooves that differ by less than this share of the diagonal are one \[1\].
const ALIKE: f64 = 1e-9;

/// Sites with the pairs behind them, and the label of each.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct ScoredSites {
    pub(super) sites: Vec<Vec3>,
    pub(super) labels: Vec<u32>,
}

impl ScoredSites {
    /// Each site with a label of its own.
    pub(super) fn plain(sites: Vec<Vec3>) -> Self {
        Self { labels: (0..sites.len() as u32).collect(), sites }
    }

    /// How many labels there are.
    pub(super) fn count(&self) -> usize {
        self.labels.iter().max().map_or(0, |last| *last as usize + 1)
    }
}

/// A groove with its own axes.
#[derive(Clone, Debug)]
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

    /// How much of a way along it lies in a box, from where to where over its length \[1\].
    fn share(&self, way: &Vec3, [low, high]: &[Vec3; 2]) -> Range<f64> {
        let along = |k: usize| {
            let ends = [low[k], high[k]].map(|x| (x - self.from[k]) * way[k]);
            [ends[0].min(ends[1]), ends[0].max(ends[1])]
        };
        let [least, most] = [0, 1].map(|end| (0..3).map(|k| along(k)[end]).sum::<f64>());
        let over = way.norm_squared();
        (least / over).clamp(0.0, 1.0)..(most / over).clamp(0.0, 1.0)
    }

    /// The area of what may lie in a box \[m²\]: nothing where it passes the box by.
    fn area(&self, within: &[Vec3; 2]) -> f64 {
        let corners = [self.from, self.to, self.from + self.down, self.to + self.down];
        let passes = (0..3).any(|k| {
            corners.iter().all(|c| c[k] < within[0][k])
                || corners.iter().all(|c| c[k] > within[1][k])
        });
        if passes {
            return 0.0;
        }
        let length = |way: &Vec3| {
            let share = self.share(way, within);
            way.norm() * (share.end - share.start)
        };
        length(&self.along) * length(&self.down)
    }

    /// The pairs of sites that may lie in a box \[m\], those on the side of its normal first.
    fn pairs(&self, step: f64, within: &[Vec3; 2]) -> Vec<[Vec3; 2]> {
        let places = |way: &Vec3| {
            let count = (way.norm() / step).ceil().max(1.0);
            let share = self.share(way, within);
            let (first, last) = ((share.start * count).floor(), (share.end * count).ceil());
            (first as usize..last as usize).map(move |k| (k as f64 + 0.5) / count)
        };
        let off = self.across * (0.5 * APART * step);
        let mut pairs = Vec::new();
        for down in places(&self.down) {
            for along in places(&self.along) {
                let on = self.from + self.along * along + self.down * down;
                pairs.push([on + off, on - off]);
            }
        }
        pairs
    }
}

/// A scored line: grooves of which each begins where the last ends.
#[derive(Debug)]
struct Line(Vec<Groove>);

impl Line {
    /// Whether a place is on the side that its normals point to. By the groove that it is nearest
    /// to; where two grooves meet, by the one from whose plane it is farther.
    fn is_ahead(&self, place: &Vec3, slack: f64) -> bool {
        let far: Vec<f64> = self.0.iter().map(|groove| groove.off(place).norm()).collect();
        let least = far.iter().copied().fold(f64::INFINITY, f64::min);
        let near = self.0.iter().zip(&far).filter(|(_, far)| **far <= least + slack);
        let sides = near.map(|(groove, _)| groove.side(place));
        sides.fold(0.0_f64, |most, side| if side.abs() > most.abs() { side } else { most }) >= 0.0
    }

    /// Whether the way from one place to another goes through it, or through a gap \[m\] in it.
    fn is_crossed(&self, from: &Vec3, to: &Vec3, gap: f64) -> bool {
        self.0.iter().any(|groove| {
            let [a, b] = [from, to].map(|place| groove.side(place));
            (a >= 0.0) != (b >= 0.0)
                && groove.off(&(from + (to - from) * (a / (a - b)))).norm() <= gap
        })
    }
}

/// Two sites that mirror each other at a groove of a line.
#[derive(Debug)]
struct SitePair {
    line: usize,
    ahead: Vec3,
    behind: Vec3,
}

/// The scored lines of a body. Grooves and pairs that do not touch it are left out.
#[derive(Debug)]
pub(super) struct ScoredLines {
    lines: Vec<Line>,
    pairs: Vec<SitePair>,
    /// Distance of pairs \[m\].
    step: f64,
    /// Distances that differ by less are one \[m\].
    slack: f64,
}

impl ScoredLines {
    /// Nothing where no line touches the body.
    pub(super) fn of(scored: &[Region], mesh: &TriMesh, seed: u64) -> Option<Self> {
        let (low, high) = mesh.bounds()?;
        let diagonal = mesh.diagonal();
        let margin = Vec3::repeat(STEP * diagonal);
        let within = [low - margin, high + margin];
        let mut grooves: Vec<Groove> = scored.iter().filter_map(Groove::of).collect();
        grooves.retain(|groove| groove.area(&within) > 0.0);
        if grooves.is_empty() {
            return None;
        }
        let area: f64 = grooves.iter().map(|groove| groove.area(&within)).sum();
        let step = (STEP * diagonal).max((area / MANY_PAIRS).sqrt());
        let chunks = grooves.chunk_by(|last, next| last.to == next.from);
        let lines: Vec<Line> = chunks.map(|chunk| Line(chunk.to_vec())).collect();
        let (inside, nearest) = (Inside::new(mesh), Nearest::new(mesh));
        let is_near = |p: Vec3| inside.contains(p) || nearest.distance(p) < CLEAR * step;
        let mut pairs = Vec::new();
        for (line, Line(grooves)) in lines.iter().enumerate() {
            let all = grooves.iter().flat_map(|groove| groove.pairs(step, &within));
            for [ahead, behind] in all.filter(|[a, b]| is_near((a + b) * 0.5)) {
                let at = |k| SHAKE * step * (unit(seed, STREAM, 6 * pairs.len() as u64 + k) - 0.5);
                let ahead = ahead + Vec3::new(at(0), at(1), at(2));
                let behind = behind + Vec3::new(at(3), at(4), at(5));
                pairs.push(SitePair { line, ahead, behind });
            }
        }
        let slack = ALIKE * diagonal;
        (!pairs.is_empty()).then_some(Self { lines, pairs, step, slack })
    }

    /// The sites of a pattern, moved off the grooves, and the pairs that keep its cracks on these.
    pub(super) fn along(&self, sites: &[Vec3]) -> ScoredSites {
        let own = self.cleared(sites);
        let owner = |place: &Vec3| -> usize {
            let far = |site: &Vec3| (site - place).norm_squared();
            let nearest = own.iter().enumerate().min_by(|a, b| far(a.1).total_cmp(&far(b.1)));
            nearest.map_or(0, |(k, _)| k)
        };
        let sides = |place: &Vec3| -> Vec<bool> {
            self.lines.iter().map(|line| line.is_ahead(place, self.slack)).collect()
        };
        let own_sides: Vec<Vec<bool>> = own.iter().map(sides).collect();
        let mut scored = ScoredSites::plain(own.clone());
        let mut parted = BTreeMap::new();
        for pair in &self.pairs {
            for (place, ahead) in [(pair.ahead, true), (pair.behind, false)] {
                let cell = owner(&place);
                let parts = |(k, line): (usize, &Line)| match k == pair.line {
                    true => ahead != own_sides[cell][k],
                    false => {
                        line.is_crossed(&place, &own[cell], GAP * self.step)
                            && line.is_ahead(&place, self.slack) != own_sides[cell][k]
                    }
                };
                let lines: Vec<bool> = self.lines.iter().enumerate().map(parts).collect();
                let next = (own.len() + parted.len()) as u32;
                scored.labels.push(match lines.contains(&true) {
                    false => cell as u32,
                    true => *parted.entry((cell, lines)).or_insert(next),
                });
                scored.sites.push(place);
            }
        }
        scored
    }

    /// Sites moved off the grooves, without those for which there is no room between these; one at
    /// least.
    fn cleared(&self, sites: &[Vec3]) -> Vec<Vec3> {
        let clear = CLEAR * self.step;
        let grooves = || self.lines.iter().flat_map(|line| &line.0);
        let mut own = sites.to_vec();
        for site in &mut own {
            for _ in 0..MOVES {
                for groove in grooves() {
                    let off = groove.off(site);
                    if off.norm() < clear {
                        let way = off.try_normalize(self.slack).unwrap_or(groove.across);
                        *site += way * clear - off;
                    }
                }
            }
        }
        let is_clear = |site: &Vec3| grooves().all(|g| g.off(site).norm() > clear - self.slack);
        if own.iter().any(is_clear) {
            own.retain(is_clear);
        } else {
            own.truncate(1);
        }
        own
    }
}
