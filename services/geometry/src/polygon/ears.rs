//! Triangles of a polygon that is not flat.
//!
//! What such a polygon encloses depends on how it is split. Ears are cut here in the order in which
//! Blender's modelling code cuts them, so that a file has the volume that it has there: go round
//! from the first corner and leave two corners between one ear and the next; where the corner to go
//! on with is hollow, turn round.

use crate::math::Vec3;

/// How a corner bends, from the sign of the area of it and its neighbours.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Bend {
    Hollow,
    Straight,
    Ear,
}

/// Corners as they are seen along the polygon's normal, from where they go round to the left, in a
/// ring from which cut corners are missing.
struct Ring {
    places: Vec<[f64; 2]>,
    bends: Vec<Bend>,
    next: Vec<usize>,
    previous: Vec<usize>,
    /// How many corners are left, and how many of them are no ears.
    left: usize,
    not_ears: usize,
}

/// The triangles; nothing if no ear is left before the end, or for a polygon without an area.
pub(super) fn cut_ears(corners: &[Vec3], normal: &Vec3) -> Option<Vec<[u32; 3]>> {
    let mut ring = Ring::of(corners, normal)?;
    let mut triangles = Vec::with_capacity(corners.len() - 2);
    let (mut from, mut back) = (0, false);
    while ring.left > 3 {
        let ear = ring.find_ear(from, back)?;
        let [before, after] = [ring.previous[ear], ring.next[ear]];
        triangles.push([before, ear, after].map(|k| k as u32));
        ring.cut(ear);
        from = if back { ring.previous[before] } else { ring.next[after] };
        if ring.bends[from] != Bend::Ear {
            from = if back { ring.previous[from] } else { ring.next[from] };
            back = !back;
        }
    }
    let last = ring.next[from];
    triangles.push([from, last, ring.next[last]].map(|k| k as u32));
    Some(triangles)
}

impl Ring {
    fn of(corners: &[Vec3], normal: &Vec3) -> Option<Self> {
        let normal = normal.try_normalize(0.0)?;
        // Any axis that the normal does not lie along.
        let right = Vec3::ith(normal.iamin(), 1.0).cross(&normal).normalize();
        let up = normal.cross(&right);
        let about = |corner: &Vec3| corner - corners[0];
        let count = corners.len();
        let mut ring = Self {
            places: corners.iter().map(|c| [about(c).dot(&right), about(c).dot(&up)]).collect(),
            bends: vec![Bend::Ear; count],
            next: (0..count).map(|k| (k + 1) % count).collect(),
            previous: (0..count).map(|k| (k + count - 1) % count).collect(),
            left: count,
            not_ears: 0,
        };
        for corner in 0..count {
            ring.bends[corner] = ring.bend(corner);
        }
        ring.not_ears = ring.bends.iter().filter(|&&bend| bend != Bend::Ear).count();
        Some(ring)
    }

    /// Twice the area of a triangle, positive to the left.
    fn area(&self, [a, b, c]: [usize; 3]) -> f64 {
        let [a, b, c] = [a, b, c].map(|k| self.places[k]);
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    }

    fn bend(&self, corner: usize) -> Bend {
        let area = self.area([self.previous[corner], corner, self.next[corner]]);
        if area > 0.0 {
            Bend::Ear
        } else if area < 0.0 {
            Bend::Hollow
        } else {
            Bend::Straight
        }
    }

    /// The first ear on the way; where none is left, the first straight corner.
    fn find_ear(&self, from: usize, back: bool) -> Option<usize> {
        let on =
            |&corner: &usize| Some(if back { self.previous[corner] } else { self.next[corner] });
        [Bend::Ear, Bend::Straight].into_iter().find_map(|bend| {
            let mut round = std::iter::successors(Some(from), on).take(self.left);
            round.find(|&corner| self.may_be_cut(corner, bend))
        })
    }

    /// Whether no other corner lies in the triangle that would be cut off. Only a corner that is no
    /// ear can lie there.
    fn may_be_cut(&self, corner: usize, bend: Bend) -> bool {
        if self.not_ears == 0 {
            return true;
        }
        if self.bends[corner] != bend {
            return false;
        }
        let [before, after] = [self.previous[corner], self.next[corner]];
        let inside = |k: usize| {
            let sides = [[after, before], [before, corner], [corner, after]];
            sides.into_iter().all(|[a, b]| self.area([a, b, k]) >= 0.0)
        };
        let mut other = self.next[after];
        while other != before {
            if self.bends[other] != Bend::Ear && inside(other) {
                return false;
            }
            other = self.next[other];
        }
        true
    }

    /// Takes a corner out. A neighbour that was an ear stays one.
    fn cut(&mut self, corner: usize) {
        let [before, after] = [self.previous[corner], self.next[corner]];
        self.next[before] = after;
        self.previous[after] = before;
        self.left -= 1;
        self.not_ears -= usize::from(self.bends[corner] != Bend::Ear);
        for neighbour in [before, after] {
            if self.bends[neighbour] != Bend::Ear {
                self.bends[neighbour] = self.bend(neighbour);
                self.not_ears -= usize::from(self.bends[neighbour] == Bend::Ear);
            }
        }
    }
}
