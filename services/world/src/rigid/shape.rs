//! The convex parts of a body, made for the engine.

use super::hulls::{Fit, Part, boxed, fault, part};
use crate::body::Body;
use cullet_geometry::Vec3;

/// A convex part that is none: its place and what is wrong with it.
pub(crate) struct BadPart {
    pub(crate) index: usize,
    pub(crate) why: &'static str,
}

/// The convex parts of a body, ready for the engine.
pub(crate) struct Shape {
    pub(super) parts: Vec<Part>,
    pub(super) fit: Fit,
}

impl Shape {
    /// Makes them. A part that the engine can make nothing of is left out; where none is left, the
    /// box around the body stands in for it. What is wrong with the numbers of a scene's part is
    /// told.
    pub(crate) fn new(body: &Body, corners: &[Vec<Vec3>], fit: Fit) -> Result<Self, BadPart> {
        let parts = match fit {
            Fit::Tiny => vec![only(body, corners)?],
            Fit::Body | Fit::Fragment => several(body, corners, fit)?,
        };
        Ok(Self { parts, fit })
    }
}

fn only(body: &Body, corners: &[Vec<Vec3>]) -> Result<Part, BadPart> {
    let given: Vec<Vec3> = corners.iter().flatten().copied().collect();
    let all = if given.is_empty() { body.solid.mesh.vertices.clone() } else { given };
    part(&all, Fit::Tiny)
        .or_else(|_| part(&boxed(all.iter().copied()), Fit::Tiny))
        .or_else(|_| part(&boxed(body.solid.mesh.vertices.iter().copied()), Fit::Tiny))
        .map_err(|why| BadPart { index: 0, why })
}

fn several(body: &Body, corners: &[Vec<Vec3>], fit: Fit) -> Result<Vec<Part>, BadPart> {
    let bad =
        |(index, corners): (usize, &Vec<Vec3>)| fault(corners).map(|why| BadPart { index, why });
    // A bad part of a fragment is not worth a fracture: the others stand in for it.
    let told = if fit == Fit::Body { corners.iter().enumerate().find_map(bad) } else { None };
    if let Some(bad) = told {
        return Err(bad);
    }
    let mut parts: Vec<Part> = corners.iter().filter_map(|one| part(one, fit).ok()).collect();
    if parts.is_empty() {
        let whole = boxed(body.solid.mesh.vertices.iter().copied());
        parts.push(part(&whole, fit).map_err(|why| BadPart { index: 0, why })?);
    }
    Ok(parts)
}
