//! What becomes of a wall that yields: it comes to rest, and its solid takes the shape that is
//! left.

use super::carriers::Carriers;
use super::{ShellSolve, frame};
use crate::domain::ShellDomain;
use cullet_fragment::motion;
use cullet_geometry::hull::{HullSettings, convex_parts};
use cullet_geometry::shapes::refine_solid;
use cullet_geometry::{Mat3, Sheet, Solid, Vec3};
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

/// What takes a place where the wall is now back by the motion of the whole.
struct Straightened {
    from: Vec3,
    to: Vec3,
    turn: Mat3,
}

impl Straightened {
    /// The turn and the shift that leave least of the displacements, mass by mass \[Kabsch 1976\].
    fn of<R: Real, const N: usize>(domain: &ShellDomain<R, N>) -> Self {
        let first = |n: usize| domain.surface.nodes[domain.origin[n] as usize];
        let all = || 0..domain.mass.len();
        let mass: f64 = domain.mass.iter().sum();
        let to = all().map(|n| first(n) * domain.mass[n]).sum::<Vec3>() / mass;
        let moved = all().map(|n| domain.moved(n) * domain.mass[n]).sum::<Vec3>() / mass;
        let from = to + moved;
        let mut spread = Mat3::zeros();
        for n in all() {
            let now = first(n) + domain.moved(n) - from;
            spread += (first(n) - to) * now.transpose() * domain.mass[n];
        }
        let parts = spread.svd(true, true);
        let turn = match (parts.u, parts.v_t) {
            (Some(u), Some(v_t)) => {
                let handed = Vec3::new(1.0, 1.0, (u * v_t).determinant().signum());
                u * Mat3::from_diagonal(&handed) * v_t
            }
            _ => Mat3::identity(),
        };
        Self { from, to, turn }
    }

    fn place(&self, now: &Vec3) -> Vec3 {
        self.to + self.turn * (now - self.from)
    }
}

impl<R: Real, const N: usize> ShellSolve<R, N> {
    /// Whether enough has flowed for a dent.
    pub(super) fn is_dented(&self) -> bool {
        let energy: f64 = self.local.impacts.iter().map(|hit| hit.energy).sum();
        self.record.dissipated > LEAST_DENT.1 * energy
    }

    /// The solid where its midsurface is now, as large as it was: what flows keeps its volume.
    fn bent(&self, straight: &Straightened, points: Vec<(usize, Vec3)>) -> Result<Solid, Failure> {
        let mut solid = refine_solid(&self.local.solid, FINE * self.wall.spacing)
            .map_err(|error| Failure::Cut(error.to_string()))?;
        let carriers = Carriers::new(points, self.wall.spacing);
        let carry = |place: &Vec3| carriers.carry(&self.domain, place);
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
        let straight = Straightened::of(&self.domain);
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
        let solid = self.bent(&straight, points)?;
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
