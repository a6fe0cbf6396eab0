//! Chevron lines: the way the crack ran, as flow lines of the damage time over the crack faces
//! (thesis 3.7, Algorithm 4, corrected as in F35).

use super::sheet::CellSheet;
use super::terms::{FrontSample, ReliefTerms};
use cullet_geometry::Vec3;
use cullet_geometry::math::unit;

const NONE: u32 = u32::MAX;
/// A line ends where no corner is this near \[edges\].
const LOST: f64 = 1.6;

/// A point of a chevron line.
#[derive(Clone, Copy, Debug)]
struct ChevronPoint {
    place: Vec3,
    /// β, with the sign and the size of its line, over its most \[1\].
    height: f64,
}

/// The lines over all faces.
#[derive(Debug)]
pub(super) struct Flow<'a> {
    sheet: &'a CellSheet,
    /// Where the crack ran, along the face; zero where nobody knows.
    way: Vec<Vec3>,
    marks: Vec<ChevronPoint>,
    near: Buckets,
    /// Radius of a mark's influence on heights \[m\].
    radius: f64,
    speed: f64,
}

impl<'a> Flow<'a> {
    pub(super) fn new(
        sheet: &'a CellSheet,
        fronts: &[Option<FrontSample>],
        terms: &ReliefTerms,
    ) -> Self {
        let least = terms.time_step / terms.spacing;
        let way: Vec<Vec3> = fronts
            .iter()
            .zip(&sheet.normal)
            .map(|(front, normal)| {
                let slope = front.map_or_else(Vec3::zeros, |front| front.slope);
                let along = slope - normal * normal.dot(&slope);
                // F35: a gradient is a direction; below a time step per spacing it is noise.
                let known = *normal != Vec3::zeros() && along.norm() > least;
                if known { along.normalize() } else { Vec3::zeros() }
            })
            .collect();
        let runs = |v: &usize| way[*v] != Vec3::zeros();
        let slopes: Vec<f64> = (0..way.len())
            .filter(runs)
            .filter_map(|v| fronts[v].map(|front| front.slope.norm()))
            .collect();
        let mean = slopes.iter().sum::<f64>() / slopes.len().max(1) as f64;
        let speed = if mean > 0.0 { 1.0 / mean } else { 0.0 };
        let lines = Tracer::new(sheet, &way, fronts, terms).lines();
        let marks = marks(&lines, terms);
        let radius = 1.5 * terms.detail.grid.max(terms.detail.influence) * terms.spacing;
        let near = Buckets::new(marks.iter().map(|mark| mark.place), radius);
        Self { sheet, way, marks, near, radius, speed }
    }

    /// Mean front speed \[m/s\]; zero if unknown.
    pub(super) fn speed(&self) -> f64 {
        self.speed
    }

    /// Whether the direction of the crack is known at a corner.
    pub(super) fn runs(&self, v: usize) -> bool {
        self.way[v] != Vec3::zeros()
    }

    /// The height that the lines around give a corner, in [−1, 1].
    pub(super) fn height(&self, v: usize) -> f64 {
        let place = self.sheet.places[v];
        let (mut sum, mut weights) = (0.0, 0.0);
        self.near.around(place, |k| {
            let mark = &self.marks[k as usize];
            let q = (mark.place - place).norm_squared() / (self.radius * self.radius);
            if q < 1.0 {
                // Steep in the middle: ledges between lines, not hills.
                let weight = (1.0 - q) * (1.0 - q) / (q + 0.03);
                sum += weight * mark.height;
                weights += weight;
            }
        });
        if weights > 0.0 { sum / weights } else { 0.0 }
    }
}

/// A chevron line: where it begins, and its points.
struct ChevronLine {
    start: u32,
    points: Vec<Vec3>,
}

struct Tracer<'a> {
    sheet: &'a CellSheet,
    way: &'a [Vec3],
    order: Vec<u32>,
    near: Buckets,
    owner: Vec<u32>,
    step: f64,
    most: usize,
    keep_off: f64,
}

impl<'a> Tracer<'a> {
    fn new(
        sheet: &'a CellSheet,
        way: &'a [Vec3],
        fronts: &[Option<FrontSample>],
        terms: &ReliefTerms,
    ) -> Self {
        let mut order: Vec<u32> =
            (0..way.len() as u32).filter(|&v| way[v as usize] != Vec3::zeros()).collect();
        let time = |v: &u32| fronts[*v as usize].map_or(f64::INFINITY, |front| front.time);
        order.sort_by(|v, w| time(v).total_cmp(&time(w)).then(v.cmp(w)));
        let h = terms.spacing;
        let step = terms.detail.edge * h;
        let keep_off = terms.detail.influence * h;
        let near = Buckets::new(sheet.places.iter().copied(), keep_off.max(LOST * step));
        let most = (terms.detail.length * h / step).ceil() as usize;
        let owner = vec![NONE; way.len()];
        Self { sheet, way, order, near, owner, step, most, keep_off }
    }

    /// One line from every corner that no line has come near, the earliest first.
    fn lines(mut self) -> Vec<ChevronLine> {
        let mut lines = Vec::new();
        for start in std::mem::take(&mut self.order) {
            if self.owner[start as usize] == NONE {
                let name = lines.len() as u32;
                let points = self.trace(start as usize, name);
                lines.push(ChevronLine { start, points });
            }
        }
        lines
    }

    fn trace(&mut self, start: usize, name: u32) -> Vec<Vec3> {
        let mut at = self.sheet.places[start];
        let mut v = start;
        let mut points = vec![at];
        self.claim(at, name);
        for _ in 0..self.most {
            at += self.step * self.way[v];
            let Some(next) = self.corner(at) else { break };
            let normal = self.sheet.normal[next];
            at -= normal * normal.dot(&(at - self.sheet.places[next]));
            points.push(at);
            if self.owner[next] != NONE && self.owner[next] != name {
                break;
            }
            self.claim(at, name);
            v = next;
        }
        points
    }

    /// The nearest corner where the way is known.
    fn corner(&self, at: Vec3) -> Option<usize> {
        let mut best: Option<(f64, u32)> = None;
        self.near.around(at, |v| {
            let far = (self.sheet.places[v as usize] - at).norm_squared();
            let known = self.way[v as usize] != Vec3::zeros();
            if known && best.is_none_or(|(least, w)| (far, v) < (least, w)) {
                best = Some((far, v));
            }
        });
        let most = LOST * self.step;
        best.filter(|&(far, _)| far <= most * most).map(|(_, v)| v as usize)
    }

    fn claim(&mut self, at: Vec3, name: u32) {
        let Self { near, owner, sheet, keep_off, .. } = self;
        near.around(at, |v| {
            let close = (sheet.places[v as usize] - at).norm() <= *keep_off;
            if close && owner[v as usize] == NONE {
                owner[v as usize] = name;
            }
        });
        if let Some(v) = self.corner(at)
            && self.owner[v] == NONE
        {
            self.owner[v] = name;
        }
    }
}

/// β = 1 along every line; the longest ones grow by r, the share of the way behind (F35).
fn marks(lines: &[ChevronLine], terms: &ReliefTerms) -> Vec<ChevronPoint> {
    let mut by_length: Vec<usize> = (0..lines.len()).collect();
    by_length.sort_by_key(|&k| (std::cmp::Reverse(lines[k].points.len()), k));
    let enhanced = (terms.detail.share * lines.len() as f64).round() as usize;
    let mut grows = vec![false; lines.len()];
    by_length[..enhanced.min(lines.len())].iter().for_each(|&k| grows[k] = true);
    let mut marks = Vec::new();
    for (line, grows) in lines.iter().zip(grows) {
        let random = 2.0 * unit(terms.seed, 55, u64::from(line.start)) - 1.0;
        let size = random.signum() * (0.25 + 0.75 * random.abs());
        let last = (line.points.len() - 1).max(1) as f64;
        for (k, &place) in line.points.iter().enumerate() {
            let r = if grows { k as f64 / last } else { 0.0 };
            marks.push(ChevronPoint { place, height: size * 0.5 * (1.0 + r) });
        }
    }
    marks
}

/// Points by cubes of a grid, for those within one cube's width.
#[derive(Debug)]
struct Buckets {
    low: Vec3,
    width: f64,
    dims: [usize; 3],
    first: Vec<u32>,
    members: Vec<u32>,
}

/// Most cubes of a grid.
const CUBES: f64 = 4e6;

impl Buckets {
    fn new(points: impl Iterator<Item = Vec3>, width: f64) -> Self {
        let points: Vec<Vec3> = points.collect();
        let (low, high) = cullet_geometry::mesh::bounds(&points).unwrap_or_default();
        let size = high - low;
        let width = width.max(libm::cbrt(size.iter().map(|s| s + width).product::<f64>() / CUBES));
        let dims = [0, 1, 2].map(|k| (size[k] / width) as usize + 1);
        let mut buckets = Self { low, width, dims, first: Vec::new(), members: Vec::new() };
        let cubes: Vec<usize> = points.iter().map(|&p| buckets.index(buckets.cube(p))).collect();
        buckets.first = vec![0; dims.iter().product::<usize>() + 1];
        cubes.iter().for_each(|&c| buckets.first[c + 1] += 1);
        for c in 1..buckets.first.len() {
            buckets.first[c] += buckets.first[c - 1];
        }
        let mut next = buckets.first.clone();
        buckets.members = vec![0; points.len()];
        for (k, c) in cubes.into_iter().enumerate() {
            buckets.members[next[c] as usize] = k as u32;
            next[c] += 1;
        }
        buckets
    }

    fn cube(&self, place: Vec3) -> [usize; 3] {
        let at = (place - self.low) / self.width;
        [0, 1, 2].map(|k| (at[k].max(0.0) as usize).min(self.dims[k] - 1))
    }

    fn index(&self, cube: [usize; 3]) -> usize {
        (cube[2] * self.dims[1] + cube[1]) * self.dims[0] + cube[0]
    }

    /// Visits all points within one width, and some more, in a fixed order.
    fn around(&self, place: Vec3, mut visit: impl FnMut(u32)) {
        let cube = self.cube(place);
        let from = cube.map(|c| c.saturating_sub(1));
        let to = [0, 1, 2].map(|k| (cube[k] + 1).min(self.dims[k] - 1));
        for z in from[2]..=to[2] {
            for y in from[1]..=to[1] {
                let (a, b) = (self.index([from[0], y, z]), self.index([to[0], y, z]));
                let row = self.first[a] as usize..self.first[b + 1] as usize;
                self.members[row].iter().for_each(|&k| visit(k));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{ChevronLine, marks};
    use crate::region::terms::ReliefTerms;
    use cullet_geometry::Vec3;
    use cullet_model::CrackFaceDetail;

    #[test]
    fn chevrons_rise_away_from_where_they_began() {
        // F35: the seed's β + (1 − r) is highest at the source.
        let line =
            |start, n| ChevronLine { start, points: (0..n).map(|_| Vec3::zeros()).collect() };
        let detail = CrackFaceDetail { share: 0.5, ..CrackFaceDetail::NONE };
        let terms = ReliefTerms { detail, spacing: 1.0, time_step: 0.0, seed: 4 };
        let marks = marks(&[line(0, 11), line(1, 5)], &terms);
        let heights: Vec<f64> = marks.iter().map(|mark| mark.height.abs()).collect();
        assert!(heights[..11].windows(2).all(|w| w[1] > w[0]), "{heights:?}");
        assert!((heights[10] / heights[0] - 2.0).abs() < 1e-12);
        // Only the longer half of the lines is enhanced.
        assert!(heights[11..].windows(2).all(|w| w[1] == w[0]));
        assert!(heights.iter().all(|&h| h > 0.0 && h <= 1.0));
    }
}
