//! A base that a sheet clings to at all of its points: each is pulled back to where it was at rest.

use crate::prepared::PreparedMembrane;
use cullet_geometry::Vec3;
use nalgebra::Point3;

/// A base, by point.
#[derive(Clone, Debug)]
pub(crate) struct ClingingBase {
    /// k_b A \[N/m\].
    stiffness: Vec<f64>,
    /// Where each point is at rest \[m\].
    rest: Vec<Vec3>,
}

impl ClingingBase {
    /// None where the sheet has no base.
    pub(crate) fn new(prepared: &PreparedMembrane) -> Option<Self> {
        let sheet = prepared.sheet();
        let by_area = sheet.foundation.filter(|by_area| *by_area > 0.0)?;
        let points = &prepared.points;
        let place = |&[x, y]: &[f64; 2]| (sheet.pose * Point3::new(x, y, 0.0)).coords;
        Some(Self {
            stiffness: points.areas.iter().map(|area| by_area * area).collect(),
            rest: points.places.iter().map(place).collect(),
        })
    }

    /// Adds its forces \[N\].
    pub(crate) fn pull(&self, places: &[Vec3], forces: &mut [Vec3]) {
        let rows = self.stiffness.iter().zip(&self.rest).zip(places);
        for (force, ((k, rest), x)) in forces.iter_mut().zip(rows) {
            *force += (rest - x) * *k;
        }
    }

    /// What it stores at points that are not gone \[J\].
    pub(crate) fn energy(&self, places: &[Vec3], gone: &[bool]) -> f64 {
        let one = |i: usize| 0.5 * self.stiffness[i] * (places[i] - self.rest[i]).norm_squared();
        (0..places.len()).filter(|&i| !gone[i]).map(one).sum()
    }

    /// Work of its forces at these places in a step, by the velocities before and after it \[J\].
    pub(crate) fn work(&self, places: &[Vec3], before: &[Vec3], after: &[Vec3], dt: f64) -> f64 {
        let one = |i: usize| {
            let middle = 0.5 * (before[i] + after[i]);
            self.stiffness[i] * (self.rest[i] - places[i]).dot(&middle)
        };
        dt * (0..places.len()).map(one).sum::<f64>()
    }
}
