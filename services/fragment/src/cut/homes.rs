//! Which of several solids a point belongs to.

use cullet_geometry::inside::{Inside, Nearest};
use cullet_geometry::{Solid, Vec3};
use std::collections::BTreeMap;

/// Tells which of several solids a point belongs to.
pub(super) struct Homes(BTreeMap<u32, (Inside, Nearest)>);

impl Homes {
    pub(super) fn new<'a>(solids: impl Iterator<Item = (u32, &'a Solid)>) -> Self {
        let tests = |s: &Solid| (Inside::new(&s.mesh), Nearest::new(&s.mesh));
        Self(solids.map(|(name, solid)| (name, tests(solid))).collect())
    }

    /// The one of `among` (at least one) that contains the point, or else the closest.
    pub(super) fn of(&self, point: Vec3, among: &[u32]) -> u32 {
        if let Some(&home) = among.iter().find(|name| self.0[name].0.contains(point)) {
            return home;
        }
        let distance = |name: &u32| self.0[name].1.distance(point);
        let nearer = |a: &&u32, b: &&u32| distance(a).total_cmp(&distance(b));
        among.iter().min_by(nearer).copied().unwrap_or_default()
    }
}
