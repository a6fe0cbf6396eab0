//! Supports: what some points may not do.

use super::mirror::MirrorSet;
use crate::domain::PeridynamicDomain;
use cullet_geometry::Vec3;
use cullet_specimen::{Drive, GridFrame, Hold, SpecimenProblem, within};

/// How far outside of a part a point may be that it holds \[spacings\]: places are rounded.
const SLACK: f64 = 1e-3;

/// The points that a support holds by themselves.
#[derive(Clone, Debug)]
pub(super) struct HeldPoints {
    /// Each with its velocity at 1 of the course in the specimen's frame \[m/s\].
    points: Vec<(u32, Vec3)>,
    /// Along which axes of the specimen.
    axes: [bool; 3],
}

/// What supports do to the velocities of a step.
#[derive(Clone, Debug, Default)]
pub(super) struct HeldStep {
    /// Velocities after it \[m/s\].
    pub(super) velocities: Vec<Vec3>,
    /// Work of the supports \[J\].
    pub(super) work: f64,
    /// Force of each on the body \[N\].
    pub(super) reactions: Vec<Vec3>,
}

impl HeldPoints {
    /// Whether it holds nothing.
    pub(super) fn is_empty(&self) -> bool {
        self.points.is_empty()
    }
}

/// What each support holds, of points at rest at `places` in the specimen \[m\]. One that lies on
/// a side of the body holds what is behind that instead.
pub(super) fn held(
    specimen: &SpecimenProblem,
    mirrors: &MirrorSet,
    places: &[Vec3],
) -> Vec<HeldPoints> {
    let slack = SLACK * specimen.settings.spacing;
    let one = |(index, hold): (usize, &Hold)| {
        let taken = |x: &Vec3| !mirrors.has_support(index) && within(&hold.part, x, slack);
        let inside = (0_u32..).zip(places).filter(|(_, x)| taken(x));
        let speed = |x: &Vec3| hold.velocity + hold.gradient * (x - hold.centre);
        HeldPoints { points: inside.map(|(p, x)| (p, speed(x))).collect(), axes: hold.axes }
    };
    specimen.holds.iter().enumerate().map(one).collect()
}

/// The velocities that a step with the forces of now ends with, as supports have them. The first of
/// several supports that hold a point along an axis has the whole force.
pub(super) fn hold(
    domain: &PeridynamicDomain,
    frame: &GridFrame,
    (held, mirrors): (&[HeldPoints], &MirrorSet),
    drive: &Drive<'_>,
) -> HeldStep {
    let before = &domain.velocities;
    let free = |p: usize| before[p] + domain.forces[p] * (drive.step / domain.mass(p));
    let mut velocities: Vec<Vec3> = (0..before.len()).map(free).collect();
    let active = || {
        let rows = held.iter().zip(drive.holds).enumerate();
        rows.filter_map(|(k, (held, factor))| Some((k, held, (*factor)?)))
    };
    let mut wanted = vec![Vec3::zeros(); domain.own];
    for (_, held, factor) in active() {
        for (p, velocity) in &held.points {
            for axis in (0..3).filter(|&a| held.axes[a]) {
                wanted[*p as usize][axis] += factor * velocity[axis];
            }
        }
    }
    let (mut work, mut reactions) = (0.0, vec![Vec3::zeros(); held.len()]);
    for (support, held, _) in active() {
        let mut sum = Vec3::zeros();
        for p in held.points.iter().map(|row| row.0 as usize) {
            let mut local = frame.unturned(&velocities[p]);
            for axis in (0..3).filter(|&a| held.axes[a]) {
                local[axis] = wanted[p][axis];
            }
            let now = frame.turned(&local);
            let push = (now - velocities[p]) * domain.mass(p);
            work += push.dot(&(before[p] + now)) / 2.0;
            sum += push;
            velocities[p] = now;
        }
        reactions[support] = sum / drive.step;
    }
    let images = mirrors.apply(domain, frame, drive, &mut velocities);
    for (reaction, more) in reactions.iter_mut().zip(&images.reactions) {
        *reaction += frame.turned(more);
    }
    HeldStep { velocities, work: work + images.work, reactions }
}
