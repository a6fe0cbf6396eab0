//! What becomes of a wall that yields: it comes to rest, and its solid takes the shape that is
//! left.

use super::{ShellSolve, frame};
use cullet_fragment::carriers::Carriers;
use cullet_fragment::motion;
use cullet_fragment::straightened::Straightened;
use cullet_geometry::hull::{HullSettings, convex_parts};
use cullet_geometry::shapes::refine_solid;
use cullet_geometry::{Sheet, Solid, Vec3};
use cullet_model::{Deformation, Failure, Fragment, Fragmentation, SolveOutcome};
use cullet_simd::Real;
use rayon::prelude::*;

/// Share of the thickness that a place must have moved for good to be worth a new shape, and of the
/// energy of the hits that must have gone into that \[1\].
const LEAST_DENT: (f64, f64) = (0.05, 1e-2);

/// Rounds in which its volume becomes what it was, to rounding.
const ROUNDS: usize = 8;

/// Longest edge of the new solid over the size of a cell \[1\].
const FINE: f64 = 1.0;

impl<R: Real, const N: usize> ShellSolve<R, N> {
    /// Whether enough has flowed for a dent.
    pub(super) fn is_dented(&self) -> bool {
        let energy: f64 = self.local.impacts.iter().map(|hit| hit.energy).sum();
        self.record.dissipated > LEAST_DENT.1 * energy
    }

    /// The solid where its midsurface is now, as large as it was: what flows keeps its volume.
    fn bent(&self, straight: &Straightened, points: &[(usize, Vec3)]) -> Result<Solid, Failure> {
        let mut solid = refine_solid(&self.local.solid, FINE * self.wall.spacing)
            .map_err(|error| Failure::Cut(error.to_string()))?;
        let places = points.iter().map(|point| point.1).collect();
        let carriers = Carriers::new(places, self.wall.spacing);
        let carry = |place: &Vec3| {
            let mut sum = [Vec3::zeros(); 2];
            for (k, share) in carriers.shares(place) {
                let parts = self.domain.carried(points[k].0, place);
                (0..2).for_each(|part| sum[part] += parts[part] * share);
            }
            sum
        };
        let places: Vec<[Vec3; 2]> = solid.mesh.vertices.par_iter().map(carry).collect();
        let (volume, mut thick) = (self.local.solid.mesh.signed_volume(), 1.0);
        for _ in 0..ROUNDS {
            for (vertex, [base, over]) in solid.mesh.vertices.iter_mut().zip(&places) {
                *vertex = straight.place(&(base + over * thick));
            }
            // The volume of a thin wall goes as its thickness.
            thick *= volume / solid.mesh.signed_volume();
        }
        Ok(solid)
    }

    /// The body in its new shape; as it was, where that is the old one.
    pub(super) fn finish_metal(&mut self) -> Result<SolveOutcome, Failure> {
        let (first, now) = self.domain.node_places();
        let straight = Straightened::of(&self.domain.mass, &first, &now);
        let points: Vec<(usize, Vec3)> =
            self.domain.live().map(|p| (p, self.domain.surface.surface_point(p).place)).collect();
        let dent = |&(p, place): &(usize, Vec3)| {
            (straight.place(&self.domain.carried(p, &place)[0]) - place).norm()
        };
        let deepest = points.iter().map(dent).fold(0.0, f64::max);
        if !self.is_dented() || deepest < LEAST_DENT.0 * self.wall.typical {
            return self.finish().map(SolveOutcome::from);
        }
        self.check()?;
        let solid = self.bent(&straight, &points)?;
        let work = self.record.dissipated;
        let report = self
            .report(&[])
            .with("plastic_work", "J", work)
            .with("vibration", "J", self.settling.taken)
            .with("dent", "m", deepest);
        let fragment = Fragment {
            hulls: convex_parts(&solid, HullSettings::default()),
            solid,
            velocity: Vec3::zeros(),
            spin: Vec3::zeros(),
            sheet: Sheet::default(),
        };
        let mut whole = Fragmentation { fragments: vec![fragment], ..Fragmentation::default() };
        motion::balance(&mut whole.fragments, &self.pushes(), self.local.material.density);
        let mut whole = frame::from_local(whole, &self.wall.pose);
        let Some(Fragment { solid, hulls, velocity, spin, .. }) = whole.fragments.pop() else {
            return self.finish().map(SolveOutcome::from);
        };
        let (body, reactions) = (solid.into(), self.reactions());
        let made = Deformation { body, hulls, velocity, spin, work, reactions, report };
        Ok(SolveOutcome::Deformed(Box::new(made)))
    }
}
