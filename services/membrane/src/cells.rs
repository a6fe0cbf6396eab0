//! Cells of points in a plane: who is near, and what area is nearest to each.

use crate::outline::{SheetOutline, area_and_centroid};
use cullet_model::SheetPlace;

/// Points by the square of a grid that they lie in.
#[derive(Clone, Debug)]
pub(crate) struct PlaneGrid {
    low: SheetPlace,
    /// Width of a square \[m\].
    width: f64,
    counts: [usize; 2],
    /// First of each square, then their number.
    starts: Vec<u32>,
    /// By square, then by number.
    points: Vec<u32>,
}

impl PlaneGrid {
    /// Sorts points into squares of this width \[m\].
    pub(crate) fn new(places: &[SheetPlace], width: f64) -> Self {
        let (mut low, mut high) = ([0.0; 2], [0.0; 2]);
        for k in 0..2 {
            low[k] = places.iter().map(|p| p[k]).fold(f64::INFINITY, f64::min);
            high[k] = places.iter().map(|p| p[k]).fold(f64::NEG_INFINITY, f64::max);
        }
        let counts = [0, 1].map(|k| ((high[k] - low[k]) / width) as usize + 1);
        let square = |p: &SheetPlace| {
            let at = [0, 1].map(|k| (((p[k] - low[k]) / width) as usize).min(counts[k] - 1));
            at[1] * counts[0] + at[0]
        };
        let mut starts = vec![0u32; counts[0] * counts[1] + 1];
        places.iter().for_each(|p| starts[square(p) + 1] += 1);
        for k in 1..starts.len() {
            starts[k] += starts[k - 1];
        }
        let mut next = starts.clone();
        let mut points = vec![0; places.len()];
        for (i, p) in places.iter().enumerate() {
            let slot = &mut next[square(p)];
            points[*slot as usize] = i as u32;
            *slot += 1;
        }
        Self { low, width, counts, starts, points }
    }

    /// Calls `f` with each point whose square is within `reach` \[m\] of a place.
    pub(crate) fn around(&self, place: SheetPlace, reach: f64, mut f: impl FnMut(u32)) {
        let range = |k: usize| {
            let from = ((place[k] - reach - self.low[k]) / self.width).max(0.0) as usize;
            let to = ((place[k] + reach - self.low[k]) / self.width).max(-1.0);
            let to = if to < 0.0 { 0 } else { (to as usize + 1).min(self.counts[k]) };
            from.min(self.counts[k])..to
        };
        for y in range(1) {
            let row = range(0);
            if row.start < row.end {
                let first = self.starts[y * self.counts[0] + row.start] as usize;
                let last = self.starts[y * self.counts[0] + row.end] as usize;
                self.points[first..last].iter().for_each(|&i| f(i));
            }
        }
    }
}

/// The part of a polygon on the side of a line where `normal · x <= offset`.
fn clip(from: &[SheetPlace], normal: SheetPlace, offset: f64, to: &mut Vec<SheetPlace>) {
    to.clear();
    let height = |p: SheetPlace| normal[0] * p[0] + normal[1] * p[1] - offset;
    for (k, &p) in from.iter().enumerate() {
        let q = from[(k + 1) % from.len()];
        let (a, b) = (height(p), height(q));
        if a <= 0.0 {
            to.push(p);
        }
        if (a < 0.0 && b > 0.0) || (a > 0.0 && b < 0.0) {
            let share = a / (a - b);
            to.push([p[0] + share * (q[0] - p[0]), p[1] + share * (q[1] - p[1])]);
        }
    }
}

/// Area \[m²\] and centroid \[m\] of what is nearest to a point within an outline. A part of the
/// outline farther than four spacings from all points is nobody's.
pub(crate) fn cell(
    outline: &SheetOutline,
    places: &[SheetPlace],
    grid: &PlaneGrid,
    spacing: f64,
    i: usize,
) -> (f64, SheetPlace) {
    let [x, y] = places[i];
    let half = 4.0 * spacing;
    let mut corners = vec![
        [x - half, y - half],
        [x + half, y - half],
        [x + half, y + half],
        [x - half, y + half],
    ];
    let mut other = Vec::new();
    let radius = |corners: &[SheetPlace]| {
        let squared = |p: &SheetPlace| (p[0] - x) * (p[0] - x) + (p[1] - y) * (p[1] - y);
        corners.iter().map(squared).fold(0.0, f64::max).sqrt()
    };
    // Most cells are closed by what is within three spacings.
    let mut done = 0.0;
    for reach in [3.0 * spacing, 3.0 * half] {
        let mut near: Vec<(f64, u32)> = Vec::new();
        grid.around(places[i], reach, |j| {
            let [a, b] = places[j as usize];
            let squared = (a - x) * (a - x) + (b - y) * (b - y);
            if j as usize != i && squared > done * done && squared <= reach * reach {
                near.push((squared, j));
            }
        });
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for (squared, j) in near {
            if squared.sqrt() > 2.0 * radius(&corners) {
                break;
            }
            let [a, b] = places[j as usize];
            let normal = [a - x, b - y];
            let offset = 0.5 * (normal[0] * (a + x) + normal[1] * (b + y));
            clip(&corners, normal, offset, &mut other);
            std::mem::swap(&mut corners, &mut other);
        }
        done = reach;
        if 2.0 * radius(&corners) <= reach {
            break;
        }
    }
    if outline.distance(places[i]) >= radius(&corners) {
        return area_and_centroid(&corners);
    }
    let mut part = outline.corners.clone();
    for (k, a) in corners.iter().enumerate() {
        let b = corners[(k + 1) % corners.len()];
        let normal = [b[1] - a[1], a[0] - b[0]];
        clip(&part, normal, normal[0] * a[0] + normal[1] * a[1], &mut other);
        std::mem::swap(&mut part, &mut other);
    }
    area_and_centroid(&part)
}
