//! Loads: what part of them each point takes.

use super::outline::AlignedSheet;
use crate::cells::PlaneGrid;
use cullet_geometry::Vec3;
use cullet_model::SheetPlace;
use cullet_specimen::surface::pieces;
use cullet_specimen::{Load, LoadKind, SpecimenProblem, within};
use std::collections::BTreeMap;

/// How far the nearest point to a piece of the surface is looked for \[spacings\].
const NEAR: f64 = 2.0;

/// A load at 1 of its course, by point \[N\].
#[derive(Clone, Debug, Default)]
pub(super) struct PushedRow {
    pub(super) points: Vec<(u32, Vec3)>,
    /// Their sum \[N\].
    pub(super) total: Vec3,
}

/// The points of each load, of a sheet with these points and masses \[kg\].
pub(super) fn pushed(
    specimen: &SpecimenProblem,
    shape: &AlignedSheet,
    places: &[SheetPlace],
    masses: &[[f64; 2]],
) -> Vec<PushedRow> {
    let spacing = specimen.settings.spacing;
    let is_surface =
        |load: &Load| matches!(load.push, LoadKind::Traction(_) | LoadKind::Pressure(_));
    let some = specimen.loads.iter().any(is_surface);
    let surface = if some { pieces(&specimen.body.mesh, spacing) } else { Vec::new() };
    let grid = PlaneGrid::new(places, NEAR * spacing);
    let nearest = |x: &Vec3| {
        let at = [x[shape.axes[0]], x[shape.axes[1]]];
        let mut best: Option<(f64, u32)> = None;
        grid.around(at, NEAR * spacing, |i| {
            let [a, b] = places[i as usize];
            let far = (a - at[0]) * (a - at[0]) + (b - at[1]) * (b - at[1]);
            if best.is_none_or(|(least, first)| far < least || (far == least && i < first)) {
                best = Some((far, i));
            }
        });
        best.map(|(_, i)| i)
    };
    let one = |load: &Load| {
        let mut forces: BTreeMap<u32, Vec3> = BTreeMap::new();
        if is_surface(load) {
            for piece in surface.iter().filter_map(|piece| piece.within(&load.part)) {
                if let Some(i) = nearest(&piece.middle) {
                    *forces.entry(i).or_default() += piece.force(&load.push);
                }
            }
        } else {
            forces = on_mass(load, shape, places, masses);
        }
        forces.retain(|_, force| force.norm_squared() > 0.0);
        PushedRow { total: forces.values().sum(), points: forces.into_iter().collect() }
    };
    specimen.loads.iter().map(one).collect()
}

fn on_mass(
    load: &Load,
    shape: &AlignedSheet,
    places: &[SheetPlace],
    masses: &[[f64; 2]],
) -> BTreeMap<u32, Vec3> {
    let inside = |place: &SheetPlace| within(&load.part, &shape.place(*place, 0.0), 0.0);
    let taken = (0u32..).zip(places).filter(|(_, place)| inside(place));
    let taken: Vec<(u32, f64)> = taken.map(|(i, _)| (i, masses[i as usize][0])).collect();
    let mass: f64 = taken.iter().map(|row| row.1).sum();
    let rate = match load.push {
        LoadKind::Acceleration(acceleration) => acceleration,
        LoadKind::Force(force) if mass > 0.0 => force / mass,
        _ => Vec3::zeros(),
    };
    taken.into_iter().map(|(i, own)| (i, rate * own)).collect()
}
