//! A document on its way to a job: what is known of it, and the errors so far.

use super::format::{self, BoxSide, SpecimenDocument};
use super::paths::{below, item};
use cullet_document::error::suggest;
use cullet_document::files::Files;
use cullet_document::tree::{Node, Step, show};
use cullet_geometry::Vec3;
use cullet_model::strength::Region;
use cullet_scene::context::ResolveContext;
use cullet_scene::direction;
use cullet_specimen::Where;
use std::collections::BTreeMap;

/// What a name of a region is used for: a side of the specimen has no depth for what acts on it,
/// and one spacing for what is read off points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Use {
    Surface,
    Points,
}

/// A document on its way to a job.
pub(super) struct SpecimenBuilder<'a> {
    pub(super) shop: ResolveContext<'a>,
    pub(super) bounds: (Vec3, Vec3),
    pub(super) spacing: f64,
    regions: BTreeMap<String, Vec<format::RegionPart>>,
    /// Why the body cannot be made.
    pub(super) flaws: Vec<String>,
}

impl<'a> SpecimenBuilder<'a> {
    pub(super) fn new(root: &'a Node, files: &'a mut Files) -> Self {
        Self {
            shop: ResolveContext::new(root, files),
            bounds: (Vec3::zeros(), Vec3::zeros()),
            spacing: 1.0,
            regions: BTreeMap::new(),
            flaws: Vec::new(),
        }
    }
}

impl SpecimenBuilder<'_> {
    pub(super) fn wrong(&mut self, path: &[Step], message: impl Into<String>) {
        self.shop.wrong(path, message);
    }

    /// Notes that the body cannot be made: what is read is right, and a run can still be reported.
    pub(super) fn flaw(&mut self, path: &[Step], message: impl std::fmt::Display) {
        self.flaws.push(format!("{}: {message}", show(path)));
    }

    pub(super) fn name_regions(&mut self, document: &SpecimenDocument) {
        for (index, region) in document.region.iter().enumerate() {
            let taken =
                region.name == "all" || BoxSide::ALL.iter().any(|side| side.0 == region.name);
            if taken || self.regions.contains_key(&region.name) {
                let message = format!("\"{}\" is the name of another region", region.name);
                self.wrong(&below(&item("region", index), "name"), message);
            }
            for (k, part) in region.parts.iter().enumerate() {
                let format::RegionPart::Box { min, max } = part else { continue };
                let mut at = below(&item("region", index), "parts");
                at.push(k.into());
                for (axis, (low, high)) in ["x", "y", "z"].iter().zip(min.iter().zip(max)) {
                    if low > high {
                        let message =
                            format!("`min` is above `max` along {axis}: {low} m, {high} m");
                        self.wrong(&at, message);
                    }
                }
            }
            self.regions.insert(region.name.clone(), region.parts.clone());
        }
    }

    /// The parts of space that a name stands for.
    pub(super) fn region(&mut self, name: &str, at: &[Step], used: Use) -> Where {
        if name == "all" {
            return Vec::new();
        }
        if let Some(side) = BoxSide::ALL.iter().find(|side| side.0 == name) {
            let depth = if used == Use::Points { self.spacing } else { 0.0 };
            return vec![self.face(side.1, depth)];
        }
        let Some(parts) = self.regions.get(name).cloned() else {
            let known: Vec<&str> = self.regions.keys().map(String::as_str).collect();
            let all = known.into_iter().chain(["all"]).chain(BoxSide::ALL.map(|side| side.0));
            let advice = suggest(name, &all.collect::<Vec<_>>());
            let message = format!("there is no region \"{name}\"");
            self.shop.wrong_with(&below(at, "region"), message, advice);
            return Vec::new();
        };
        parts.iter().map(|part| self.part(part, at)).collect()
    }

    fn face(&self, side: BoxSide, depth: f64) -> Region {
        let (axis, high) = side.axis();
        let (low, top) = self.bounds;
        let (mut point, mut normal) = (Vec3::zeros(), Vec3::zeros());
        point[axis] = if high { top[axis] - depth } else { low[axis] + depth };
        normal[axis] = if high { -1.0 } else { 1.0 };
        Region::HalfSpace { point, normal }
    }

    fn part(&mut self, part: &format::RegionPart, at: &[Step]) -> Region {
        match part {
            &format::RegionPart::Box { min, max } => {
                Region::Box { low: Vec3::from(min), high: Vec3::from(max) }
            }
            &format::RegionPart::Ball { centre, radius } => {
                Region::Sphere { centre: Vec3::from(centre), radius }
            }
            &format::RegionPart::HalfSpace { point, normal } => {
                let normal = self.unit(normal, at);
                Region::HalfSpace { point: Vec3::from(point), normal }
            }
            &format::RegionPart::Cylinder { from, to, radius } => {
                Region::Cylinder { from: Vec3::from(from), to: Vec3::from(to), radius }
            }
            format::RegionPart::Face { side, depth } => self.face(*side, *depth),
        }
    }

    /// A direction of length 1.
    pub(super) fn unit(&mut self, direction: [f64; 3], at: &[Step]) -> Vec3 {
        let unit = direction::direction(direction).unwrap_or_else(|why| {
            self.wrong(at, why);
            [1.0, 0.0, 0.0]
        });
        Vec3::from(unit)
    }
}
