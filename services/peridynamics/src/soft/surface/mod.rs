//! The surface of a soft solid as it is drawn: that of the body, carried by points, and open where
//! bonds have broken.
//!
//! A place V of the body at rest is carried by the points around it that bonds hold together with
//! the one that V belongs to: Σ share (x + F (V − X)). A face between the cells of two points (a
//! Voronoi face of the points at rest) is open where these are not held together there, and then
//! it is drawn on either side. Vertices with the same place and the same points are one.

mod clip;
mod torn;

use super::grid::PointCells;
use super::pieces::{HOLDS, holds};
use crate::PeridynamicDomain;
use clip::ClippingBody;
use cullet_continuum::bytes::{held, held_lists};
use cullet_geometry::inside::{Inside, Nearest};
use cullet_geometry::{Mat3, TriMesh, Vec3};
use cullet_model::{BodyCut, MovingSurface};
use nalgebra::Rotation3;
use rayon::prelude::*;
use std::collections::BTreeSet;
pub(super) use torn::TornSolid;

/// Points around a place among which those that carry it are sought.
const AROUND: usize = 12;
/// Of those that do, the nearest; the last of them has no share.
const CARRIERS: usize = 7;
/// Most points of a group that goes with another by longer bonds alone.
const FEW: usize = 2;
/// How much a gradient is drawn to the turn of its piece, over Σw n⊗n: points with too few bonds
/// for one have that turn. And how much more by the square of the share of bonds that is gone.
const DRAWN: f64 = 1e-3;
const TORN: f64 = 0.3;
/// A gradient with less than this determinant is none.
const LEAST_JACOBIAN: f64 = 0.1;

/// Memory of a triangle in the trees of the body that cells are clipped to, and of a gap \[bytes\].
const FACET: u64 = 250;
const GAP: u64 = 16;

/// What the drawn surface of a body is made from.
pub(super) struct SurfaceTemplate {
    /// Fine triangles of the body's surface at rest \[m\].
    mesh: TriMesh,
    /// The nearest points of each vertex, those beyond a gap aside.
    near: Vec<Vec<u32>>,
    /// Where points are at rest \[m\].
    rest: Vec<Vec3>,
    cells: PointCells,
    body: ClippingBody,
    /// Distance of each point from the surface \[m\].
    depths: Vec<f64>,
    cuts: Vec<BodyCut>,
    /// Near points between which the body has a gap: the lesser first.
    gaps: BTreeSet<[u32; 2]>,
    spacing: f64,
}

impl std::fmt::Debug for SurfaceTemplate {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (points, vertices) = (self.rest.len(), self.mesh.vertices.len());
        f.debug_struct("SurfaceTemplate")
            .field("points", &points)
            .field("vertices", &vertices)
            .finish_non_exhaustive()
    }
}

/// What the template of a surface is made from.
pub(super) struct SurfaceInput<'a> {
    /// The body's surface \[m\].
    pub(super) coarse: &'a TriMesh,
    /// The same in fine triangles.
    pub(super) fine: TriMesh,
    /// Points at rest, with no bond cut but across gaps.
    pub(super) domain: &'a PeridynamicDomain,
    pub(super) rest: &'a [Vec3],
    pub(super) cuts: &'a [BodyCut],
    pub(super) gaps: BTreeSet<[u32; 2]>,
    pub(super) spacing: f64,
}

/// A vertex and what carries it.
#[derive(Clone, Debug)]
pub(super) struct CarriedVertex {
    rest: Vec3,
    shares: Vec<(u32, f64)>,
}

/// What a bond does for two points.
#[derive(Clone, Copy, Debug, PartialEq)]
enum BondHold {
    /// It is broken.
    None,
    /// It is there, but too long to hold by itself.
    Weak,
    Full,
}

/// Which bonds of all points hold, of those up to two spacings long.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct HeldBonds {
    starts: Vec<u32>,
    /// Other ends, ascending.
    ends: Vec<(u32, BondHold)>,
}

impl HeldBonds {
    pub(super) fn of(domain: &PeridynamicDomain, spacing: f64) -> Self {
        let (mut starts, mut ends) = (vec![0], Vec::new());
        for p in 0..domain.places.len() {
            let short = domain.bonds.of(p).filter(|b| domain.rest(p, *b) <= 2.0 * spacing);
            ends.extend(short.map(|b| {
                let weak = || if domain.left(b) > HOLDS { BondHold::Weak } else { BondHold::None };
                let full = holds(domain, p, b, spacing);
                (b.end as u32, if full { BondHold::Full } else { weak() })
            }));
            starts.push(ends.len() as u32);
        }
        Self { starts, ends }
    }

    fn row(&self, p: u32) -> &[(u32, BondHold)] {
        &self.ends[self.starts[p as usize] as usize..self.starts[p as usize + 1] as usize]
    }

    /// What the bond of two points does.
    fn hold(&self, p: u32, q: u32) -> BondHold {
        let row = self.row(p);
        let slot = row.binary_search_by_key(&q, |end| end.0);
        slot.map_or(BondHold::None, |slot| row[slot].1)
    }
}

impl SurfaceTemplate {
    /// Memory that it takes, about \[bytes\].
    pub(super) fn bytes(&self) -> u64 {
        let mesh = held(&self.mesh.vertices) + held(&self.mesh.triangles);
        let lists = held_lists(&self.near) + held(&self.rest) + held(&self.depths);
        let body = FACET * self.body.normals.len() as u64;
        mesh + lists + self.cells.bytes() + body + GAP * self.gaps.len() as u64
    }

    pub(super) fn new(input: SurfaceInput<'_>) -> Self {
        let SurfaceInput { coarse, fine, domain, rest, cuts, gaps, spacing } = input;
        let cells = PointCells::new(rest, 1.5 * spacing);
        let held = HeldBonds::of(domain, spacing);
        let normal = |t: usize| {
            let [a, b, c] = coarse.corners(t);
            (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_default()
        };
        let body = ClippingBody {
            inside: Inside::new(coarse),
            nearest: Nearest::new(coarse),
            normals: (0..coarse.triangles.len()).map(normal).collect(),
            spacing,
        };
        let depths = rest.par_iter().map(|x| body.nearest.distance(*x)).collect();
        let around = |x: &Vec3| {
            let all = cells.nearest(rest, x, AROUND);
            let names = grouped(&all, &held);
            let own = names.first().copied();
            all.iter().zip(names).filter(|(_, name)| Some(*name) == own).map(|it| *it.0).collect()
        };
        let near = fine.vertices.par_iter().map(around).collect();
        let (rest, cuts) = (rest.to_vec(), cuts.to_vec());
        Self { mesh: fine, near, cells, body, depths, cuts, gaps, spacing, rest }
    }

    /// Area of the surface that each point is nearest to, outward \[m²\].
    pub(super) fn areas(&self) -> Vec<Vec3> {
        let mut areas = vec![Vec3::zeros(); self.rest.len()];
        for (t, corners) in self.mesh.triangles.iter().enumerate() {
            let [a, b, c] = self.mesh.corners(t);
            let centre = (a + b + c) / 3.0;
            let all = corners.iter().flat_map(|&v| &self.near[v as usize]);
            let far = |p: u32| (self.rest[p as usize] - centre).norm_squared();
            let best = all.copied().min_by(|&p, &q| far(p).total_cmp(&far(q)).then(p.cmp(&q)));
            if let Some(p) = best {
                areas[p as usize] += 0.5 * (b - a).cross(&(c - a));
            }
        }
        areas
    }

    /// Distance of a point from the surface \[m\].
    pub(super) fn depth(&self, point: usize) -> f64 {
        self.depths[point]
    }
}

/// For each of some points the least number of those that bonds between them hold it to. One or
/// two that only longer bonds hold go with those: else a torn face would be all single cells.
fn grouped(all: &[u32], held: &HeldBonds) -> Vec<u32> {
    let mut names: Vec<u32> = all.to_vec();
    join(all, &mut names, |_, i, j| held.hold(all[i], all[j]) == BondHold::Full);
    let few = |names: &[u32], i: usize| names.iter().filter(|n| **n == names[i]).count() <= FEW;
    join(all, &mut names, |names, i, j| {
        held.hold(all[i], all[j]) == BondHold::Weak && (few(names, i) || few(names, j))
    });
    names
}

/// Gives groups that belong together the lesser of their names.
fn join(all: &[u32], names: &mut [u32], together: impl Fn(&[u32], usize, usize) -> bool) {
    let mut changed = true;
    while std::mem::take(&mut changed) {
        for i in 0..all.len() {
            for j in 0..i {
                let (one, two) = (names[i].min(names[j]), names[i].max(names[j]));
                if one != two && together(names, i, j) {
                    names.iter_mut().filter(|name| **name == two).for_each(|name| *name = one);
                    changed = true;
                }
            }
        }
    }
}

/// Shares of a place of points by rising distance: the nearer the more, 1 together.
fn shares(place: &Vec3, near: &[u32], rest: &[Vec3]) -> Vec<(u32, f64)> {
    let few = &near[..near.len().min(CARRIERS)];
    let far = |p: u32| (rest[p as usize] - place).norm();
    let edge = few.last().map_or(0.0, |&p| far(p)).max(f64::MIN_POSITIVE);
    let count = few.len().saturating_sub(1).max(1);
    let share = |&p: &u32| {
        let share = (1.0 - far(p) / edge).max(1e-6);
        (p, share * share)
    };
    let mut found: Vec<(u32, f64)> = few.iter().take(count).map(share).collect();
    let all: f64 = found.iter().map(|share| share.1).sum();
    found.iter_mut().for_each(|one| one.1 /= all);
    found
}

/// Gradients of points \[1\]: of those that have lost most bonds, drawn to `turns`.
pub(super) fn gradient(domain: &PeridynamicDomain, p: usize, turn: &Rotation3<f64>) -> Mat3 {
    let drawn = DRAWN + TORN * domain.states[p].damage.powi(2);
    let (mut moved, mut shape) = (turn.matrix() * drawn, Mat3::identity() * drawn);
    for bond in domain.bonds.of(p) {
        let left = domain.left(bond);
        if left == 0.0 {
            continue;
        }
        let rest = domain.reference[bond.end] - domain.reference[p];
        let weight = domain.weight(p, bond) * left / rest.norm_squared();
        moved += (domain.places[bond.end] - domain.places[p]) * rest.transpose() * weight;
        shape += rest * rest.transpose() * weight;
    }
    let found = shape.try_inverse().map(|inverse| moved * inverse);
    found.filter(|f| f.determinant() > LEAST_JACOBIAN).unwrap_or(*turn.matrix())
}

/// A surface whose vertices points carry.
#[derive(Clone, Debug)]
pub(super) struct CarriedSurface {
    pub(super) surface: MovingSurface,
    vertices: Vec<CarriedVertex>,
    /// Points that carry any, ascending.
    carriers: Vec<u32>,
}

impl CarriedSurface {
    fn new(triangles: Vec<[u32; 3]>, vertices: Vec<CarriedVertex>) -> Self {
        let all = vertices.iter().flat_map(|vertex| vertex.shares.iter().map(|one| one.0));
        let carriers: BTreeSet<u32> = all.collect();
        let flat = |vertex: &CarriedVertex| [vertex.rest.x as f32, vertex.rest.y as f32];
        let reference = vertices.iter().map(flat).collect();
        let surface = MovingSurface { triangles, reference, thickness: 0.0 };
        Self { surface, vertices, carriers: carriers.into_iter().collect() }
    }

    /// The same without what some points carry.
    pub(super) fn without(self, gone: &[bool]) -> Self {
        if !gone.contains(&true) {
            return self;
        }
        let kept = |vertex: &CarriedVertex| !gone[vertex.shares[0].0 as usize];
        let mut number = Vec::new();
        let mut vertices: Vec<CarriedVertex> = Vec::new();
        for vertex in &self.vertices {
            number.push(vertices.len() as u32);
            vertices.extend(kept(vertex).then(|| vertex.clone()));
        }
        let left = self.surface.triangles.iter();
        let left = left.filter(|corners| kept(&self.vertices[corners[0] as usize]));
        let triangles = left.map(|corners| corners.map(|v| number[v as usize])).collect();
        Self::new(triangles, vertices)
    }

    /// The point that has most of a vertex.
    pub(super) fn carrier(&self, vertex: u32) -> u32 {
        self.vertices[vertex as usize].shares[0].0
    }

    /// Where its vertices are \[m\].
    pub(super) fn places(&self, domain: &PeridynamicDomain, rest: &[Vec3]) -> Vec<Vec3> {
        let turns = domain.turns();
        let of = |&p: &u32| (p, gradient(domain, p as usize, &turns[p as usize]));
        let found: Vec<(u32, Mat3)> = self.carriers.par_iter().map(of).collect();
        let mut gradients = vec![Mat3::identity(); rest.len()];
        found.into_iter().for_each(|(p, f)| gradients[p as usize] = f);
        let carry = |vertex: &CarriedVertex| {
            let by = |&(p, share): &(u32, f64)| {
                let p = p as usize;
                (domain.places[p] + gradients[p] * (vertex.rest - rest[p])) * share
            };
            vertex.shares.iter().map(by).sum()
        };
        self.vertices.par_iter().map(carry).collect()
    }
}
