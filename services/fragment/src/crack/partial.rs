//! Cracks that end inside a piece: the middle of the damage that parts nothing, as open nets.
//!
//! Around each node the broken points have a mean place and a common direction across; the node
//! lies on one side of the plane through them. Where two neighbours lie on different sides, and
//! there is damage between them, the crack crosses their edge: surface nets as between labels, but
//! which side is which need only be known from node to node, so a net may end, and branch.

use super::damage::BROKEN;
use super::net::NetBuilder;
use super::nodes::LatticeNodes;
use super::smooth::shape;
use crate::field::DamageField;
use crate::region::triangle_area;
use cullet_geometry::{Mat3, Sheet, TriMesh, Vec3};
use rayon::prelude::*;

/// Points count for nodes this near \[units\].
const REACH: f64 = 2.0;
/// Broken points count as those of the crack between two pieces where a node of another piece lies
/// within this many units along every axis, ...
const BESIDE: f64 = 2.0;
/// ... unless they broke across another direction: cosine.
const ALONG: f64 = 0.7;
/// Least share of the directions of broken points that agree \[1\]: a third is chance.
const AGREED: f64 = 0.6;
/// Greatest mean square distance of broken points from their plane \[units²\]; a ball full of
/// them has 0.44.
const THICK: f64 = 0.33;
/// How much flatness counts against the directions in which points broke.
const FLATNESS: f64 = 1.0;
/// Least share of broken weight, of such points only, at one end of an edge that a crack
/// crosses: a layer of points half a spacing thick has 0.24 in the worst place.
const SHARE: f64 = 0.2;
/// Neighbours whose planes stand at more than this angle see different cracks: cosine of 60°.
const ALIKE: f64 = 0.5;
/// LatticeNodes farther than this from their plane tell nothing \[units\].
const FAR: f64 = 1.5;
/// Nets of less area are dropped \[units²\], ...
const LEAST: f64 = 4.0;
/// ... and those of which less is away from cracks between pieces.
const AWAY: f64 = 1.0;

/// The plane of the broken points around a node.
#[derive(Clone, Copy, Debug)]
struct BrokenPlane {
    node: u32,
    /// The node's distance from it \[m\], along `normal`.
    height: f64,
    normal: Vec3,
    /// Share of the node's weight that is broken and of no crack between pieces \[1\].
    share: f64,
    /// Whether most of the points are away from cracks between pieces.
    away: bool,
}

/// A broken point of no crack between pieces.
#[derive(Clone, Copy, Debug)]
struct BrokenPoint {
    place: Vec3,
    normal: Vec3,
    /// Whether no such crack is near.
    away: bool,
}

impl LatticeNodes {
    /// Nets through the damage that parts none of the names; `name`: of each label, what it ended
    /// as. Each with its name; no times yet.
    pub(crate) fn partial(
        &self,
        field: &DamageField<'_>,
        name: impl Fn(u32) -> u32,
    ) -> Vec<(u32, Sheet)> {
        let names: Vec<u32> = (0..self.labels).map(name).collect();
        let own: Vec<u32> = match self.reach.is_empty() {
            true => vec![0; self.lattice.len()],
            false => self.reach.iter().map(|&label| names[label as usize]).collect(),
        };
        let planes = self.planes(field, &own);
        let mut names: Vec<u32> = planes.iter().map(|plane| own[plane.node as usize]).collect();
        names.sort_unstable();
        names.dedup();
        let nets = names.into_iter().map(|name| {
            let of = planes.iter().filter(|plane| own[plane.node as usize] == name);
            (name, self.open_net(&of.copied().collect::<Vec<BrokenPlane>>()))
        });
        nets.filter(|(_, net)| !net.is_empty()).collect()
    }

    /// A broken point, if it belongs to no crack between names.
    fn point(&self, place: Vec3, normal: Vec3, own: &[u32]) -> Option<BrokenPoint> {
        let home = self.lattice.nearest(place);
        let (mut away, mut count) = (Vec3::zeros(), 0.0);
        let node = self.lattice.node(home);
        let other = |&j: &usize| own[j] != own[home] && self.is_inside(j);
        for j in self.lattice.around(node, self.steps(BESIDE)).filter(other) {
            let arm = self.lattice.place(self.lattice.node(j)) - place;
            away += arm.try_normalize(0.0).unwrap_or_default();
            count += 1.0;
        }
        let clear = away.norm() > 0.2 * count;
        let across = normal.dot(&away).abs() < ALONG * away.norm();
        let partial = count == 0.0 || (clear && across && normal != Vec3::zeros());
        let alone = !self.lattice.around(node, self.steps(1.0)).any(|j| other(&j));
        partial.then_some(BrokenPoint { place, normal, away: alone })
    }

    fn planes(&self, field: &DamageField<'_>, own: &[u32]) -> Vec<BrokenPlane> {
        let Some(normals) = field.normals else {
            return Vec::new();
        };
        let points: Vec<BrokenPoint> = (0..field.positions.len())
            .into_par_iter()
            .filter(|&p| field.damage[p] >= BROKEN)
            .filter_map(|p| self.point(field.positions[p], normals[p], own))
            .collect();
        let (lattice, reach) = (&self.lattice, self.steps(REACH));
        let mut homes: Vec<(u32, u32)> =
            (0..).zip(&points).map(|(p, at)| (lattice.nearest(at.place) as u32, p)).collect();
        homes.sort_unstable();
        let mut near = vec![false; lattice.len()];
        for same in homes.chunk_by(|a, b| a.0 == b.0) {
            let home = same[0].0 as usize;
            lattice.around(lattice.node(home), reach).for_each(|i| near[i] |= own[i] == own[home]);
        }
        let mut first = vec![0; lattice.len() + 1];
        homes.iter().for_each(|&(home, _)| first[home as usize + 1] += 1);
        (0..lattice.len()).for_each(|i| first[i + 1] += first[i]);
        let plane = |list: &mut Vec<u32>, i: usize| {
            let alike = lattice.around(lattice.node(i), reach).filter(|&home| own[home] == own[i]);
            list.clear();
            list.extend(alike.flat_map(|home| &homes[first[home]..first[home + 1]]).map(|at| at.1));
            // The order in which they are added up is that of the points.
            list.sort_unstable();
            self.plane(i as u32, list.iter().map(|&p| points[p as usize]))
        };
        let nodes = (0..lattice.len()).into_par_iter().filter(|&i| near[i]);
        nodes.map_init(Vec::new, plane).flatten_iter().collect()
    }

    /// The net between the nodes of some planes, smoothed.
    fn open_net(&self, planes: &[BrokenPlane]) -> Sheet {
        let mut builder = NetBuilder::new(self);
        let mut away = Vec::new();
        let lattice = self.lattice;
        let strides = [1, lattice.dims[0], lattice.dims[0] * lattice.dims[1]];
        for a in planes {
            for (axis, stride) in strides.into_iter().enumerate() {
                let next = a.node + stride as u32;
                let Ok(b) = planes.binary_search_by_key(&next, |plane| plane.node) else {
                    continue;
                };
                if let Some(share) = self.crossed(a, &planes[b]) {
                    builder.open(a.node as usize, axis, share);
                    away.push(a.away && planes[b].away);
                }
            }
        }
        let (mut mosaic, mut net) = builder.settled();
        shape(&mut net, &mosaic);
        mosaic.places.clone_from(&net.place);
        super::net::fold(&mut mosaic);
        let unknown = vec![0.0; mosaic.places.len()];
        let mesh = TriMesh { vertices: mosaic.places, triangles: mosaic.triangles };
        let all = Sheet { mesh, damage_time: unknown.clone(), front_speed: unknown };
        let square = self.unit * self.unit;
        let mut kept = Vec::new();
        for part in all.mesh.components() {
            // Two triangles a quad, in order.
            let area = |t: &usize| triangle_area(&all.mesh.vertices, all.mesh.triangles[*t]);
            let whole: f64 = part.iter().map(area).sum();
            let clear: f64 = part.iter().filter(|&&t| away[t / 2]).map(area).sum();
            if whole >= LEAST * square && clear >= AWAY * square {
                kept.extend(part);
            }
        }
        all.part(&kept)
    }

    /// Where on the edge between the nodes of two planes a crack crosses it: 0 at the first.
    fn crossed(&self, a: &BrokenPlane, b: &BrokenPlane) -> Option<f64> {
        let (i, j) = (a.node as usize, b.node as usize);
        let turn = a.normal.dot(&b.normal);
        let (here, there) = (a.height, b.height * turn.signum());
        let sides = (here < 0.0) != (there < 0.0);
        let gap = self.is_inside(i) && self.is_inside(j) && !self.connects(i, j);
        let damaged = a.share.max(b.share) >= SHARE;
        if turn.abs() < ALIKE || !sides || gap || !damaged {
            return None;
        }
        let lattice = &self.lattice;
        let share = here / (here - there);
        let (p, q) = (lattice.place(lattice.node(i)), lattice.place(lattice.node(j)));
        self.is_near_body(p + share * (q - p)).then_some(share)
    }

    /// The plane that these points are about in, if they are.
    fn plane(&self, node: u32, points: impl Iterator<Item = BrokenPoint>) -> Option<BrokenPlane> {
        let place = self.lattice.place(self.lattice.node(node as usize));
        let nodes = self.unit / self.lattice.spacing;
        let (mut whole, mut share, mut away) = (0.0, 0.0, 0.0);
        let (mut mean, mut spread, mut across) = (Vec3::zeros(), Mat3::zeros(), Mat3::zeros());
        for point in points {
            let arm = (point.place - place) / self.unit;
            let close = 1.0 - arm.norm_squared() / (REACH * REACH);
            if close <= 0.0 {
                continue;
            }
            let w = close * close;
            whole += w;
            away += if point.away { w } else { 0.0 };
            let along = self.lattice.along(arm);
            share += along.iter().map(|x| spline((x * nodes).abs())).product::<f64>();
            mean += w * arm;
            spread += w * arm * arm.transpose();
            across += w * point.normal * point.normal.transpose();
        }
        if whole <= 0.0 {
            return None;
        }
        (mean, spread, across) = (mean / whole, spread / whole, across / whole);
        spread -= mean * mean.transpose();
        let axes = (across - FLATNESS * spread).symmetric_eigen();
        let normal: Vec3 = axes.eigenvectors.column(axes.eigenvalues.imax()).into();
        let agreed = normal.dot(&(across * normal)) >= AGREED;
        let flat = normal.dot(&(spread * normal)) <= THICK;
        let height = -normal.dot(&mean);
        let share = if share > 0.0 { share / self.damage.weight[node as usize] } else { 0.0 };
        let away = away > 0.5 * whole;
        let plane = BrokenPlane { node, height: height * self.unit, normal, share, away };
        (agreed && flat && height.abs() <= FAR).then_some(plane)
    }
}

/// The quadratic B-spline at a distance \[spacings\].
fn spline(x: f64) -> f64 {
    let far = (1.5 - x).max(0.0);
    if x < 0.5 { 0.75 - x * x } else { 0.5 * far * far }
}
