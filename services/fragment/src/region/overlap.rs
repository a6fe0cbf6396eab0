//! Which triangles of a mosaic cross each other. Faces that share corners meet there and nowhere
//! else, so cells that fill a box go on filling it, without overlap, as long as no two cross.

use cullet_geometry::Vec3;
use rayon::prelude::*;

/// Neighbours whose planes enclose less than this angle are folded onto each other: cos 1°.
const FOLDED: f64 = 0.99985;

/// The triangles that cross another or are folded onto a neighbour, in order.
pub(crate) fn crossing(places: &[Vec3], triangles: &[[u32; 3]]) -> Vec<u32> {
    crossing_of(places, triangles, |_| true)
}

/// As [`crossing`], of pairs of which one has a corner that is `moved`.
pub(crate) fn crossing_of(
    places: &[Vec3],
    triangles: &[[u32; 3]],
    moved: impl Fn(u32) -> bool + Sync,
) -> Vec<u32> {
    let moved: Vec<bool> = triangles.par_iter().map(|t| t.iter().any(|&v| moved(v))).collect();
    let boxes: Vec<(Vec3, Vec3)> = triangles
        .par_iter()
        .map(|t| {
            let [a, b, c] = t.map(|i| places[i as usize]);
            (a.inf(&b).inf(&c), a.sup(&b).sup(&c))
        })
        .collect();
    let Some(grid) = TriangleBuckets::new(&boxes) else {
        return Vec::new();
    };
    let entries = grid.entries(&boxes);
    let cells: Vec<&[(u64, u32)]> = entries.chunk_by(|a, b| a.0 == b.0).collect();
    let test = |cell: &[(u64, u32)]| {
        let mut found = Vec::new();
        if !cell.iter().any(|entry| moved[entry.1 as usize]) {
            return found;
        }
        for (k, &(key, s)) in cell.iter().enumerate() {
            let (low, high) = boxes[s as usize];
            for &(_, t) in &cell[k + 1..] {
                let (from, to) = boxes[t as usize];
                let apart = (0..3).any(|k| from[k] > high[k] || to[k] < low[k]);
                // A pair is looked at in one cell only: that of the lower corner of the overlap.
                if !apart
                    && (moved[s as usize] || moved[t as usize])
                    && grid.key(grid.cell(low.sup(&from))) == key
                    && cross(places, triangles[s as usize], triangles[t as usize])
                {
                    found.extend([s, t]);
                }
            }
        }
        found
    };
    let mut found: Vec<u32> = cells.par_iter().flat_map_iter(|cell| test(cell)).collect();
    found.sort_unstable();
    found.dedup();
    found
}

/// Square buckets about the size of a triangle.
struct TriangleBuckets {
    low: Vec3,
    width: f64,
    dims: [u64; 3],
}

impl TriangleBuckets {
    fn new(boxes: &[(Vec3, Vec3)]) -> Option<Self> {
        let &(first, _) = boxes.first()?;
        let (low, high) =
            boxes.iter().fold((first, first), |(low, high), b| (low.inf(&b.0), high.sup(&b.1)));
        let mean = boxes.iter().map(|(a, b)| (b - a).max()).sum::<f64>() / boxes.len() as f64;
        let width = (1.5 * mean).max(1e-3 * (high - low).max());
        let dims = [0, 1, 2].map(|k| ((high[k] - low[k]) / width) as u64 + 1);
        (width > 0.0).then_some(Self { low, width, dims })
    }

    fn cell(&self, place: Vec3) -> [u64; 3] {
        [0, 1, 2].map(|k| (((place[k] - self.low[k]) / self.width) as u64).min(self.dims[k] - 1))
    }

    fn key(&self, cell: [u64; 3]) -> u64 {
        (cell[2] * self.dims[1] + cell[1]) * self.dims[0] + cell[0]
    }

    /// Every triangle with every cell that its box touches, by cell.
    fn entries(&self, boxes: &[(Vec3, Vec3)]) -> Vec<(u64, u32)> {
        let mut entries = Vec::with_capacity(4 * boxes.len());
        for (t, &(low, high)) in boxes.iter().enumerate() {
            let (from, to) = (self.cell(low), self.cell(high));
            for z in from[2]..=to[2] {
                for y in from[1]..=to[1] {
                    for x in from[0]..=to[0] {
                        entries.push((self.key([x, y, z]), t as u32));
                    }
                }
            }
        }
        entries.par_sort_unstable();
        entries
    }
}

/// Whether two triangles meet anywhere but in the corners that they share.
fn cross(places: &[Vec3], s: [u32; 3], t: [u32; 3]) -> bool {
    let at = |i: u32| places[i as usize];
    let shared = |i: &u32| t.contains(i);
    match s.iter().filter(|i| shared(i)).count() {
        0 => {
            let ([a, b, c], [d, e, f]) = (s.map(at), t.map(at));
            let one_side = |v: &[f64; 3]| v.iter().all(|&x| x > 0.0) || v.iter().all(|&x| x < 0.0);
            let over = [d, e, f].map(|x| volume(a, b, c, x));
            if one_side(&over) {
                return false;
            }
            let under = [a, b, c].map(|x| volume(d, e, f, x));
            let through = |edges: [Vec3; 3], heights: &[f64; 3], face: [Vec3; 3]| {
                (0..3).any(|k| {
                    let next = (k + 1) % 3;
                    heights[k] * heights[next] < 0.0 && passes(edges[k], edges[next], face)
                })
            };
            !one_side(&under)
                && (through([a, b, c], &under, [d, e, f]) || through([d, e, f], &over, [a, b, c]))
        }
        1 => {
            let far = |x: [u32; 3], y: [u32; 3]| {
                let k = (0..3).find(|&k| y.contains(&x[k])).unwrap_or(0);
                pierces(at(x[(k + 1) % 3]), at(x[(k + 2) % 3]), y.map(at))
            };
            far(s, t) || far(t, s)
        }
        2 => {
            let lone = |x: [u32; 3], y: [u32; 3]| (0..3).find(|&k| !y.contains(&x[k])).unwrap_or(0);
            let k = lone(s, t);
            let (a, b) = (at(s[(k + 1) % 3]), at(s[(k + 2) % 3]));
            let along = (b - a).normalize();
            let off = |p: Vec3| {
                let arm = p - a;
                arm - along * arm.dot(&along)
            };
            let (p, q) = (off(at(s[k])), off(at(t[lone(t, s)])));
            p.dot(&q) > FOLDED * p.norm() * q.norm()
        }
        _ => true,
    }
}

/// Whether the segment crosses the triangle's inside.
fn pierces(p: Vec3, q: Vec3, [a, b, c]: [Vec3; 3]) -> bool {
    volume(a, b, c, p) * volume(a, b, c, q) < 0.0 && passes(p, q, [a, b, c])
}

/// Whether the line does.
fn passes(p: Vec3, q: Vec3, [a, b, c]: [Vec3; 3]) -> bool {
    let (first, second) = (volume(p, q, a, b), volume(p, q, b, c));
    if first * second < 0.0 {
        return false;
    }
    let turns = [first, second, volume(p, q, c, a)];
    turns.iter().all(|&x| x >= 0.0) || turns.iter().all(|&x| x <= 0.0)
}

/// Six times the signed volume of a tetrahedron \[m³\].
fn volume(a: Vec3, b: Vec3, c: Vec3, d: Vec3) -> f64 {
    (b - a).cross(&(c - a)).dot(&(d - a))
}

#[cfg(test)]
mod tests {
    use super::crossing;
    use cullet_geometry::Vec3;

    #[test]
    fn crossing_and_folded_triangles_are_found_and_meeting_ones_are_not() {
        let p = |x: f64, y: f64, z: f64| Vec3::new(x, y, z);
        let floor = [p(0.0, 0.0, 0.0), p(1.0, 0.0, 0.0), p(0.0, 1.0, 0.0)];
        let with = |more: &[Vec3], t: [u32; 3]| {
            let places: Vec<Vec3> = floor.iter().chain(more).copied().collect();
            crossing(&places, &[[0, 1, 2], t]).len()
        };
        // No corner shared: through the floor, above it.
        assert_eq!(with(&[p(0.2, 0.2, -1.0), p(0.3, 0.2, 1.0), p(0.2, 0.3, 1.0)], [3, 4, 5]), 2);
        assert_eq!(with(&[p(0.2, 0.2, 0.1), p(0.3, 0.2, 1.0), p(0.2, 0.3, 1.0)], [3, 4, 5]), 0);
        // One corner shared: the far edge pierces the floor, or not.
        assert_eq!(with(&[p(0.3, 0.3, -1.0), p(0.3, 0.3, 1.0)], [0, 3, 4]), 2);
        assert_eq!(with(&[p(-0.3, 0.3, -1.0), p(-0.3, 0.3, 1.0)], [0, 3, 4]), 0);
        // An edge shared: folded back, or open.
        assert_eq!(with(&[p(0.5, 0.5, 1e-4)], [1, 0, 3]), 2);
        assert_eq!(with(&[p(0.5, -0.5, 0.0)], [1, 0, 3]), 0);
    }
}
