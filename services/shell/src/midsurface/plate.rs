//! The midsurface of a flat plate of any outline: a rectangle of cells, trimmed.
//!
//! Points outside the outline are off, those on it count for the share of their area that is
//! inside: the rule for control points is the same as at cracks.

use super::Midsurface;
use cullet_geometry::inside::Inside;
use cullet_geometry::nurbs::{NurbsError, NurbsPatch};
use cullet_geometry::plate::Plate;
use cullet_geometry::{Pose, Vec3};

/// Places along a side of a point's area that are looked at.
const LOOKS: usize = 4;

/// Least share of a point's area inside the outline for the point to count.
const LEAST_SHARE: f64 = 0.25;

/// Fewest cells along a side.
const FEWEST: usize = 3;

/// A place in another frame.
pub(crate) fn placed(pose: &Pose, x: &Vec3) -> Vec3 {
    pose.rotation * x + pose.translation.vector
}

impl Midsurface {
    /// Of a plate whose body `inside` tells, in the plate's frame, with cells of about `spacing`
    /// \[m\] in rows that are turned by `turn` \[rad\].
    ///
    /// # Errors
    /// None that a plate of some size has.
    pub fn of_plate(
        plate: &Plate,
        inside: &Inside,
        spacing: f64,
        turn: f64,
    ) -> Result<Self, NurbsError> {
        let (sin, cos) = libm::sincos(turn);
        let [a, b] = plate.size;
        let size = [a * cos + b * sin.abs(), a * sin.abs() + b * cos];
        let cells = size.map(|s| ((s / spacing).round() as usize).max(FEWEST));
        let patch = NurbsPatch::sheet(size, cells, 2)?;
        let mut surface = Self::of_patch(&patch);
        surface.trim(plate, inside, [size[0], size[1], sin, cos], cells);
        for node in &mut surface.nodes {
            *node = Vec3::new(cos * node.x - sin * node.y, sin * node.x + cos * node.y, node.z);
        }
        Ok(surface)
    }

    /// Finds the share of each point.
    fn trim(
        &mut self,
        plate: &Plate,
        inside: &Inside,
        [width, height, sin, cos]: [f64; 4],
        cells: [usize; 2],
    ) {
        let size = [width, height];
        let cell = [0, 1].map(|k| size[k] / cells[k] as f64);
        let is_in = |x: f64, y: f64| {
            let at = Vec3::new(cos * x - sin * y, sin * x + cos * y, 0.0);
            inside.contains(placed(&plate.pose, &at))
        };
        let corner = |k: usize, i: usize| i as f64 * cell[k] - 0.5 * size[k];
        // Corners of cells, moved in a little at the rim, first: most cells are far from it.
        let near = |k: usize, i: usize| {
            let least = 1e-3 * cell[k];
            corner(k, i).clamp(least - 0.5 * size[k], 0.5 * size[k] - least)
        };
        let wide = cells[0] + 1;
        let corners: Vec<bool> = (0..wide * (cells[1] + 1))
            .map(|n| is_in(near(0, n % wide), near(1, n / wide)))
            .collect();
        let all_around = |i: usize, j: usize| {
            let rows = j.saturating_sub(1)..=(j + 2).min(cells[1]);
            rows.into_iter().all(|y| {
                (i.saturating_sub(1)..=(i + 2).min(cells[0])).all(|x| corners[y * wide + x])
            })
        };
        for (c, shares) in self.share.chunks_mut(4).enumerate() {
            let (i, j) = (c % cells[0], c / cells[0]);
            if all_around(i, j) {
                continue;
            }
            for (q, share) in shares.iter_mut().enumerate() {
                let start = [corner(0, i), corner(1, j)];
                let part = [q % 2, q / 2];
                let at = |k: usize, n: usize| {
                    let along = (n as f64 + 0.5) / LOOKS as f64;
                    start[k] + 0.5 * cell[k] * (part[k] as f64 + along)
                };
                let looks =
                    (0..LOOKS * LOOKS).filter(|n| is_in(at(0, n % LOOKS), at(1, n / LOOKS)));
                *share = looks.count() as f64 / (LOOKS * LOOKS) as f64;
                *share = if *share < LEAST_SHARE { 0.0 } else { *share };
            }
        }
    }
}
