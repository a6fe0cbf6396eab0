//! What pieces are cut from: the body and the mosaic of facets that divides it.

use super::body::{CutBody, FACET, facet_of};
use super::ground::{FrontMark, Ground, marks};
use super::piece::CutPiece;
use crate::error::CutError;
use crate::region::{FacetSide, Mosaic, triangle_area};
use cullet_geometry::boolean::Exact;
use cullet_geometry::inside::closest_on_triangle;
use cullet_geometry::surface::{barycentric, interpolate};
use cullet_geometry::{Solid, Surface, Vec3};
use std::collections::BTreeMap;

/// Most facets, and triangles of a body, that can be named.
const MOST: usize = 1 << 30;
/// What a union leaves beside its main part may have this share of the body's volume: rounding.
const REST: f64 = 1e-12;

/// The body, the mosaic, and when the crack front passed the mosaic's corners.
#[derive(Debug)]
pub(super) struct Workpiece {
    pub(super) body: CutBody,
    pub(super) mosaic: Mosaic,
    pub(super) ground: Option<Ground>,
    /// Of each corner of the mosaic.
    marks: Vec<FrontMark>,
}

impl Workpiece {
    pub(super) fn new(
        body: CutBody,
        mosaic: Mosaic,
        ground: Option<Ground>,
    ) -> Result<Self, CutError> {
        let most = mosaic.facets.len().max(body.solid.mesh.triangles.len());
        if most >= MOST {
            let (value, limit) = (most as f64, MOST as f64);
            return Err(CutError::TooLarge { what: "facets", value, limit });
        }
        let marks = marks(&mosaic, ground.as_ref());
        Ok(Self { body, mosaic, ground, marks })
    }

    /// The pieces of the region of a label that has these facets around it.
    pub(super) fn pieces_of(
        &self,
        label: u32,
        sides: &[FacetSide],
    ) -> Result<Vec<CutPiece>, CutError> {
        if sides.is_empty() {
            return Ok(Vec::new());
        }
        let (mesh, names) = self.mosaic.region(sides);
        let tags: Vec<u32> = names.iter().map(|name| FACET + name).collect();
        let share = self.body.exact.intersect(&Exact::tagged(&mesh, &tags)?)?;
        let parts = share.components()?;
        parts.into_iter().map(|part| self.piece(label, part)).collect()
    }

    /// Reads which facets a piece ends at, and gives its crack faces their times.
    fn piece(&self, label: u32, exact: Exact) -> Result<CutPiece, CutError> {
        let (mesh, tags) = exact.to_tagged()?;
        let mut solid = Solid { surface: Vec::with_capacity(tags.len()), mesh };
        let mut contacts: BTreeMap<u32, f64> = BTreeMap::new();
        let (mut crack, mut damaged) = (0.0, 0.0);
        for (t, &tag) in tags.iter().enumerate() {
            let corners = solid.mesh.corners(t);
            let Some(name) = facet_of(tag) else {
                solid.surface.push(self.body.surface_of(tag, corners));
                continue;
            };
            let area = triangle_area(&solid.mesh.vertices, solid.mesh.triangles[t]);
            *contacts.entry(name).or_insert(0.0) += area;
            crack += area;
            let middle = corners.iter().sum::<Vec3>() / 3.0;
            if self.ground.as_ref().is_none_or(|ground| ground.nodes.holds(middle)) {
                damaged += area;
            }
            let [damage_time, front_speed] = self.marks_in(name, corners);
            solid.surface.push(Surface::Crack { damage_time, front_speed, parent: 0 });
        }
        let volume = solid.mesh.signed_volume();
        let contacts = contacts.into_iter().collect();
        let buried = tags.iter().all(|&tag| facet_of(tag).is_some());
        let also = Vec::new();
        Ok(CutPiece { label, also, exact, solid, volume, contacts, crack, damaged, buried })
    }

    /// Times and speeds at the corners of a triangle that lies in a facet.
    fn marks_in(&self, facet: u32, corners: [Vec3; 3]) -> [[f32; 3]; 2] {
        let Mosaic { facets, places, .. } = &self.mosaic;
        let own = self.mosaic.of(&facets[facet as usize]);
        let at = |p: Vec3| -> FrontMark {
            if let Some(&v) = own.as_flattened().iter().find(|&&v| places[v as usize] == p) {
                return self.marks[v as usize];
            }
            let near = own.iter().map(|t| {
                let q = closest_on_triangle(p, t.map(|v| places[v as usize]));
                ((q - p).norm_squared(), t, q)
            });
            let Some((_, t, q)) = near.min_by(|a, b| a.0.total_cmp(&b.0)) else {
                return [0.0; 2];
            };
            let weights = barycentric(q, t.map(|v| places[v as usize]));
            [0, 1].map(|k| interpolate(t.map(|v| self.marks[v as usize][k]), weights))
        };
        let marks = corners.map(at);
        [0, 1].map(|k| marks.map(|mark| mark[k]))
    }

    /// Two pieces as one, if they touch along a face.
    pub(super) fn union(&self, a: &CutPiece, b: &CutPiece) -> Option<CutPiece> {
        let whole: Exact = a.exact.union(&b.exact).ok()?;
        let mut parts = whole.components().ok()?.into_iter();
        let main = parts.next()?;
        let rest: f64 = parts.map(|part| part.volume()).sum();
        if rest > REST * self.body.volume {
            return None;
        }
        let piece = self.piece(a.label, main).ok()?;
        let sum = a.volume + b.volume;
        ((piece.volume - sum).abs() <= REST * self.body.volume).then_some(piece)
    }
}
