//! Loads: what part of them each control point takes.

use super::build::{AlignedPlate, FUNCTIONS, PlateDomain};
use cullet_geometry::Vec3;
use cullet_simd::Real;
use cullet_specimen::surface::{SurfacePiece, pieces};
use cullet_specimen::{Load, LoadKind, SpecimenProblem, within};
use std::collections::BTreeMap;

/// A load at 1 of its course, by point: the force on each control point of its cell \[N\].
#[derive(Clone, Debug, Default)]
pub(super) struct PlateLoad {
    points: BTreeMap<usize, [Vec3; FUNCTIONS]>,
    /// Their sum \[N\].
    pub(super) total: Vec3,
}

impl PlateLoad {
    /// Whether it acts on nothing.
    pub(super) fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// The force on each control point that there is now, whatever has parted \[N\].
    pub(super) fn by_node<R: Real>(&self, domain: &PlateDomain<R>) -> BTreeMap<u32, Vec3> {
        let mut sums: BTreeMap<u32, Vec3> = BTreeMap::new();
        for (&point, forces) in &self.points {
            let (nodes, _) = domain.functions(point);
            for (node, force) in nodes.iter().zip(forces) {
                *sums.entry(*node).or_default() += force;
            }
        }
        sums
    }

    /// Adds a force that acts at a place, which is of the cell of a point or near it: first order
    /// in the distance, so that force and moment are exact. In the plane it bends by its height
    /// over the midsurface.
    fn add<R: Real>(&mut self, domain: &PlateDomain<R>, point: usize, at: &Vec3, force: &Vec3) {
        let (_, table) = domain.surface.at(point);
        let surface = domain.surface.surface_point(point);
        let [t11, t12, t22] = surface.to_local;
        let [e1, e2] = surface.frame();
        let way = at - surface.place;
        let (x, y, z) = (way.dot(&e1), way.dot(&e2), way.dot(&surface.normal));
        let (along, across) = (force.dot(&e1), force.dot(&e2));
        let own = self.points.entry(point).or_insert([Vec3::zeros(); FUNCTIONS]);
        for (k, sum) in own.iter_mut().enumerate() {
            let [d1, d2] = [0, 1].map(|d| table.derivatives[d][k]);
            let slope = [d1 * t11, d1 * t12 + d2 * t22];
            let value = table.value[k] + x * slope[0] + y * slope[1];
            *sum += force * value;
            *sum -= surface.normal * (z * (along * slope[0] + across * slope[1]));
        }
        self.total += force;
    }
}

/// Points by the square of one spacing that they lie in.
struct PointSquares {
    pitch: f64,
    squares: BTreeMap<[i64; 2], Vec<(usize, Vec3)>>,
}

impl PointSquares {
    fn new<R: Real>(domain: &PlateDomain<R>, pitch: f64) -> Self {
        let mut all = Self { pitch, squares: BTreeMap::new() };
        for point in domain.live() {
            let x = domain.surface.surface_point(point).place;
            all.squares.entry(all.square(&x)).or_default().push((point, x));
        }
        all
    }

    fn square(&self, x: &Vec3) -> [i64; 2] {
        [x.x, x.y].map(|x| (x / self.pitch).floor() as i64)
    }

    /// The point nearest to a place in the plane, the first of several; none farther than a
    /// spacing.
    fn nearest(&self, at: &Vec3) -> Option<usize> {
        let [i, j] = self.square(at);
        let around = (-1..=1).flat_map(|x| (-1..=1).map(move |y| [i + x, j + y]));
        let near = around.filter_map(|square| self.squares.get(&square)).flatten();
        let far = |x: &Vec3| (x.x - at.x).powi(2) + (x.y - at.y).powi(2);
        let least = near.min_by(|a, b| far(&a.1).total_cmp(&far(&b.1)).then(a.0.cmp(&b.0)));
        least.map(|row| row.0)
    }
}

/// The control points of each load.
pub(super) fn pushed<R: Real>(
    specimen: &SpecimenProblem,
    shape: &AlignedPlate,
    domain: &PlateDomain<R>,
) -> Vec<PlateLoad> {
    let spacing = specimen.settings.spacing;
    let squares = PointSquares::new(domain, spacing);
    let is_surface =
        |load: &Load| matches!(load.push, LoadKind::Traction(_) | LoadKind::Pressure(_));
    let surface = specimen.loads.iter().any(is_surface);
    let surface =
        if surface { pieces(&specimen.body.mesh, spacing) } else { Vec::<SurfacePiece>::new() };
    let one = |load: &Load| {
        let mut pushed = PlateLoad::default();
        if !is_surface(load) {
            on_mass(load, shape, domain, &mut pushed);
            return pushed;
        }
        for piece in surface.iter().filter_map(|piece| piece.within(&load.part)) {
            let at = shape.frame.onto(&piece.middle);
            let force = shape.frame.turned(&piece.force(&load.push));
            if let Some(point) = squares.nearest(&at) {
                pushed.add(domain, point, &at, &force);
            }
        }
        pushed
    };
    specimen.loads.iter().map(one).collect()
}

fn on_mass<R: Real>(
    load: &Load,
    shape: &AlignedPlate,
    domain: &PlateDomain<R>,
    pushed: &mut PlateLoad,
) {
    let mut taken = Vec::new();
    for point in domain.live() {
        let (state, surface) = (domain.state(point), domain.surface.surface_point(point));
        for &(z, w) in domain.law.stations.list() {
            let at = surface.place + surface.normal * (z * state.thickness);
            if within(&load.part, &shape.frame.back(&at), 0.0) {
                taken.push((point, at, w * state.area * state.thickness * domain.density));
            }
        }
    }
    let mass: f64 = taken.iter().map(|row| row.2).sum();
    let rate = match load.push {
        LoadKind::Acceleration(acceleration) => acceleration,
        LoadKind::Force(force) if mass > 0.0 => force / mass,
        _ => Vec3::zeros(),
    };
    let rate = shape.frame.turned(&rate);
    for (point, at, mass) in taken.into_iter().filter(|_| rate.norm_squared() > 0.0) {
        pushed.add(domain, point, &at, &(rate * mass));
    }
}
