//! What holds parts of a soft solid: prescribed paths, and the strip around them that does not
//! break.

use super::grid::PointCells;
use cullet_continuum::GripPath;
use cullet_continuum::bytes::held;
use cullet_geometry::{Pose, Vec3};
use cullet_model::{BodyGrip, Refusal};
use nalgebra::Point3;

/// No bond breaks within this many horizons of a held point: a clamp concentrates stress, and the
/// body would tear along it.
const GUARD: f64 = 2.0;
/// A point that nothing holds.
pub(super) const FREE: u32 = u32::MAX;
/// Strength of guarded points over that of others \[1\].
const UNBREAKABLE: f64 = 1e9;

/// A grip and the points that it holds.
#[derive(Clone, Debug)]
pub(super) struct LedPoints {
    /// Rising.
    pub(super) points: Vec<u32>,
    /// Where each is before anything moves, in the world \[m\].
    places: Vec<Vec3>,
    /// What it turns about, likewise \[m\].
    middle: Vec3,
    /// Points near enough that their bonds do not break.
    guarded: Vec<u32>,
    path: GripPath,
}

impl LedPoints {
    /// Memory that it takes \[bytes\].
    pub(super) fn bytes(&self) -> u64 {
        held(&self.points) + held(&self.places) + held(&self.guarded)
    }

    /// Of all grips of a body with points at `places` \[m\] in its own frame.
    ///
    /// # Errors
    ///
    /// If a grip holds no point or its path does not run forwards.
    pub(super) fn of_all(
        grips: &[BodyGrip],
        places: &[Vec3],
        pose: &Pose,
        horizon: f64,
    ) -> Result<Vec<Self>, Refusal> {
        let world = |x: &Vec3| (pose * Point3::from(*x)).coords;
        let reach = GUARD * horizon;
        let of = |(k, grip): (usize, &BodyGrip)| {
            let number = k + 1;
            let held = |&i: &u32| grip.region.has(&places[i as usize]);
            let points: Vec<u32> = (0..places.len() as u32).filter(held).collect();
            if points.is_empty() {
                return Err(Refusal::Idle { what: "grip", number });
            }
            let own: Vec<Vec3> = points.iter().map(|&i| places[i as usize]).collect();
            let cells = PointCells::new(&own, reach);
            let near = |&i: &u32| {
                let mut found = false;
                cells.around(&places[i as usize], 1, |k| {
                    found |= (own[k as usize] - places[i as usize]).norm() <= reach;
                });
                found
            };
            Ok(Self {
                places: own.iter().map(world).collect(),
                middle: world(&grip.region.middle()),
                guarded: (0..places.len() as u32).filter(near).collect(),
                path: GripPath::of(grip, number, super::NAME)?,
                points,
            })
        };
        grips.iter().enumerate().map(of).collect()
    }

    /// Whether it holds in a step of the world that begins at this time \[s\].
    pub(super) fn holds(&self, time: f64) -> bool {
        self.path.holds(time)
    }

    /// Where its `k`-th point is at a time \[s\], and how fast it moves \[m\], \[m/s\].
    pub(super) fn leads(&self, k: usize, time: f64) -> (Vec3, Vec3) {
        self.path.leads(&self.places[k], &self.middle, time)
    }
}

/// What grips do in one step of the world.
#[derive(Clone, Debug, Default)]
pub(super) struct GripsNow {
    /// Number of the first grip that holds each point, or [`FREE`].
    pub(super) holders: Vec<u32>,
    /// Strength of each point over that of others \[1\].
    pub(super) strengths: Vec<f64>,
}

impl GripsNow {
    /// What holds at this time \[s\]; whether that is other than before.
    pub(super) fn update(&mut self, grips: &[LedPoints], count: usize, time: f64) -> bool {
        let before = std::mem::take(&mut self.holders);
        self.holders.resize(count, FREE);
        self.strengths.clear();
        self.strengths.resize(count, 1.0);
        for (number, grip) in grips.iter().enumerate().rev().filter(|(_, grip)| grip.holds(time)) {
            grip.points.iter().for_each(|&i| self.holders[i as usize] = number as u32);
            grip.guarded.iter().for_each(|&i| self.strengths[i as usize] = UNBREAKABLE);
        }
        before != self.holders
    }
}
