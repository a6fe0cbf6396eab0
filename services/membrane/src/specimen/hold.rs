//! Supports: what some points may not do.

use super::build;
use super::outline::AlignedSheet;
use crate::bending::BendingStencils;
use crate::steps::SheetRun;
use cullet_geometry::Vec3;
use cullet_specimen::{Drive, Hold, SpecimenProblem, StepTally, within};

/// How far beyond its part a support looks for points where it has none: a row lies half a spacing
/// from its edge \[spacings\].
const ROW: f64 = 0.75;
/// No bond breaks within this many horizons of a point that is held in the plane.
const GUARD: f64 = 2.0;
/// Root of the bending stiffness of a clamp over that of the sheet, a whole number, as coefficients
/// are multiples of a unit \[1\].
const STIFF: f64 = 3.0;
/// Heights of a part that are looked at \[t\]: both faces and the middle.
const HEIGHTS: [f64; 3] = [-0.5, 0.0, 0.5];

/// The points that a support holds.
#[derive(Clone, Debug)]
pub(super) struct HeldRow {
    /// Each with its velocity at 1 of the course \[m/s\].
    points: Vec<(u32, Vec3)>,
    axes: [bool; 3],
}

impl HeldRow {
    pub(super) fn is_empty(&self) -> bool {
        self.points.is_empty()
    }
}

/// What each support holds, of points at rest at `rest` \[m\].
pub(super) fn held(
    specimen: &SpecimenProblem,
    shape: &AlignedSheet,
    rest: &[Vec3],
) -> Vec<HeldRow> {
    let h = specimen.settings.spacing;
    let up = Vec3::ith(shape.axes[2], shape.thickness);
    let one = |hold: &Hold| {
        let inside = |x: &Vec3, slack: f64| {
            HEIGHTS.iter().any(|height| within(&hold.part, &(x + up * *height), slack))
        };
        let of = |slack: f64| -> Vec<(u32, Vec3)> {
            let speed = |x: &Vec3| hold.velocity + hold.gradient * (x - hold.centre);
            let taken = (0u32..).zip(rest).filter(|(_, x)| inside(x, slack));
            taken.map(|(i, x)| (i, speed(x))).collect()
        };
        let exact = of(1e-6 * h);
        let points = if exact.is_empty() { of(ROW * h) } else { exact };
        HeldRow { points, axes: hold.axes }
    };
    specimen.holds.iter().map(one).collect()
}

/// Points whose bonds may not break: all, of what does not break, or those near points that some
/// support holds along both axes of the plane, but for one that holds all.
pub(super) fn guarded(
    specimen: &SpecimenProblem,
    shape: &AlignedSheet,
    held: &[HeldRow],
    rest: &[Vec3],
) -> Vec<bool> {
    if !specimen.settings.breaks {
        return vec![true; rest.len()];
    }
    let reach = GUARD * build::horizon(specimen) * specimen.settings.spacing;
    let in_plane = |row: &&HeldRow| {
        row.points.len() < rest.len() && shape.axes[..2].iter().all(|&axis| row.axes[axis])
    };
    let mut guarded = vec![false; rest.len()];
    for &(p, _) in held.iter().filter(in_plane).flat_map(|row| &row.points) {
        let at = rest[p as usize];
        let near = rest.iter().zip(&mut guarded).filter(|(x, _)| (*x - at).norm() <= reach);
        near.for_each(|(_, guarded)| *guarded = true);
    }
    guarded
}

/// Stiffens the bending of points that are held along all axes. A curvature is that of two spacings
/// around, so that the last rows of a clamp would bend as those beside it do, and the clamp would
/// begin 1.3 spacings too late. How much more the greatest ω² of bending is \[1\].
pub(super) fn stiffen(stencils: &mut BendingStencils, held: &[HeldRow]) -> f64 {
    let clamps = || held.iter().filter(|row| row.axes == [true; 3]);
    for &(p, _) in clamps().flat_map(|row| &row.points) {
        let own = stencils.of(p as usize);
        let most = stencils.most();
        let all = || stencils.terms[own.clone()].iter().flat_map(|term| term.curvature);
        let greatest = all().map(f64::abs).fold(most / STIFF, f64::max);
        let stiff = (most / greatest).floor();
        let terms = stencils.terms[own].iter_mut();
        terms.for_each(|term| term.curvature.iter_mut().for_each(|c| *c *= stiff));
    }
    // Half of what is around a point beside a clamp is held.
    if clamps().next().is_some() { 0.5 * (STIFF * STIFF - 1.0) } else { 0.0 }
}

/// Gives held points their velocities after a step. The first of several supports that hold a
/// point along an axis has the whole force.
pub(super) fn apply(
    run: &mut SheetRun,
    held: &[HeldRow],
    before: &[Vec3],
    drive: &Drive<'_>,
    tally: &mut StepTally,
) {
    let active = || {
        let rows = held.iter().zip(drive.holds).enumerate();
        rows.filter_map(|(k, (row, factor))| Some((k, row, (*factor)?)))
    };
    let mut wanted = vec![[None; 3]; before.len()];
    for (_, row, factor) in active() {
        for (p, velocity) in &row.points {
            for axis in (0..3).filter(|&axis| row.axes[axis]) {
                let own: &mut Option<f64> = &mut wanted[*p as usize][axis];
                *own = Some(own.unwrap_or(0.0) + factor * velocity[axis]);
            }
        }
    }
    tally.reactions = vec![Vec3::zeros(); held.len()];
    for (support, row, _) in active() {
        for p in row.points.iter().map(|own| own.0 as usize) {
            let free = run.state.velocities[p];
            let mut next = free;
            for axis in (0..3).filter(|&axis| row.axes[axis]) {
                next[axis] = wanted[p][axis].take().unwrap_or(next[axis]);
            }
            let push = (next - free) * run.masses[p][1];
            tally.held += push.dot(&(before[p] + next)) / 2.0;
            tally.reactions[support] += push / drive.step;
            run.state.velocities[p] = next;
            // The step has gone half of its way with the free velocity.
            run.state.places[p] += (next - free) * (0.5 * drive.step);
        }
    }
}
