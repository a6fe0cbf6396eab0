//! From how a scene wants a body to come apart to the direction that travels with a job.

use super::context::ResolveContext;
use super::format::{Body, Fracture, WantedPieces};
use super::geometry::BodyGeometry;
use cullet_document::check::tell;
use cullet_document::tree::{Path, join};
use cullet_geometry::Vec3;
use cullet_geometry::inside::{Inside, Nearest};
use cullet_model::{ArtDirection, BodyRegion};
use std::sync::Arc;

/// A guide point may lie this share of the body's diagonal outside its surface \[1\]: a point that
/// was picked on a surface is not exactly in it.
const OUTSIDE: f64 = 0.01;

/// Guide points are at least this share of the body's diagonal apart \[1\].
const APART: f64 = 1e-4;

impl ResolveContext<'_> {
    /// How a body is to come apart; errors are noted. `breaks`: whether it can break at all.
    pub(super) fn direction_of(
        &mut self,
        (body, breaks): (&Body, bool),
        shapes: &[(Option<String>, Arc<BodyGeometry>)],
        defaults: &Fracture,
        path: &Path,
    ) -> Option<Arc<ArtDirection>> {
        if body.interior.is_some() && body.dynamic.is_some() {
            self.wrong(&join(path, "interior"), "of a body that breaks as rigid bodies do");
        }
        let written = body.pieces.as_ref()?;
        let path = join(path, "pieces");
        let why = match shapes {
            _ if body.dynamic.is_some() => Some("a dynamic body tears by itself: no `pieces`"),
            _ if !breaks => Some("the body does not break: see `breakable`"),
            [_] => None,
            _ => Some("only of a body of one object: its mesh file has several"),
        };
        if let Some(why) = why {
            self.wrong(&path, why);
            return None;
        }
        let WantedPieces { count, guides, whole } = written;
        if count.is_none() && guides.is_empty() && whole.is_empty() {
            self.wrong(&path, "takes `count`, `guides` or `whole`, at least one of them");
        }
        self.count(written, defaults, &path);
        let (_, geometry) = shapes.first()?;
        let inside = Inside::new(&geometry.solid.mesh);
        let surface = Nearest::new(&geometry.solid.mesh);
        let slack = OUTSIDE * geometry.solid.mesh.diagonal();
        let mut direction = ArtDirection { pieces: *count, ..ArtDirection::default() };
        for (index, guide) in guides.iter().enumerate() {
            let place = Vec3::from(*guide) + geometry.origin;
            let out = if inside.contains(place) { 0.0 } else { surface.distance(place) };
            if out > slack {
                let (out, most) = (tell(out), tell(slack));
                let message = format!("lies {out} m outside the body; at most {most} m");
                self.wrong(&join(&join(&path, "guides"), index), message);
            }
            let least = APART * geometry.solid.mesh.diagonal();
            let near = |other: &Vec3| (other - place).norm() < least;
            if let Some(other) = direction.guides.iter().position(near) {
                let message = format!(
                    "must be {} m or more from the others; `guides[{other}]` is nearer",
                    tell(least)
                );
                self.wrong(&join(&join(&path, "guides"), index), message);
            }
            direction.guides.push(place);
        }
        for (index, part) in whole.iter().enumerate() {
            let path = join(&join(&path, "whole"), index);
            let Some(region) = self.body_part(*part, geometry.origin, &path) else { continue };
            if !touches(&region, geometry.bounds, (&inside, &surface)) {
                self.wrong(&path, "holds no part of the body");
            }
            let held = direction.guides.iter().filter(|guide| region.has(guide)).count();
            if held > 1 {
                self.wrong(&path, format!("holds at most one of the `guides`; it holds {held}"));
            }
            direction.whole.push(region);
        }
        Some(Arc::new(direction))
    }

    fn count(&mut self, written: &WantedPieces, defaults: &Fracture, path: &Path) {
        let Some(count) = written.count else { return };
        let (guides, most) = (written.guides.len(), defaults.max_fragments);
        let message = if count > most {
            format!("must be at most `fracture.max_fragments`, {most}; it is {count}")
        } else if (count as usize) < guides {
            format!("must be at least the number of `guides`, {guides}; it is {count}")
        } else {
            return;
        };
        self.wrong(&join(path, "count"), message);
    }
}

/// Whether a region reaches the body; of a box only whether it reaches the body's own box.
fn touches(
    region: &BodyRegion,
    (low, high): (Vec3, Vec3),
    (inside, surface): (&Inside, &Nearest),
) -> bool {
    match *region {
        BodyRegion::Ball { centre, radius } => {
            inside.contains(centre) || surface.distance(centre) < radius
        }
        BodyRegion::Box { low: from, high: to } => {
            (0..3).all(|k| from[k] < high[k] && to[k] > low[k] && from[k] < to[k])
        }
    }
}
