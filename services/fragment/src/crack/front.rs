//! When the crack passed, and which way it ran: damage time as a plane fitted to the nodes around.

use super::nodes::LatticeNodes;
use crate::region::terms::FrontSample;
use cullet_geometry::{Mat3, Vec3};

/// Fewest nodes with a time for a direction.
const FEWEST: usize = 6;
/// Directions in which the nodes spread less than this share of the widest tell nothing: a band is
/// thin.
const THIN: f64 = 0.004;

impl LatticeNodes {
    /// The damage time at a place and its gradient, by least squares over the nodes that have a
    /// time of their own within `reach` \[units\] along every axis: masked, so what lies off the
    /// band does not count (F35). `None` where too few have.
    pub(crate) fn front(&self, place: Vec3, reach: f64) -> Option<FrontSample> {
        let lattice = &self.lattice;
        let radius = reach.max(1.0);
        let (mut weights, mut count) = (0.0, 0);
        let (mut mean, mut time) = (Vec3::zeros(), 0.0);
        let (mut spread, mut slope) = (Mat3::zeros(), Vec3::zeros());
        let node = lattice.node(lattice.nearest(place));
        for i in lattice.around(node, self.steps(radius)) {
            if !self.damage.known[i] {
                continue;
            }
            let arm = (self.damage.centroid[i] - place) / self.unit;
            let w: f64 = lattice
                .along(arm)
                .iter()
                .map(|x| (1.0 - x * x / (radius + 0.5) / (radius + 0.5)).max(0.0))
                .product();
            weights += w;
            count += usize::from(w > 0.0);
            mean += w * arm;
            time += w * self.damage.time[i];
            spread += w * arm * arm.transpose();
            slope += w * self.damage.time[i] * arm;
        }
        if count < FEWEST {
            return None;
        }
        (mean, time) = (mean / weights, time / weights);
        spread = spread / weights - mean * mean.transpose();
        slope = slope / weights - time * mean;
        let widest = spread.trace();
        let inverse = (spread + Mat3::identity() * (THIN * widest)).try_inverse()?;
        let slope = inverse * slope;
        Some(FrontSample { time: time - slope.dot(&mean), slope: slope / self.unit })
    }

    /// The damage time of the node nearest to a place \[s\]; zero where it has none.
    pub(crate) fn time_at(&self, place: Vec3) -> f64 {
        let time = self.damage.time[self.lattice.nearest(place)];
        if time.is_finite() { time } else { 0.0 }
    }

    /// Whether material is at hand: a node inside the body within one spacing along every axis.
    pub(super) fn is_near_body(&self, place: Vec3) -> bool {
        let node = self.lattice.node(self.lattice.nearest(place));
        self.lattice.around(node, 1).any(|i| self.is_inside(i))
    }
}
