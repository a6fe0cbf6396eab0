//! Hairline cuts: a crack that ends inside a part, really cut, as a slit of some width.
//!
//! The sheet becomes a slab with blunt borders, which is taken away exactly. What is taken away is
//! handed back too, so that nobody has to lose its volume: the solver makes debris of it.

use super::body::FACET;
use super::partition::OpenCrack;
use crate::debris::{self, Motes};
use crate::region::overlap::crossing;
use cullet_geometry::boolean::{BooleanError, Exact, MAX_TAG};
use cullet_geometry::inside::closest_on_triangle;
use cullet_geometry::surface::{barycentric, interpolate};
use cullet_geometry::{Sheet, Solid, Surface, TriMesh, Vec3};
use cullet_model::{Fragment, Grain};
use std::collections::BTreeSet;

/// Widest slit \[spacings\]: what is wider is not thin beside what the grid resolves.
pub const WIDEST: f64 = 0.2;
/// How often a slit may be halved where its faces cross.
const MOST_HALVINGS: u32 = 8;
/// Share of the volume that may be missing once a slit is cut.
const TOLERANCE: f64 = 1e-12;

/// A solid with a slit.
#[derive(Clone, Debug, PartialEq)]
pub struct Slit {
    /// What is left: one closed part.
    pub solid: Solid,
    /// What was taken away, closed.
    pub kerf: TriMesh,
}

/// Why a slit was not cut.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SlitError {
    /// Too wide, or no width.
    #[error("it would be {width:.3e} m wide; it must be over 0 and at most {limit:.3e} m")]
    Width {
        /// The width asked for \[m\].
        width: f64,
        /// The greatest \[m\].
        limit: f64,
    },
    /// The sides of the slab would cross each other.
    #[error("{count} of its faces would cross")]
    Crossing {
        /// How many faces do.
        count: usize,
    },
    /// The slit would part the solid, or leave nothing.
    #[error("it would leave {count} parts of one")]
    Parts {
        /// How many parts there would be.
        count: usize,
    },
    /// Volume would be lost.
    #[error("{missing:.3e} m³ would be missing of {whole:.3e} m³")]
    Volume {
        /// What would be missing \[m³\].
        missing: f64,
        /// The volume of the solid \[m³\].
        whole: f64,
    },
    /// It does not meet the solid.
    #[error("it does not meet the solid")]
    Nothing,
    /// The boolean kernel refused.
    #[error(transparent)]
    Boolean(#[from] BooleanError),
}

/// Cuts a slit of that `width` \[m\] along a sheet without junctions, which should reach beyond the
/// solid where the slit is to be open. Faces of the slit know what the sheet knew there.
///
/// # Errors
/// See [`SlitError`].
pub fn open(solid: &Solid, sheet: &Sheet, width: f64, spacing: f64) -> Result<Slit, SlitError> {
    let limit = WIDEST * spacing;
    if !(width > 0.0 && width <= limit) {
        return Err(SlitError::Width { width, limit });
    }
    let (slab, owner) = slab(sheet, width)?;
    let own = |(t, s): (usize, &Surface)| if s.is_crack() { t as u32 } else { MAX_TAG };
    let tags: Vec<u32> = solid.surface.iter().enumerate().map(own).collect();
    let body = Exact::tagged(&solid.mesh, &tags)?;
    let names: Vec<u32> = (0..slab.triangles.len() as u32).map(|k| FACET + k).collect();
    let slab = Exact::tagged(&slab, &names)?;
    let kerf = body.intersect(&slab)?.to_tagged()?.0;
    if kerf.triangles.is_empty() {
        return Err(SlitError::Nothing);
    }
    let rest = body.subtract(&slab)?;
    let count = rest.components()?.len();
    if count != 1 {
        return Err(SlitError::Parts { count });
    }
    let (mesh, tags) = rest.to_tagged()?;
    let whole = solid.mesh.signed_volume();
    let missing = whole - mesh.signed_volume() - kerf.signed_volume();
    if missing.abs() > TOLERANCE * whole || kerf.signed_volume() <= 0.0 {
        return Err(SlitError::Volume { missing, whole });
    }
    let surface = (0..tags.len()).map(|t| {
        let corners = mesh.corners(t);
        match tags[t] {
            MAX_TAG => Surface::Outer,
            tag if tag >= FACET => side(sheet, owner[(tag - FACET) as usize], corners),
            old => {
                let old = old as usize;
                solid.surface[old].within(solid.mesh.corners(old), corners)
            }
        }
    });
    Ok(Slit { solid: Solid { surface: surface.collect(), mesh }, kerf })
}

/// A face of a slit: what the sheet's triangle knows below its corners.
fn side(sheet: &Sheet, triangle: u32, corners: [Vec3; 3]) -> Surface {
    let home = sheet.mesh.corners(triangle as usize);
    let weights = corners.map(|p| barycentric(closest_on_triangle(p, home), home));
    let of = |marks: &[f32]| {
        let own = sheet.mesh.triangles[triangle as usize].map(|v| marks[v as usize]);
        weights.map(|w| interpolate(own, w))
    };
    let (damage_time, front_speed) = (of(&sheet.damage_time), of(&sheet.front_speed));
    Surface::Crack { damage_time, front_speed, parent: 0 }
}

/// A closed slab about a sheet, of that width but where the sheet folds too sharply for it: there
/// it is halved until no faces cross.
fn slab(sheet: &Sheet, width: f64) -> Result<(TriMesh, Vec<u32>), SlitError> {
    let count = sheet.mesh.vertices.len();
    let mut widths = vec![width; count];
    for _ in 0..MOST_HALVINGS {
        let (slab, owner) = thickened(sheet, &widths);
        let crossed = crossing(&slab.vertices, &slab.triangles);
        if crossed.is_empty() {
            return Ok((slab, owner));
        }
        let faces = crossed.iter();
        let corners = faces.flat_map(|&t| slab.triangles[t as usize]);
        let corners: BTreeSet<usize> = corners.map(|v| v as usize % count).collect();
        corners.into_iter().for_each(|v| widths[v] *= 0.5);
    }
    let (slab, _) = thickened(sheet, &widths);
    Err(SlitError::Crossing { count: crossing(&slab.vertices, &slab.triangles).len() })
}

/// A closed slab about a sheet, of the width \[m\] given for each of its corners, and the sheet's
/// triangle that each of its faces belongs to.
fn thickened(sheet: &Sheet, widths: &[f64]) -> (TriMesh, Vec<u32>) {
    let mesh = &sheet.mesh;
    let count = mesh.vertices.len() as u32;
    let mut normals = vec![Vec3::zeros(); mesh.vertices.len()];
    for (t, corners) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = mesh.corners(t);
        corners.iter().for_each(|&v| normals[v as usize] += (b - a).cross(&(c - a)));
    }
    let moved = |side: f64| {
        let pairs = mesh.vertices.iter().zip(&normals).zip(widths);
        pairs.map(move |((p, n), width)| {
            p + n.try_normalize(0.0).unwrap_or_default() * (0.5 * side * width)
        })
    };
    let vertices = moved(1.0).chain(moved(-1.0)).collect();
    let mut triangles: Vec<[u32; 3]> = mesh.triangles.clone();
    triangles.extend(mesh.triangles.iter().map(|&[a, b, c]| [a + count, c + count, b + count]));
    let all = 0..mesh.triangles.len() as u32;
    let mut owner: Vec<u32> = all.clone().chain(all).collect();
    let mut edges: Vec<([u32; 2], u32)> = Vec::new();
    for (t, &[a, b, c]) in (0u32..).zip(&mesh.triangles) {
        edges.extend([[a, b], [b, c], [c, a]].map(|edge| (edge, t)));
    }
    edges.sort_unstable();
    for &([a, b], t) in &edges {
        if edges.binary_search_by_key(&[b, a], |entry| entry.0).is_err() {
            triangles.extend([[b, a, a + count], [b, a + count, b + count]]);
            owner.extend([t, t]);
        }
    }
    (TriMesh { vertices, triangles }, owner)
}

/// What of some cracks lies inside, as one sheet.
pub fn joined(cracks: &[OpenCrack]) -> Sheet {
    let mut sheet = Sheet::default();
    cracks.iter().for_each(|crack| sheet.append(&crack.inside));
    sheet
}

/// What hairlines are cut with.
#[derive(Clone, Copy, Debug)]
pub struct SlitTerms<'a> {
    /// Width \[m\].
    pub width: f64,
    /// Grid spacing, the least of all axes \[m\].
    pub spacing: f64,
    /// Median size of the debris \[m\].
    pub grain: f64,
    /// The only source of randomness.
    pub seed: u64,
    /// What moved how when the solve ended.
    pub motes: &'a Motes,
}

/// Cuts the `cracks` of each fragment where that can be done, and turns what is taken away into
/// debris with the fragment's motion. A crack that is cut is no sheet any more. Returns the debris
/// and what went wrong, a sentence each.
pub fn hairlines(
    fragments: &mut [Fragment],
    cracks: &[Vec<OpenCrack>],
    terms: &SlitTerms<'_>,
) -> (Vec<Grain>, Vec<String>) {
    let (mut dust, mut warnings) = (Vec::new(), Vec::new());
    for (k, (fragment, cracks)) in fragments.iter_mut().zip(cracks).enumerate() {
        let mut left = Sheet::default();
        for (n, crack) in cracks.iter().enumerate() {
            match open(&fragment.solid, &crack.beyond, terms.width, terms.spacing) {
                Ok(slit) => {
                    let seed = terms.seed.wrapping_add(((n + 1) << 32 | k) as u64);
                    dust.extend(taken(fragment, &slit, terms, seed));
                    fragment.solid = slit.solid;
                }
                Err(why) => {
                    left.append(&crack.inside);
                    warnings.push(format!("a hairline of fragment {k} is not cut: {why}"));
                }
            }
        }
        fragment.sheet = left;
    }
    (dust, warnings)
}

/// Lets the fragment go on as what is left of it, and its kerf as grains: the motion is the same.
fn taken(fragment: &mut Fragment, slit: &Slit, terms: &SlitTerms<'_>, seed: u64) -> Vec<Grain> {
    let centre = |mesh: &TriMesh| mesh.mass_properties().centroid;
    let (before, spin) = (centre(&fragment.solid.mesh), fragment.spin);
    let at = |place: Vec3| fragment.velocity + spin.cross(&(place - before));
    let (velocity, rest) = (at(centre(&slit.kerf)), at(centre(&slit.solid.mesh)));
    fragment.velocity = rest;
    let motes = terms.motes.around(&slit.kerf);
    let part = debris::CrumblingPart { mesh: &slit.kerf, velocity, spin, motes: &motes };
    debris::grains(&part, terms.grain, seed).grains
}
