//! What is cut: the shell's points in layers through the thickness, with the part that each is of.

use super::ShellSolve;
use super::crushed::CrushedZones;
use cullet_fragment::debris::{Mote, Motes};
use cullet_fragment::finish::FragmentMotion;
use cullet_fragment::pieces::Pieces;
use cullet_geometry::{Mat3, Vec3};
use cullet_simd::Real;

/// Fewest layers of a plate.
const LAYERS: usize = 3;

/// Points of a part below which it is none of its own (F99).
const LEAST_PART: usize = 8;

/// How far the front of a crack leads on the side that opens, over the thickness: tan 65°.
const LEAN: f64 = 2.1;

/// Speed of a crack over that of Rayleigh waves, for how its front leans.
const PACE: f64 = 0.3;

/// The points of a shell, layer by layer.
pub(super) struct ShellField {
    pub(super) positions: Vec<Vec3>,
    pub(super) damage: Vec<f64>,
    pub(super) times: Vec<f64>,
    pub(super) normals: Vec<Vec3>,
    pub(super) pieces: Pieces,
    /// Of the axes, so that layers are as far apart as points are.
    pub(super) stretch: Vec3,
    /// How each point moves, mass by mass.
    velocities: Vec<Vec3>,
    masses: Vec<f64>,
}

impl ShellField {
    pub(super) fn new<R: Real, const N: usize>(solve: &ShellSolve<R, N>) -> Self {
        let (domain, wall) = (&solve.domain, &solve.wall);
        let (t, apart) = (wall.typical, 0.5 * wall.spacing);
        let layers = match wall.is_flat {
            true => ((t / apart).ceil() as usize).max(LAYERS),
            false => ((t / apart).round() as usize).max(1),
        };
        let across = if wall.is_flat { apart * layers as f64 / t } else { 1.0 };
        let labels = domain.parts(LEAST_PART);
        let count = labels.iter().flatten().max().map_or(0, |most| most + 1);
        let mut field = Self {
            positions: Vec::new(),
            damage: Vec::new(),
            times: Vec::new(),
            normals: Vec::new(),
            pieces: Pieces { found: count, ..Pieces::default() },
            stretch: Vec3::new(1.0, 1.0, across),
            velocities: Vec::new(),
            masses: Vec::new(),
        };
        let (seed, spacing) = (solve.local.seed, wall.spacing);
        let crushed = CrushedZones::new(domain, t, spacing, seed);
        let cell = Vec3::repeat(spacing).component_div(&field.stretch);
        let rubble = crushed.rubble(&cell, t, seed);
        field.pieces.crushed = crushed.points.len() as f64 / domain.live().count().max(1) as f64;
        let pace = PACE * solve.local.material.rayleigh_speed();
        for layer in 0..layers {
            let share = (layer as f64 + 0.5) / layers as f64 - 0.5;
            for point in domain.live() {
                let t = domain.state(point).thickness;
                let z = share * t;
                let (state, at) = (domain.state(point), domain.surface.surface_point(point));
                let broken = state.is_broken() || state.dead;
                let side = state.crack.map_or(0.0, |crack| crack.side * crack.bending_share);
                let late = (0.5 * t * side.abs() - side * z) * LEAN / pace;
                field.positions.push(at.place + at.normal * z);
                field.damage.push(if broken { 1.0 } else { state.damage.min(0.89) });
                field.times.push(domain.broken_at(point) + late);
                field.normals.push(domain.crack_normal(point));
                let drawn = crushed.points.binary_search(&(point as u32)).is_ok();
                let near = || {
                    let at = at.place.component_div(&cell);
                    rubble.nearest(0..rubble.balls.len() as u32, &at).map(|ball| count + ball)
                };
                field.pieces.of.push(match broken {
                    true if drawn => near(),
                    true => None,
                    false => labels[point],
                });
                field.velocities.push(domain.interpolate(point, &domain.velocity));
                field.masses.push(state.area * t);
            }
        }
        field.pieces.rubble = rubble;
        field
    }

    /// The motion of each part, from that of its points.
    pub(super) fn motions(&self, part_of: &[u32], parts: usize) -> Vec<FragmentMotion> {
        let mut sums = vec![(0.0, Vec3::zeros(), Vec3::zeros()); parts];
        let each = || part_of.iter().enumerate().map(|(p, &part)| (p, part as usize));
        for (p, part) in each().filter(|&(_, part)| part < parts) {
            let m = self.masses[p];
            sums[part].0 += m;
            sums[part].1 += self.positions[p] * m;
            sums[part].2 += self.velocities[p] * m;
        }
        let means: Vec<(Vec3, Vec3)> = sums
            .iter()
            .map(|&(m, x, v)| if m > 0.0 { (x / m, v / m) } else { Default::default() })
            .collect();
        let mut turns = vec![(Vec3::zeros(), Mat3::zeros(), 0); parts];
        for (p, part) in each().filter(|&(_, part)| part < parts) {
            let (r, slip) = (self.positions[p] - means[part].0, self.velocities[p] - means[part].1);
            let square = Mat3::identity() * r.norm_squared() - r * r.transpose();
            turns[part].0 += r.cross(&slip) * self.masses[p];
            turns[part].1 += square * self.masses[p];
            turns[part].2 += 1;
        }
        let motion =
            |((momentum, inertia, points), (_, velocity)): (&(Vec3, Mat3, i32), &(Vec3, Vec3))| {
                let inverse = inertia.try_inverse().filter(|_| *points >= 12);
                (*velocity, inverse.map_or(Vec3::zeros(), |inverse| inverse * momentum))
            };
        turns.iter().zip(&means).map(motion).collect()
    }

    /// How the point nearest to a place moves \[m/s\].
    pub(super) fn velocity_at(&self, place: &Vec3) -> Vec3 {
        let far = |p: &usize| (self.positions[*p] - place).norm_squared();
        let nearest = (0..self.positions.len()).min_by(|a, b| far(a).total_cmp(&far(b)));
        nearest.map_or_else(Vec3::zeros, |p| self.velocities[p])
    }

    /// The broken points and how they move.
    pub(super) fn motes(&self, reach: f64) -> Motes {
        let broken = (0..self.positions.len()).filter(|&p| self.damage[p] >= 1.0);
        let mote = |p: usize| Mote { place: self.positions[p], velocity: self.velocities[p] };
        Motes { all: broken.map(mote).collect(), reach }
    }
}
