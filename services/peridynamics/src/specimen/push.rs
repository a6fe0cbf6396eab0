//! Loads: what part of them each point takes.

use crate::domain::PeridynamicDomain;
use cullet_geometry::Vec3;
use cullet_specimen::surface::pieces;
use cullet_specimen::{GridFrame, Load, LoadKind, SpecimenProblem, within};
use std::collections::BTreeMap;

/// A load at 1 of its course, by point, in the grid's frame \[N\].
#[derive(Clone, Debug, Default)]
pub(super) struct PushedPoints {
    pub(super) points: Vec<(u32, Vec3)>,
    /// Their sum \[N\].
    pub(super) total: Vec3,
}

/// Points by the cube of one spacing that they lie in.
struct PointCubes<'a> {
    spacing: f64,
    places: &'a [Vec3],
    cubes: BTreeMap<[i64; 3], Vec<u32>>,
}

impl<'a> PointCubes<'a> {
    fn new(places: &'a [Vec3], spacing: f64) -> Self {
        let mut all = Self { spacing, places, cubes: BTreeMap::new() };
        for (p, x) in (0_u32..).zip(places) {
            all.cubes.entry(all.cube(x)).or_default().push(p);
        }
        all
    }

    fn cube(&self, x: &Vec3) -> [i64; 3] {
        [0, 1, 2].map(|a| (x[a] / self.spacing).floor() as i64)
    }

    /// The point nearest to a place, the first of several; none much farther than a spacing.
    fn nearest(&self, at: &Vec3) -> Option<u32> {
        let [i, j, k] = self.cube(at);
        let around = (0..27).map(|c| [i + c / 9 - 1, j + c / 3 % 3 - 1, k + c % 3 - 1]);
        let near = around.filter_map(|cube| self.cubes.get(&cube)).flatten().copied();
        let far = |p: u32| (self.places[p as usize] - at).norm_squared();
        near.min_by(|&a, &b| far(a).total_cmp(&far(b)).then(a.cmp(&b)))
    }
}

/// The points of each load, of points at rest at `places` in the specimen \[m\].
pub(super) fn pushed(
    specimen: &SpecimenProblem,
    frame: &GridFrame,
    (domain, places): (&PeridynamicDomain, &[Vec3]),
) -> Vec<PushedPoints> {
    let spacing = specimen.settings.spacing;
    let is_surface =
        |load: &Load| matches!(load.push, LoadKind::Traction(_) | LoadKind::Pressure(_));
    let some = specimen.loads.iter().any(is_surface);
    let surface = if some { pieces(&specimen.body.mesh, spacing) } else { Vec::new() };
    let cubes = PointCubes::new(places, spacing);
    let one = |load: &Load| {
        let mut forces: BTreeMap<u32, Vec3> = BTreeMap::new();
        if is_surface(load) {
            for piece in surface.iter().filter_map(|piece| piece.within(&load.part)) {
                if let Some(p) = cubes.nearest(&piece.middle) {
                    *forces.entry(p).or_default() += frame.turned(&piece.force(&load.push));
                }
            }
        } else {
            forces = on_mass(load, frame, (domain, places));
        }
        forces.retain(|_, force| force.norm_squared() > 0.0);
        PushedPoints { total: forces.values().sum(), points: forces.into_iter().collect() }
    };
    specimen.loads.iter().map(one).collect()
}

fn on_mass(
    load: &Load,
    frame: &GridFrame,
    (domain, places): (&PeridynamicDomain, &[Vec3]),
) -> BTreeMap<u32, Vec3> {
    let taken = (0_u32..).zip(places).filter(|(_, x)| within(&load.part, x, 0.0));
    let taken: Vec<u32> = taken.map(|row| row.0).collect();
    let mass: f64 = taken.iter().map(|&p| domain.mass(p as usize)).sum();
    let rate = match load.push {
        LoadKind::Acceleration(acceleration) => acceleration,
        LoadKind::Force(force) if mass > 0.0 => force / mass,
        _ => Vec3::zeros(),
    };
    let rate = frame.turned(&rate);
    taken.into_iter().map(|p| (p, rate * domain.mass(p as usize))).collect()
}
