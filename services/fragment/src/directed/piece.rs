//! A fragment under direction.

use super::guarded::LabelledSites;
use crate::cut::{CutSettings, by_sites};
use cullet_geometry::hull::{HullSettings, convex_parts};
use cullet_geometry::inside::Inside;
use cullet_geometry::{MassProperties, Mat3, Sheet, Solid, Vec3};
use cullet_model::{Fragment, FragmentOrigin};
use std::cmp::Ordering;

/// A fragment under direction.
#[derive(Clone, Debug)]
pub(super) struct DirectedPiece {
    pub(super) fragment: Fragment,
    pub(super) origin: FragmentOrigin,
    pub(super) properties: MassProperties,
    /// Whether it could not be cut.
    pub(super) is_stuck: bool,
    /// Whether it could not be joined to its neighbours.
    pub(super) is_alone: bool,
}

impl DirectedPiece {
    pub(super) fn new((fragment, origin): (Fragment, FragmentOrigin)) -> Self {
        let properties = fragment.solid.mesh.mass_properties();
        let (is_stuck, is_alone) = (false, false);
        Self { fragment, origin, properties, is_stuck, is_alone }
    }

    /// By falling volume, then by place, as parts of a cut.
    pub(super) fn order(a: &Self, b: &Self) -> Ordering {
        let (p, q) = (&a.properties, &b.properties);
        let by_place = || p.centroid.iter().zip(q.centroid.iter()).map(|(x, y)| x.total_cmp(y));
        q.volume
            .total_cmp(&p.volume)
            .then_with(|| by_place().find(|order| order.is_ne()).unwrap_or(Ordering::Equal))
    }

    /// Its parts along the cells of sites, which move as it does, and what the cut warns of;
    /// nothing if it cannot be cut.
    pub(super) fn cut(
        &self,
        LabelledSites { sites, labels }: &LabelledSites,
        settings: &CutSettings,
    ) -> Option<(Vec<Self>, Vec<String>)> {
        let times = vec![0.0; sites.len()];
        let cut = by_sites(&self.fragment.solid, sites, labels, &times, settings).ok()?;
        if cut.parts.len() < 2 {
            return None;
        }
        let Fragment { velocity, spin, sheet, .. } = &self.fragment;
        let part = |part: crate::cut::CutPart| {
            let centroid = part.solid.mesh.mass_properties().centroid;
            let velocity = velocity + spin.cross(&(centroid - self.properties.centroid));
            let sheet = match sheet.is_empty() {
                true => Sheet::default(),
                false => sheet.clipped(&Inside::new(&part.solid.mesh)),
            };
            let (solid, hulls, spin) = (part.solid, part.hulls, *spin);
            let fragment = Fragment { solid, hulls, velocity, spin, sheet };
            Self::new((fragment, FragmentOrigin::Directed))
        };
        Some((cut.parts.into_iter().map(part).collect(), cut.warnings))
    }

    /// Pieces that are one now: the motion has their momentum and angular momentum.
    pub(super) fn joined(of: &[&Self], solid: Solid) -> Self {
        let p = solid.mesh.mass_properties();
        let mass: f64 = of.iter().map(|piece| piece.properties.volume).sum();
        let linear: Vec3 =
            of.iter().map(|piece| piece.fragment.velocity * piece.properties.volume).sum();
        let velocity = linear / mass;
        let about = |piece: &&Self| {
            let MassProperties { volume, centroid, inertia } = piece.properties;
            let Fragment { velocity: own, spin, .. } = &piece.fragment;
            (centroid - p.centroid).cross(own) * volume + inertia * spin
        };
        let angular: Vec3 = of.iter().map(about).sum();
        let inverse: Mat3 = p.inertia.try_inverse().unwrap_or_default();
        let mut sheet = Sheet::default();
        of.iter().for_each(|piece| sheet.append(&piece.fragment.sheet));
        let hulls = convex_parts(&solid, HullSettings::default());
        let fragment = Fragment { solid, hulls, velocity, spin: inverse * angular, sheet };
        Self::new((fragment, FragmentOrigin::Directed))
    }
}
